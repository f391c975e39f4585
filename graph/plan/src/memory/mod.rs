//! Memory: when images live, where transient images lie, and what sharing saves.

mod best_fit;
mod block;
mod lifetimes;
mod placement;
mod pool;

use std::collections::{BTreeMap, BTreeSet};

use crate::builder::PlanBuilder;
use crate::options::Alias;
use crate::plan::{Fused, Memory, PlannedImage};
use crate::request::{PlanRequest, Requirement};
use crate::schedule::Schedule;
use afterimage_graph::node::{ImageId, Origin};
use block::lower_bound;

pub(crate) use block::Block;
pub(crate) use placement::place_around;

/// Gives every image its lifetime, and every transient image its place in the heap and in the pool.
pub(crate) fn memory(
    images: &mut [PlannedImage],
    schedule: &Schedule,
    builder: &PlanBuilder,
    request: &PlanRequest<'_>,
    alias: Alias,
) -> Memory {
    lifetimes::set_lifetimes(images, schedule, &builder.kept());
    let unaliased = described_bytes(images, &builder.savings.fused);
    for image in images.iter_mut().filter(|image| image.lifetime.is_none()) {
        image.requirement = None;
    }
    let (shared, blocks) = blocks(images);
    let lower_bound = lower_bound(&blocks);
    let placement = placement::place(&blocks, lower_bound);
    for (image, offset) in shared.iter().zip(&placement.offsets) {
        images[*image].offset = Some(*offset);
    }
    let (slots, pooled) = pool::assign_slots(images, alias);
    Memory {
        slots,
        placed: placement.end,
        unaliased,
        unshared: blocks.iter().map(|block| block.bytes).sum(),
        pooled,
        lower_bound,
        kept: kept_bytes(images, builder, request),
    }
}

/// Bytes of all transient images that a pass uses, or used before it was fused with another.
fn described_bytes(images: &[PlannedImage], fused: &[Fused]) -> u64 {
    let removed: BTreeSet<&str> = fused.iter().map(|fused| fused.image.as_str()).collect();
    let described = images.iter().filter(|image| image.lifetime.is_some() || removed.contains(image.label.as_str()));
    described.filter_map(|image| image.requirement).map(|requirement| requirement.bytes).sum()
}

/// The images that share memory, and the bytes and batches that each takes.
pub(crate) fn blocks(images: &[PlannedImage]) -> (Vec<usize>, Vec<Block>) {
    let (mut shared, mut blocks) = (Vec::new(), Vec::new());
    for (at, image) in images.iter().enumerate() {
        if let (Some(Requirement { bytes, alignment }), Some(lifetime)) = (image.requirement, image.lifetime) {
            shared.push(at);
            blocks.push(Block { bytes, alignment, first: lifetime.first, last: lifetime.last });
        }
    }
    (shared, blocks)
}

/// Bytes of the images that outlive the frame or leave it.
fn kept_bytes(images: &[PlannedImage], builder: &PlanBuilder, request: &PlanRequest<'_>) -> u64 {
    let mut textures: BTreeMap<ImageId, u64> = builder.outputs.iter().map(|output| (output.image, 1)).collect();
    for image in images {
        if let Origin::Previous { of, frames } = image.origin {
            // The past of a node that is off is one image that no pass writes.
            let is_written = images[of.0 as usize].origin == Origin::Transient;
            let ring = if is_written { u64::from(frames) + 1 } else { 1 };
            let count = textures.entry(of).or_default();
            *count = (*count).max(ring);
        }
    }
    let own = images.iter().zip(0..).filter(|(image, _)| image.origin == Origin::Retained);
    textures.extend(own.map(|(_, id)| (ImageId(id), 1)));
    let mut bytes = 0;
    for (image, count) in textures {
        bytes += count * (request.requirement)(&images[image.0 as usize].desc).bytes;
    }
    bytes
}
