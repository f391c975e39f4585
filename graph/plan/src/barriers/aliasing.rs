//! Aliasing barriers: memory that goes from one image to another.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use crate::options::Alias;
use crate::plan::{AliasingBarrier, PlannedImage};
use afterimage_graph::node::ImageId;

/// The aliasing barriers before each of `batches` batches, for images at these offsets in the heap.
pub(crate) fn aliasing(
    images: &[PlannedImage],
    offsets: &[Option<u64>],
    alias: Alias,
    batches: usize,
) -> Vec<Vec<AliasingBarrier>> {
    let memory =
        |(at, image): (usize, &PlannedImage)| Some((image.lifetime?.first, at, extent(image, offsets[at], alias)?));
    let mut inputs: Vec<(usize, usize, Range<u64>)> = images.iter().enumerate().filter_map(memory).collect();
    inputs.sort_by_key(|(first, at, _)| (*first, *at));
    let mut owners = Owners::default();
    let mut barriers = vec![Vec::new(); batches];
    for (batch, at, extent) in inputs {
        let image = ImageId(at as u32);
        let before = owners.replace(extent, image);
        if !before.is_empty() {
            barriers[batch].push(AliasingBarrier { image, owners: before });
        }
    }
    barriers
}

/// The part of the shared memory that an image uses: bytes of the heap, or a texture of the pool.
fn extent(image: &PlannedImage, offset: Option<u64>, alias: Alias) -> Option<Range<u64>> {
    match alias {
        Alias::None => None,
        Alias::Pool => image.slot.map(|slot| u64::from(slot)..u64::from(slot) + 1),
        Alias::Placed => Some(offset?..offset? + image.requirement?.bytes),
    }
}

/// The image that used each stretch of memory last: from its start to its end and the image.
#[derive(Default)]
struct Owners(BTreeMap<u64, (u64, ImageId)>);

impl Owners {
    /// Makes an image the owner of a stretch; returns the owners before.
    fn replace(&mut self, extent: Range<u64>, image: ImageId) -> Vec<ImageId> {
        let before_start = self.0.range(..extent.start).next_back().map(|(start, _)| *start);
        let first = before_start.filter(|start| self.0[start].0 > extent.start).unwrap_or(extent.start);
        let old: Vec<(u64, (u64, ImageId))> =
            self.0.range(first..extent.end).map(|(start, rest)| (*start, *rest)).collect();
        let mut owners = BTreeSet::new();
        for (start, (end, owner)) in old {
            owners.insert(owner);
            self.0.remove(&start);
            if start < extent.start {
                self.0.insert(start, (extent.start, owner));
            }
            if end > extent.end {
                self.0.insert(extent.end, (end, owner));
            }
        }
        self.0.insert(extent.start, (extent.end, image));
        owners.into_iter().collect()
    }
}
