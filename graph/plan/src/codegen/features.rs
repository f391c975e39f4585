//! What the shader of a pass may use beyond what every device has.

use crate::options::Options;
use crate::plan::PlannedImage;
use afterimage_graph::node::{ImageId, Pass, Resource};
use afterimage_wgsl::ShaderFeatures;

/// Half floats are not for passes that read an image in 32 bits: its numbers may have more bits and be larger.
pub(super) fn features(pass: &Pass, images: &[PlannedImage], options: &Options) -> ShaderFeatures {
    let is_wide = |image: ImageId| images[image.0 as usize].desc.format.is_32_bit();
    let half = options.half && !pass.reads().into_iter().filter_map(Resource::image).any(is_wide);
    ShaderFeatures { half, subgroups: options.subgroups }
}
