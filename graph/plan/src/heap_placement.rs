//! A plan with the places of its images: its own, or those that the plan before it leaves where they are.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::barriers::aliasing;
use crate::memory::{blocks, place_around};
use crate::options::Alias;
use crate::plan::{AliasingBarrier, Plan};

/// Offsets of the transient images of a plan in the heap.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HeapPlacement {
    /// The offset of each image that shares memory, by image.
    pub offsets: Vec<Option<u64>>,
    pub heap: u64,
    /// The aliasing barriers before each batch.
    pub aliasing: Vec<Vec<AliasingBarrier>>,
}

/// A plan, and where its images lie. The same plan can be placed differently after different plans.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedPlan {
    pub plan: Arc<Plan>,
    pub placement: HeapPlacement,
}

impl HeapPlacement {
    /// The placement that the plan itself gives.
    pub fn of(plan: &Plan) -> Self {
        let offsets = plan.images.iter().map(|image| image.offset).collect();
        let aliasing = plan.batches.iter().map(|batch| batch.aliasing.clone()).collect();
        Self { offsets, heap: plan.memory.placed, aliasing }
    }
}

impl PlacedPlan {
    /// The plan with its own placement.
    pub fn new(plan: Arc<Plan>) -> Self {
        Self { placement: HeapPlacement::of(&plan), plan }
    }

    /// The plan in the heap of the previous one, with every image that both share in its old place, where all still
    /// fits; textures that lie where they lay need not be made again. The plan's own placement where the old heap is
    /// too small, or more than twice too large.
    ///
    /// Images are the same if their names and their requirements are.
    pub fn keeping(plan: Arc<Plan>, previous: &Self) -> Self {
        let placement = kept_placement(&plan, previous).unwrap_or_else(|| HeapPlacement::of(&plan));
        Self { plan, placement }
    }
}

fn kept_placement(plan: &Plan, previous: &PlacedPlan) -> Option<HeapPlacement> {
    let heap = previous.placement.heap;
    let is_placed = [plan.options.alias, previous.plan.options.alias] == [Alias::Placed; 2];
    let (images, blocks) = blocks(&plan.images);
    let placement = place_around(&blocks, &old_offsets(plan, previous, &images));
    if !is_placed || placement.end > heap || heap / 2 > plan.memory.placed {
        return None;
    }
    let mut offsets = vec![None; plan.images.len()];
    for (image, offset) in images.iter().zip(&placement.offsets) {
        offsets[*image] = Some(*offset);
    }
    let aliasing = aliasing(&plan.images, &offsets, Alias::Placed, plan.batches.len());
    Some(HeapPlacement { offsets, heap, aliasing })
}

/// For each of these images the place of its namesake in the previous plan, if the device wants the same for both.
fn old_offsets(plan: &Plan, previous: &PlacedPlan, images: &[usize]) -> Vec<Option<u64>> {
    let old_names = previous.plan.image_names();
    let old_images: BTreeMap<&String, usize> = old_names.iter().zip(0..).collect();
    let names = plan.image_names();
    let mut offsets = Vec::with_capacity(images.len());
    for image in images {
        let same = old_images.get(&names[*image]).copied();
        let same = same.filter(|same| previous.plan.images[*same].requirement == plan.images[*image].requirement);
        offsets.push(same.and_then(|same| previous.placement.offsets[same]));
    }
    offsets
}
