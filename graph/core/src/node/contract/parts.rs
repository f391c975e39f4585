//! Mip levels and layers are drawn one by one: each must be there before a pass reads it.

use std::collections::BTreeSet;

use super::violations::Violations;
use crate::node::{Arg, Drawing, ImageId, Origin, Recording, Subresource};

pub(super) fn look(recording: &Recording, violations: &mut Violations) {
    let mut drawn: BTreeSet<Subresource> = BTreeSet::new();
    for pass in &recording.passes {
        for part in pass.args().flat_map(|arg| read(arg, recording)) {
            violations.require(drawn.contains(&part), || {
                let (label, Subresource { level, layer, .. }) = (&recording.image(part.image).label, part);
                format!(
                    "the pass `{}` reads level {level} of layer {layer} of `{label}`, which is not drawn",
                    pass.label
                )
            });
        }
        drawn.extend(pass.drawing().into_iter().flat_map(Drawing::targets));
    }
}

/// The parts that an argument reads, of an image that is drawn in parts.
fn read(arg: Arg, recording: &Recording) -> Vec<Subresource> {
    let is_in_parts = |image: ImageId| {
        let image = recording.image(image);
        image.origin == Origin::Transient && (image.desc.levels, image.desc.layers) != (1, 1)
    };
    match arg {
        Arg::Texture(image) if is_in_parts(image) => {
            (0..recording.image(image).desc.levels).map(|level| image.level(level)).collect()
        }
        Arg::Level(part) if is_in_parts(part.image) => vec![part],
        _ => Vec::new(),
    }
}
