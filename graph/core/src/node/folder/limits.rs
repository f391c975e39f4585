//! Limits of what a `node.ron` declares: a device binds a fixed number of resources in a pass.

use super::declaration::Declaration;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Location};
use afterimage_wgsl::limits::{FILES, IMAGES, INPUTS, Limit, OUTPUTS, PARAMETERS};

pub(super) fn check(declared: Option<&Declaration>, files: usize, diagnostics: &mut Diagnostics) {
    let Some(declared) = declared else { return };
    let mut check = |limit: Limit, count: usize, location: &Location| {
        if let Some(message) = limit.exceeded(count) {
            diagnostics.push(Diagnostic::error("limit", message).at(location, ""));
        }
    };
    check(FILES, files, &declared.name.location);
    check(INPUTS, declared.inputs.len(), last(declared.inputs.iter().map(|(_, location)| location), declared));
    let (outputs, images): (Vec<_>, Vec<_>) = declared.made.iter().partition(|made| made.port.is_some());
    check(IMAGES, images.len(), last(images.iter().map(|image| &image.name.location), declared));
    check(OUTPUTS, outputs.len(), &declared.name.location);
    check(PARAMETERS, declared.params.len(), last(declared.params.iter().map(|(_, location)| location), declared));
}

/// The location of the last one, or else of the kind's name.
fn last<'d>(all: impl Iterator<Item = &'d Location>, declared: &'d Declaration) -> &'d Location {
    all.last().unwrap_or(&declared.name.location)
}
