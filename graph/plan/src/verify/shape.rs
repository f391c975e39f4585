//! Shape: the parts of a plan fit together, and everything that it mentions exists.

use std::collections::BTreeSet;

use super::walk::Faults;
use crate::heap_placement::HeapPlacement;
use crate::options::Alias;
use crate::plan::{Plan, Stage};
use afterimage_graph::node::{Pass, Resource};

pub(super) fn check(plan: &Plan, places: &HeapPlacement, faults: &mut Faults) {
    let lists = [
        ("offsets", places.offsets.len(), plan.images.len()),
        ("batches of aliasing barriers", places.aliasing.len(), plan.batches.len()),
    ];
    for (what, has, wants) in lists.into_iter().filter(|(_, has, wants)| has != wants) {
        faults.add(format!("the plan has {has} {what} where it needs {wants}"));
    }
    check_recorded(plan, faults);
    check_cover(plan, faults);
    check_numbers(plan, places, faults);
    check_stages(plan, faults);
    check_uniforms(plan, faults);
}

/// Each pass has a place of its own in the recording.
fn check_recorded(plan: &Plan, faults: &mut Faults) {
    let places: BTreeSet<usize> = plan.passes.iter().map(|planned| planned.recorded).collect();
    if !places.into_iter().eq(0..plan.passes.len()) {
        faults.add("the places in the recording do not name every pass once".into());
    }
}

/// Checks that the batches cover the passes in order.
fn check_cover(plan: &Plan, faults: &mut Faults) {
    let mut end = 0;
    for (number, batch) in plan.batches.iter().enumerate() {
        let passes = &batch.passes;
        if passes.start != end || passes.is_empty() {
            faults.add(format!("batch {number} is {passes:?}, but the batches before it end at pass {end}"));
        }
        end = passes.end;
    }
    if end != plan.passes.len() {
        faults.add(format!("the batches end at pass {end}, but there are {} passes", plan.passes.len()));
    }
}

fn check_numbers(plan: &Plan, places: &HeapPlacement, faults: &mut Faults) {
    let used = plan.work().flat_map(Pass::resources);
    let transitions = plan.batches.iter().flat_map(|batch| &batch.transitions).chain(&plan.exports);
    let mentioned = used.chain(transitions.map(|transition| transition.resource)).chain(unused(plan, places));
    for resource in mentioned {
        let is_known = match resource {
            Resource::Image(image) => (image.0 as usize) < plan.images.len(),
            Resource::Buffer(buffer) => (buffer.0 as usize) < plan.buffers.len(),
        };
        if !is_known {
            faults.add(format!("the plan mentions {resource:?}, which is not in it"));
        }
    }
}

/// Images that the plan mentions besides its passes.
fn unused<'a>(plan: &'a Plan, places: &'a HeapPlacement) -> impl Iterator<Item = Resource> + 'a {
    let barriers = places.aliasing.iter().flatten();
    let aliased = barriers.flat_map(|barrier| barrier.owners.iter().chain(std::iter::once(&barrier.image)));
    let outputs = plan.outputs.iter().map(|output| &output.image);
    let pasts = plan.images.iter().filter_map(|image| image.origin.previous_of());
    aliased.chain(outputs).copied().chain(pasts).map(Resource::Image)
}

/// Only passes of functions are drawn, and where one is, no images overlap in a heap: what is drawn to has a layout of
/// its own.
fn check_stages(plan: &Plan, faults: &mut Faults) {
    for planned in &plan.passes {
        if planned.pass.drawing().is_some() != (planned.stage == Stage::Drawing) {
            faults.add(format!("pass `{}` is planned as {:?}, which it is not", planned.pass.label, planned.stage));
        }
    }
    for planned in plan.passes.iter().filter(|planned| planned.stage != Stage::Compute) {
        if planned.stage == Stage::Fragment && !planned.pass.kind.is_drawable() {
            faults.add(format!("pass `{}` is drawn, but it can only be dispatched", planned.pass.label));
        }
        if plan.options.alias == Alias::Placed {
            faults.add(format!("pass `{}` is drawn, but images share a heap", planned.pass.label));
        }
    }
}

/// No two passes share bytes of the uniform buffer.
fn check_uniforms(plan: &Plan, faults: &mut Faults) {
    let blocks = plan.passes.iter().flat_map(|planned| {
        let block = &planned.uniform;
        let extent = size_of_val(&block.extent) as u64;
        let bytes = block.bytes.len() as u64;
        [(block.offset, bytes), (block.extent_offset, extent)].map(|(start, bytes)| (start, start + bytes, planned))
    });
    let mut blocks: Vec<_> = blocks.filter(|(start, end, _)| start < end).collect();
    blocks.sort_by_key(|(start, ..)| *start);
    for pair in blocks.windows(2) {
        let [(_, end, first), (start, _, second)] = pair else { continue };
        if start < end {
            let (first, second) = (&first.pass.label, &second.pass.label);
            faults.add(format!("the uniforms of pass `{first}` and of pass `{second}` overlap"));
        }
    }
}
