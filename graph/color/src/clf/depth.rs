//! Common content of process nodes: bit depths, names, and values per channel.

use roxmltree::Node;

use crate::lut::LutError;
use crate::lut::text::short;
use crate::lut::xml::{self, attribute, elements, error, name};

/// A bit depth: its name, and the number that stands for 1.
#[derive(Clone, Copy)]
pub(super) struct Depth<'a> {
    name: &'a str,
    pub(super) scale: f64,
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
pub(super) struct Depths<'a> {
    pub(super) input: Depth<'a>,
    pub(super) output: Depth<'a>,
}

impl<'a> Depths<'a> {
    pub(super) fn read(node: Node<'a, '_>) -> Result<Self, LutError> {
        Ok(Self { input: Depth::read(node, "inBitDepth")?, output: Depth::read(node, "outBitDepth")? })
    }

    /// The input has the bit depth of the output before.
    pub(super) fn follow(&self, node: Node<'_, '_>, before: Option<Depth<'_>>) -> Result<(), LutError> {
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

/// Refuses attributes besides these and those of every process node.
pub(super) fn only(node: Node<'_, '_>, attributes: &[&str], names: &[&str]) -> Result<(), LutError> {
    let attributes = [&["id", "name", "inBitDepth", "outBitDepth"], attributes].concat();
    xml::only(node, &attributes, &[&["Description"], names].concat())
}

/// An error if the numbers are too large for 32 bits.
pub(super) fn usable(node: Node<'_, '_>, numbers: &[f64]) -> Result<(), LutError> {
    match numbers.iter().all(|x| x.abs() <= 1e15) {
        true => Ok(()),
        false => Err(error(node, format!("the numbers of `{}` lead beyond 1e15", name(node)))),
    }
}

/// The values of the three channels, from elements that state a channel each, or one that states none. A channel
/// without an element has `default`, if there is one.
pub(super) fn channels<T: Copy>(
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
