//! What the shader of a pass may use beyond what every device has.

use crate::options::Options;
use crate::plan::PlannedImage;
use afterimage_graph::node::{Pass, PassKind, Resource};
use afterimage_wgsl::ShaderFeatures;

/// Half floats are not for passes that read an image in 32 bits: its numbers may have more bits and be larger.
pub(super) fn features(pass: &Pass, images: &[PlannedImage], options: &Options) -> ShaderFeatures {
    let fits = |resource: &Resource| match resource {
        Resource::Image(image) => !images[image.0 as usize].desc.format.is_32_bit(),
        Resource::Buffer(_) => true,
    };
    let tiles_fit = !matches!(&pass.kind, PassKind::TiledChain(chain) if !chain.halves);
    let half = options.half && tiles_fit && pass.reads().iter().all(fits);
    ShaderFeatures { half, subgroups: options.subgroups }
}
