//! Order: batches cover the passes and are free of conflicts, every read sees its last write, and what must be written is.

use std::collections::BTreeMap;

use super::{Access, Faults, Walk};
use crate::Plan;
use afterimage_graph::node::{ImageId, Origin, Resource};

/// Whether the plan's lists fit together at all.
pub(crate) fn check_shape(plan: &Plan, faults: &mut Faults) {
    let (passes, images) = (plan.recording.passes.len(), plan.recording.images.len());
    let lists = [
        ("stages", plan.stages.len(), passes),
        ("places in the recording", plan.recorded.len(), passes),
        ("sample_modes", plan.sample_modes.len(), images),
        ("lifetimes", plan.lifetimes.len(), images),
        ("requirements", plan.memory.requirement_of.len(), images),
        ("offsets", plan.memory.offset_of.len(), images),
        ("slots of images", plan.memory.slot_of.len(), images),
        ("batches of barriers", plan.barriers.len(), plan.batches.len()),
    ];
    for (what, has, wants) in lists.into_iter().filter(|(_, has, wants)| has != wants) {
        faults.add(format!("the plan has {has} {what} where it needs {wants}"));
    }
    let mut seen = plan.recorded.clone();
    seen.sort_unstable();
    if seen.iter().enumerate().any(|(at, place)| at != *place) {
        faults.add("the places in the recording do not name every pass once".into());
    }
    check_cover(plan, faults);
    check_numbers(plan, faults);
}

/// Whether the batches cover the passes in order.
fn check_cover(plan: &Plan, faults: &mut Faults) {
    let mut end = 0;
    for (number, passes) in plan.batches.iter().enumerate() {
        if passes.start != end || passes.is_empty() {
            faults.add(format!("batch {number} is {passes:?}, but the batches before it end at pass {end}"));
        }
        end = passes.end;
    }
    if end != plan.recording.passes.len() {
        faults.add(format!("the batches end at pass {end}, but there are {} passes", plan.recording.passes.len()));
    }
}

fn check_numbers(plan: &Plan, faults: &mut Faults) {
    let mentioned = plan.recording.passes.iter().flat_map(|pass| pass.reads().into_iter().chain(pass.writes()));
    let in_barriers =
        plan.barriers.iter().flat_map(|batch| &batch.transitions).chain(&plan.exports).map(|t| t.resource);
    let outside = outside(plan);
    for resource in mentioned.chain(in_barriers).chain(outside) {
        let known = match resource {
            Resource::Image(image) => (image.0 as usize) < plan.recording.images.len(),
            Resource::Buffer(buffer) => (buffer.0 as usize) < plan.recording.buffers.len(),
        };
        if !known {
            faults.add(format!("the plan mentions {resource:?}, which is not in it"));
        }
    }
}

/// Images that the plan mentions beside its passes.
fn outside(plan: &Plan) -> impl Iterator<Item = Resource> + '_ {
    let handed = plan
        .barriers
        .iter()
        .flat_map(|batch| &batch.aliasing)
        .flat_map(|hand_over| hand_over.residents.iter().chain(std::iter::once(&hand_over.image)));
    let outputs = plan.outputs.iter().map(|output| &output.image);
    let pasts = plan.recording.images.iter().filter_map(|image| match &image.origin {
        Origin::Previous { of, .. } => Some(of),
        _ => None,
    });
    handed.chain(outputs).chain(pasts).map(|image| Resource::Image(*image))
}

pub(crate) fn check(walk: &Walk<'_>, faults: &mut Faults) {
    for (resource, history) in walk.histories() {
        check_conflicts(walk, resource, &history, faults);
        check_sequence(walk, resource, &history, faults);
        if let Resource::Image(image) = resource {
            check_origin(walk, image, &history, faults);
        }
    }
    check_histories(walk, faults);
    check_outputs(walk, faults);
}

/// Nothing that a pass writes is touched by another pass of its batch.
fn check_conflicts(walk: &Walk<'_>, resource: Resource, history: &[(usize, Access)], faults: &mut Faults) {
    for pair in history.chunk_by(|a, b| walk.batch_of[a.0] == walk.batch_of[b.0]) {
        let Some((writer, _)) = pair.iter().find(|(_, access)| access.writes) else { continue };
        for (other, _) in pair.iter().filter(|(pass, _)| pass != writer) {
            faults.add(format!(
                "pass `{}` writes `{}` in batch {} while pass `{}` of the same batch uses it",
                walk.passes[*writer],
                walk.name(resource),
                walk.batch_of[*writer],
                walk.passes[*other]
            ));
        }
    }
}

/// Reads and writes of one resource follow each other as they were recorded, so each read sees the write that it saw then.
fn check_sequence(walk: &Walk<'_>, resource: Resource, history: &[(usize, Access)], faults: &mut Faults) {
    let recorded = |pass: usize| walk.plan.recorded[pass];
    let (mut last_write, mut last_touch) = (None::<usize>, None::<usize>);
    let later = |a: Option<usize>, b: usize| Some(a.map_or(b, |a| if recorded(a) > recorded(b) { a } else { b }));
    for (pass, access) in history {
        let must_follow = if access.writes { last_touch } else { last_write };
        if let Some(earlier) = must_follow.filter(|earlier| recorded(*earlier) > recorded(*pass)) {
            faults.add(format!(
                "pass `{}` {} `{}` after pass `{}`, but was recorded before it: it does not see what it should",
                walk.passes[*pass],
                if access.writes { "writes" } else { "reads" },
                walk.name(resource),
                walk.passes[earlier]
            ));
        }
        last_touch = later(last_touch, *pass);
        if access.writes {
            last_write = later(last_write, *pass);
        }
    }
}

/// Transients are written before they are read; what comes from outside is never written.
fn check_origin(walk: &Walk<'_>, image: ImageId, history: &[(usize, Access)], faults: &mut Faults) {
    let name = &walk.images[image.0 as usize];
    let origin = &walk.plan.recording.image(image).origin;
    if *origin == Origin::Transient {
        if let Some((pass, _)) = history.first().filter(|(_, access)| access.reads) {
            faults.add(format!("pass `{}` reads `{name}` before any pass has written it", walk.passes[*pass]));
        }
    } else if let Some((pass, _)) = history.iter().find(|(_, access)| access.writes) {
        faults.add(format!("pass `{}` writes `{name}`, which is not made in this frame", walk.passes[*pass]));
    }
}

/// Each image that a later frame reads is written by exactly one pass.
fn check_histories(walk: &Walk<'_>, faults: &mut Faults) {
    let writers = writers(walk);
    for (index, image) in walk.plan.recording.images.iter().enumerate() {
        let Origin::Previous { of, .. } = image.origin else { continue };
        let is_made_here = walk.plan.recording.image(of).origin == Origin::Transient;
        let count = writers.get(&of).map_or(0, Vec::len);
        if is_made_here && count != 1 {
            let (past, name) = (&walk.images[index], &walk.images[of.0 as usize]);
            faults.add(format!("`{name}`, which `{past}` is the past of, is written by {count} passes and not by one"));
        }
    }
}

fn check_outputs(walk: &Walk<'_>, faults: &mut Faults) {
    let writers = writers(walk);
    for output in walk.plan.outputs.iter().filter(|output| !writers.contains_key(&output.image)) {
        let image = &walk.images[output.image.0 as usize];
        faults.add(format!("no pass writes `{image}`, which is the output `{}`", output.name));
    }
}

fn writers(walk: &Walk<'_>) -> BTreeMap<ImageId, Vec<usize>> {
    let mut writers: BTreeMap<ImageId, Vec<usize>> = BTreeMap::new();
    for (pass, accesses) in walk.accesses.iter().enumerate() {
        for access in accesses.iter().filter(|access| access.writes) {
            if let Resource::Image(image) = access.resource {
                writers.entry(image).or_default().push(pass);
            }
        }
    }
    writers
}
