//! Reasons for which an inspected wire has no image.

use afterimage_graph::node::PortType;

use crate::model::Model;

/// The reason for which the inspected wire has no image.
pub(super) fn lacking(model: &Model) -> Option<&'static str> {
    let wire = model.inspector().wire()?;
    if model.inspected_image().is_some() {
        return None;
    }
    Some(match model.editor().checked().and_then(|checked| checked.wire_type(&wire.wire)) {
        Some(PortType::Table) => "A table has no image: its numbers are in the bar above.",
        Some(PortType::Value) => "A value has no image: its numbers are in the bar above.",
        Some(PortType::Block) => "A host gives this block: it has no image.",
        Some(PortType::Multisampled) => "A host gives this image: look at its `Resolve`.",
        _ if model.inspector().is_compiling() => "Compiling…",
        _ => "No pass of the plan makes it: the node is skipped, or nothing reads it.",
    })
}
