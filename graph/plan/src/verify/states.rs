//! States: before every batch a barrier has brought each image and buffer to the use that the batch makes of it.

use std::collections::BTreeMap;

use super::walk::{Access, Faults, Walk};
use crate::plan::{Stage, Transition, Use};
use afterimage_graph::node::{BufferLife, Origin, Resource};

pub(super) fn check(walk: &Walk<'_>, faults: &mut Faults) {
    let mut states: BTreeMap<Resource, Use> = BTreeMap::new();
    for (number, batch) in walk.plan.batches.iter().enumerate() {
        let mut all_required: BTreeMap<Resource, Use> = BTreeMap::new();
        for pass in batch.passes.clone() {
            for access in &walk.accesses[pass] {
                all_required.insert(access.resource, required(walk, pass, *access));
            }
        }
        let place = format!("batch {number}");
        check_batch(walk, &place, &all_required, &batch.transitions, &mut states, faults);
    }
    let outputs = walk.plan.outputs.iter().map(|output| (Resource::Image(output.image), Use::Host)).collect();
    check_batch(walk, "the end of the frame", &outputs, &walk.plan.exports, &mut states, faults);
}

fn check_batch(
    walk: &Walk<'_>,
    place: &str,
    all_required: &BTreeMap<Resource, Use>,
    batch: &[Transition],
    states: &mut BTreeMap<Resource, Use>,
    faults: &mut Faults,
) {
    let mut given: BTreeMap<Resource, &Transition> = BTreeMap::new();
    for transition in batch {
        let name = walk.name(transition.resource);
        if given.insert(transition.resource, transition).is_some() {
            faults.add(format!("two barriers before {place} change `{name}`"));
        }
        if !all_required.contains_key(&transition.resource) {
            faults.add(format!("a barrier before {place} changes `{name}`, which is not used there"));
        }
    }
    for (resource, required) in all_required {
        let name = walk.name(*resource);
        let state = states.get(resource).copied().unwrap_or_else(|| at_first(walk, *resource));
        match given.get(resource) {
            Some(t) if (t.from, t.to) == (state, *required) => {}
            Some(Transition { from, to, .. }) => faults.add(format!(
                "the barrier before {place} takes `{name}` from {from:?} to {to:?}, but it must go from {state:?} \
                 to {required:?}"
            )),
            None if state == *required && !changes(*required) => {}
            None => {
                faults
                    .add(format!("{place} uses `{name}` as {required:?}, but no barrier orders that after {state:?}"));
            }
        }
        states.insert(*resource, *required);
    }
}

fn required(walk: &Walk<'_>, pass: usize, access: Access) -> Use {
    let (draws, of_pass) = (walk.plan.passes[pass].stage != Stage::Compute, &walk.plan.passes[pass].pass);
    let is_depth = |image| of_pass.drawing().and_then(|drawing| drawing.depth).is_some_and(|d| d.target.image == image);
    match (access.writes, access.resource) {
        (false, _) => Use::Read,
        (true, Resource::Buffer(_)) => Use::StorageReadWrite,
        (true, Resource::Image(image)) if is_depth(image) => Use::DepthAttachment,
        (true, Resource::Image(_)) if draws => Use::ColorAttachment,
        (true, Resource::Image(_)) => Use::StorageWrite,
    }
}

fn changes(use_: Use) -> bool {
    use_ != Use::Read && use_ != Use::Host
}

fn at_first(walk: &Walk<'_>, resource: Resource) -> Use {
    match resource {
        Resource::Image(image) => match walk.plan.image(image).origin {
            Origin::Transient => Use::Undefined,
            Origin::Previous { .. } | Origin::Retained => Use::PreviousFrame,
            Origin::Input(_) | Origin::Constant(_) => Use::Host,
        },
        Resource::Buffer(buffer) => match walk.plan.buffers[buffer.0 as usize].life {
            BufferLife::Frame => Use::Undefined,
            BufferLife::Persistent => Use::PreviousFrame,
            BufferLife::Zeroed | BufferLife::Constant(_) => Use::Host,
        },
    }
}
