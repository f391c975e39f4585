//! The list of process nodes, and the file around it.

use roxmltree::Node;

use super::depth::{Depth, Depths};
use super::{functions, tables};
use crate::lut::LutError;
use crate::lut::text::short;
use crate::lut::xml::{self, elements, error, name};
use crate::process::{Process, Step};

/// Maximum number of process nodes.
const MAX_NODES: usize = 64;

/// Maximum number of 3-D tables, each of which is a texture of one pass.
const MAX_CUBES: usize = 4;

/// Names of the elements besides process nodes.
const METADATA: [&str; 5] = ["Description", "InputDescriptor", "OutputDescriptor", "Info", "Id"];

/// Names of the process nodes.
const NODES: &str = "`LUT1D`, `LUT3D`, `Matrix`, `Range`, `Log`, `Exponent` and `ASC_CDL`";

/// Parses a file in Common LUT Format. Its numbers are normalized: 1 is the largest code of an integer bit depth.
///
/// # Errors
/// The first error, with its line: XML that cannot be read, another version, an unknown element or attribute, bit
/// depths that do not meet, a node that is not what the specification requires, more than 64 nodes or four 3-D tables.
pub fn parse_clf(text: &str) -> Result<Process, LutError> {
    let document = xml::parse(text)?;
    let root = document.root_element();
    if matches!(name(root), "ColorCorrection" | "ColorCorrectionCollection" | "ColorDecisionList") {
        return Err(error(root, "the file is a color correction: use a node `Cdl`"));
    }
    if name(root) != "ProcessList" {
        return Err(error(root, format!("the file is no `ProcessList`, but a `{}`", short(name(root)))));
    }
    version(root)?;
    let nodes: Vec<Node<'_, '_>> = elements(root).filter(|node| !METADATA.contains(&name(*node))).collect();
    if nodes.is_empty() {
        return Err(error(root, format!("there is no process node: there are {NODES}")));
    }
    if let Some(node) = nodes.get(MAX_NODES) {
        return Err(error(*node, format!("there are more than {MAX_NODES} process nodes")));
    }
    let mut steps = Vec::new();
    let mut before: Option<Depth<'_>> = None;
    for node in nodes {
        let depths = Depths::read(node)?;
        depths.follow(node, before)?;
        before = Some(depths.output);
        steps.push(step(node, depths)?);
        let cubes = steps.iter().filter(|step| matches!(step, Step::Cube(..))).count();
        if cubes > MAX_CUBES {
            return Err(error(node, format!("there are more than {MAX_CUBES} 3-D tables")));
        }
    }
    Ok(Process::new(steps))
}

/// Accepts versions 2 and 3, and that of SMPTE ST 2136-1, which is version 3 with a name of its own.
fn version(root: Node<'_, '_>) -> Result<(), LutError> {
    let is_smpte = root.tag_name().namespace().is_some_and(|space| space.contains("smpte-ra.org/ns/2136-1"));
    match root.attribute("compCLFversion").map(str::trim) {
        None if is_smpte => Ok(()),
        Some("2" | "2.0" | "3" | "3.0" | "ST2136-1:2024") => Ok(()),
        None => Err(error(root, "`ProcessList` has no attribute `compCLFversion`")),
        Some(other) => Err(error(root, format!("the version is 2.0, 3.0 or ST2136-1:2024, not `{}`", short(other)))),
    }
}

fn step(node: Node<'_, '_>, depths: Depths<'_>) -> Result<Step, LutError> {
    match name(node) {
        "Matrix" => functions::matrix(node, depths),
        "Range" => functions::range(node, depths),
        "Log" => functions::log(node),
        "Exponent" => functions::exponent(node),
        "ASC_CDL" => functions::cdl(node),
        "LUT1D" => tables::curve(node, depths.output.scale),
        "LUT3D" => tables::cube(node, depths.output.scale),
        other => Err(error(node, format!("`{}` is no process node; there are {NODES}", short(other)))),
    }
}
