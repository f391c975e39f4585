//! Common LUT Format files: version 3 (Academy S-2014-006, SMPTE ST 2136-1), and files of version 2 that use only what
//! version 3 has.

mod functions;
mod tables;

use roxmltree::Node;

use super::LutError;
use super::text::short;
use super::xml::{self, attribute, elements, error, name};
use crate::process::{Process, Step};

/// Maximum number of process nodes.
const MOST_NODES: usize = 64;

/// Maximum number of 3-D tables, each of which is a texture of one pass.
const MOST_CUBES: usize = 4;

/// Names of the elements beside process nodes.
const METADATA: [&str; 5] = ["Description", "InputDescriptor", "OutputDescriptor", "Info", "Id"];

/// Names of the process nodes.
const NODES: &str = "`LUT1D`, `LUT3D`, `Matrix`, `Range`, `Log`, `Exponent` and `ASC_CDL`";

/// Parses a file in Common LUT Format. Its numbers are normalised: 1 is the largest code of an integer bit depth.
///
/// # Errors
/// The first error, with its line: XML that cannot be read, another version, an unknown element or attribute, bit
/// depths that do not meet, a node that is not what the specification requires, more than 64 nodes or four 3-D tables.
pub fn parse_clf(text: &str) -> Result<Process, LutError> {
    let document = xml::parse(text)?;
    let root = document.root_element();
    if matches!(name(root), "ColorCorrection" | "ColorCorrectionCollection" | "ColorDecisionList") {
        return Err(error(root, "the file is a colour correction: use a node `Cdl`"));
    }
    if name(root) != "ProcessList" {
        return Err(error(root, format!("the file is no `ProcessList`, but a `{}`", short(name(root)))));
    }
    version(root)?;
    let nodes: Vec<Node<'_, '_>> = elements(root).filter(|node| !METADATA.contains(&name(*node))).collect();
    if nodes.is_empty() {
        return Err(error(root, format!("there is no process node: there are {NODES}")));
    }
    if let Some(node) = nodes.get(MOST_NODES) {
        return Err(error(*node, format!("there are more than {MOST_NODES} process nodes")));
    }
    let mut steps = Vec::new();
    let mut before: Option<Depth<'_>> = None;
    for node in nodes {
        let depths = Depths::read(node)?;
        depths.follow(node, before)?;
        before = Some(depths.output);
        steps.extend(step(node, depths)?);
        let cubes = steps.iter().filter(|step| matches!(step, Step::Cube(..))).count();
        if cubes > MOST_CUBES {
            return Err(error(node, format!("there are more than {MOST_CUBES} 3-D tables")));
        }
    }
    Ok(Process::new(steps))
}

/// Accepts versions 2 and 3, and the namespace of SMPTE, which stands for version 3.
fn version(root: Node<'_, '_>) -> Result<(), LutError> {
    let is_smpte = root.tag_name().namespace().is_some_and(|space| space.contains("smpte-ra.org/ns/2136-1"));
    match root.attribute("compCLFversion").map(str::trim) {
        None if is_smpte => Ok(()),
        Some("2" | "2.0" | "3" | "3.0") => Ok(()),
        None => Err(error(root, "`ProcessList` has no attribute `compCLFversion`")),
        Some(other) => Err(error(root, format!("the version is 2.0 or 3.0, not `{}`", short(other)))),
    }
}

fn step(node: Node<'_, '_>, depths: Depths<'_>) -> Result<Vec<Step>, LutError> {
    match name(node) {
        "Matrix" => functions::matrix(node, depths).map(|step| vec![step]),
        "Range" => functions::range(node, depths).map(|step| vec![step]),
        "Log" => functions::log(node).map(|step| vec![step]),
        "Exponent" => functions::exponent(node).map(|step| vec![step]),
        "ASC_CDL" => functions::cdl(node).map(|step| vec![step]),
        "LUT1D" => tables::curve(node, depths.output.scale).map(|step| vec![step]),
        "LUT3D" => tables::cube(node, depths.output.scale).map(|step| vec![step]),
        other => Err(error(node, format!("`{}` is no process node; there are {NODES}", short(other)))),
    }
}

/// A bit depth: its name, and the number that stands for 1.
#[derive(Clone, Copy)]
struct Depth<'a> {
    name: &'a str,
    scale: f64,
}

impl<'a> Depth<'a> {
    fn read(node: Node<'a, '_>, key: &str) -> Result<Self, LutError> {
        let name = attribute(node, key)?.trim();
        let scale = match name {
            "8i" => 255.0,
            "10i" => 1023.0,
            "12i" => 4095.0,
            "16i" => 65535.0,
            "16f" | "32f" => 1.0,
            _ => {
                let known = "`8i`, `10i`, `12i`, `16i`, `16f` or `32f`";
                return Err(error(node, format!("`{key}` is {known}, not `{}`", short(name))));
            }
        };
        Ok(Self { name, scale })
    }
}

/// The bit depths of a process node.
#[derive(Clone, Copy)]
struct Depths<'a> {
    input: Depth<'a>,
    output: Depth<'a>,
}

impl<'a> Depths<'a> {
    fn read(node: Node<'a, '_>) -> Result<Self, LutError> {
        Ok(Self { input: Depth::read(node, "inBitDepth")?, output: Depth::read(node, "outBitDepth")? })
    }

    /// The input has the bit depth of the output before.
    fn follow(&self, node: Node<'_, '_>, before: Option<Depth<'_>>) -> Result<(), LutError> {
        match before {
            Some(before) if before.name != self.input.name => {
                let message =
                    format!("`inBitDepth` is `{}`, but the node before has `{}`", self.input.name, before.name);
                Err(error(node, message))
            }
            _ => Ok(()),
        }
    }
}

/// Refuses attributes beside these and those of every process node.
fn only(node: Node<'_, '_>, attributes: &[&str], names: &[&str]) -> Result<(), LutError> {
    let attributes = [&["id", "name", "inBitDepth", "outBitDepth"], attributes].concat();
    xml::only(node, &attributes, &[&["Description"], names].concat())
}

/// An error if the numbers are too large for 32 bits.
fn usable(node: Node<'_, '_>, numbers: &[f64]) -> Result<(), LutError> {
    match numbers.iter().all(|x| x.abs() <= 1e15) {
        true => Ok(()),
        false => Err(error(node, format!("the numbers of `{}` lead beyond 1e15", name(node)))),
    }
}

/// The values of the three channels, from elements that state a channel each, or one that states none. A channel
/// without an element has `default`, if there is one.
fn channels<T: Copy>(
    node: Node<'_, '_>,
    key: &str,
    default: Option<T>,
    read: impl Fn(Node<'_, '_>) -> Result<T, LutError>,
) -> Result<[T; 3], LutError> {
    let mut found = [None; 3];
    for params in elements(node).filter(|element| name(*element) == key) {
        let of = match params.attribute("channel") {
            None => 0..3,
            Some("R") => 0..1,
            Some("G") => 1..2,
            Some("B") => 2..3,
            Some(other) => return Err(error(params, format!("a channel is `R`, `G` or `B`, not `{}`", short(other)))),
        };
        let value = read(params)?;
        for slot in &mut found[of] {
            if slot.replace(value).is_some() {
                return Err(error(params, format!("a channel has several `{key}`")));
            }
        }
    }
    if found.iter().all(Option::is_none) {
        return Err(error(node, format!("`{}` has no `{key}`", name(node))));
    }
    let missing = || error(node, format!("a channel has no `{key}`"));
    let [red, green, blue] = found.map(|value| value.or(default).ok_or_else(missing));
    Ok([red?, green?, blue?])
}
