//! Order: passes of a batch are free of conflicts, every read sees its last write, and what must be written is.

use std::collections::{BTreeMap, BTreeSet};

use super::walk::{Access, Faults, Walk};
use crate::plan::{CachedResults, Refresh};
use afterimage_graph::node::{Arg, BufferId, BufferLife, ImageId, Origin, Resource};

pub(super) fn check(walk: &Walk<'_>, faults: &mut Faults) {
    for (resource, history) in walk.histories() {
        check_conflicts(walk, resource, &history, faults);
        check_sequence(walk, resource, &history, faults);
        match resource {
            Resource::Image(image) => check_origin(walk, image, &history, faults),
            Resource::Buffer(buffer) => check_life(walk, buffer, &history, faults),
        }
    }
    check_histories(walk, faults);
    check_outputs(walk, faults);
    check_refresh(walk, faults);
}

/// All that a pass writes which does not run in every frame is cached for as long, or read by passes alone that run in
/// the same frames or fewer.
fn check_refresh(walk: &Walk<'_>, faults: &mut Faults) {
    let plan = walk.plan;
    for (at, planned) in plan.passes.iter().enumerate() {
        let mut written = walk.accesses[at].iter().filter(|access| access.writes);
        let writes_lut = written.any(|access| access.resource.image().is_some_and(|image| is_lut(walk, image)));
        if planned.refresh.is_empty() || plan.runs_on_change(at) != writes_lut {
            faults.add(format!("pass `{}` does not run in the frames that need its result", walk.passes[at]));
        }
    }
    if plan.runs_all_passes() {
        return;
    }
    let refresh: Vec<&BTreeSet<Refresh>> = plan.passes.iter().map(|planned| &planned.refresh).collect();
    let runs_always = |pass: usize| refresh[pass].contains(&Refresh::EachFrame);
    let cached = plan.cached_results();
    let outputs: Vec<Resource> = plan.outputs.iter().map(|output| Resource::Image(output.image)).collect();
    let remembered: Vec<ImageId> = plan.images.iter().filter_map(|image| image.origin.previous_of()).collect();
    let histories = walk.histories();
    let seldom = |pass: usize| !runs_always(pass) && !plan.runs_on_change(pass);
    for (pass, access) in walk.uses().filter(|(pass, access)| access.writes && seldom(*pass)) {
        let (resource, own) = (access.resource, refresh[pass]);
        let lasts = match resource {
            Resource::Image(image) => {
                let is_new_for_readers = is_read_in_frames(walk, &refresh, image, own);
                outputs.contains(&resource) || remembered.contains(&image) && !is_new_for_readers
            }
            Resource::Buffer(buffer) => {
                let stays = cached.get(&resource) == Some(&Refresh::Once);
                plan.buffers[buffer.0 as usize].life == BufferLife::Persistent && !stays
            }
        };
        let is_missed = match cached.get(&resource) {
            Some(refresh) => !own.iter().eq([refresh]),
            None => {
                histories[&resource].iter().any(|(reader, access)| access.reads && !refresh[*reader].is_subset(own))
            }
        };
        if lasts || is_missed {
            let (pass, name) = (&walk.passes[pass], walk.name(resource));
            faults.add(format!("pass `{pass}` writes `{name}` in other frames than those in which it must be new"));
        }
    }
    for (pass, access) in walk.uses().filter(|(pass, access)| access.writes && runs_always(*pass)) {
        if cached.contains_key(&access.resource) {
            let (pass, name) = (&walk.passes[pass], walk.name(access.resource));
            faults.add(format!("pass `{pass}` writes `{name}` in every frame, though it is cached"));
        }
    }
}

/// Nothing that a pass writes is used by another pass of its batch.
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

/// Reads and writes of one resource follow each other as they were recorded, so each read sees the write that it saw
/// then.
fn check_sequence(walk: &Walk<'_>, resource: Resource, history: &[(usize, Access)], faults: &mut Faults) {
    let recorded = |pass: usize| walk.plan.passes[pass].recorded;
    let (mut last_write, mut last_use) = (None::<usize>, None::<usize>);
    let later = |a: Option<usize>, b: usize| Some(a.map_or(b, |a| if recorded(a) > recorded(b) { a } else { b }));
    for (pass, access) in history {
        let must_follow = if access.writes { last_use } else { last_write };
        if let Some(earlier) = must_follow.filter(|earlier| recorded(*earlier) > recorded(*pass)) {
            faults.add(format!(
                "pass `{}` {} `{}` after pass `{}`, but was recorded before it: it does not see what it should",
                walk.passes[*pass],
                if access.writes { "writes" } else { "reads" },
                walk.name(resource),
                walk.passes[earlier]
            ));
        }
        last_use = later(last_use, *pass);
        if access.writes {
            last_write = later(last_write, *pass);
        }
    }
}

/// Transients are written before they are read; other images are never written.
fn check_origin(walk: &Walk<'_>, image: ImageId, history: &[(usize, Access)], faults: &mut Faults) {
    let name = &walk.images[image.0 as usize];
    let origin = &walk.plan.image(image).origin;
    if is_lut(walk, image) {
        for (pass, _) in history.iter().filter(|(_, access)| access.writes) {
            check_fill(walk, *pass, faults);
        }
    }
    if matches!(origin, Origin::Transient | Origin::Retained) {
        if let Some((pass, _)) = history.first().filter(|(_, access)| access.reads) {
            faults.add(format!("pass `{}` reads `{name}` before any pass has written it", walk.passes[*pass]));
        }
    } else if let Some((pass, _)) = history.iter().find(|(_, access)| access.writes) {
        faults.add(format!("pass `{}` writes `{name}`, which is not made in this frame", walk.passes[*pass]));
    }
}

/// Returns whether an image is a baked LUT: it is retained, and no result of a node.
fn is_lut(walk: &Walk<'_>, image: ImageId) -> bool {
    let is_result = |cached: &CachedResults| cached.results.contains(&Resource::Image(image));
    walk.plan.image(image).origin == Origin::Retained && !walk.plan.savings.cached.iter().any(is_result)
}

/// A pass that evaluates a baked LUT reads nothing that changes from frame to frame, since it does not run in all of
/// them.
fn check_fill(walk: &Walk<'_>, pass: usize, faults: &mut Faults) {
    let lasts = |resource: Resource| match resource {
        Resource::Image(image) => matches!(walk.plan.image(image).origin, Origin::Constant(_)) || is_lut(walk, image),
        Resource::Buffer(buffer) => matches!(walk.plan.buffers[buffer.0 as usize].life, BufferLife::Constant(_)),
    };
    let mut changing = walk.accesses[pass].iter().filter(|access| access.reads && !lasts(access.resource));
    if let Some(access) = changing.next() {
        let (pass, name) = (&walk.passes[pass], walk.name(access.resource));
        faults.add(format!("pass `{pass}` evaluates a LUT from `{name}`, which may change in every frame"));
    }
    if walk.plan.passes[pass].pass.args().any(|arg| matches!(arg, Arg::Frame | Arg::Block(_))) {
        faults.add(format!("pass `{}` evaluates a LUT from numbers of the frame", walk.passes[pass]));
    }
    let others = walk.accesses[pass].iter().filter(|access| access.writes && !lasts(access.resource));
    for access in others {
        let (pass, name) = (&walk.passes[pass], walk.name(access.resource));
        faults.add(format!("pass `{pass}` evaluates a LUT and writes `{name}`, which is needed in every frame"));
    }
}

/// Returns whether later frames read an image only where it is written, and as many frames later as lie between two
/// writes.
fn is_read_in_frames(walk: &Walk<'_>, refresh: &[&BTreeSet<Refresh>], image: ImageId, own: &BTreeSet<Refresh>) -> bool {
    let Some(every) = own.first().filter(|_| own.len() == 1).and_then(|refresh| refresh.every()) else { return false };
    let histories = walk.histories();
    walk.plan.images.iter().zip(0..).all(|(past, id)| match past.origin {
        Origin::Previous { of, frames } if of == image => {
            let readers = histories.get(&Resource::Image(ImageId(id))).map_or(&[][..], Vec::as_slice);
            frames % every == 0 && readers.iter().all(|(reader, _)| refresh[*reader] == own)
        }
        _ => true,
    })
}

/// Buffers that live for a frame are written before they are read.
fn check_life(walk: &Walk<'_>, buffer: BufferId, history: &[(usize, Access)], faults: &mut Faults) {
    let is_of_frame = walk.plan.buffers[buffer.0 as usize].life == BufferLife::Frame;
    if let Some((pass, _)) = history.first().filter(|(_, access)| is_of_frame && !access.writes) {
        let name = walk.name(Resource::Buffer(buffer));
        faults.add(format!("pass `{}` reads `{name}` before any pass has written it", walk.passes[*pass]));
    }
}

/// Each image that a later frame reads is written by exactly one pass, or by several that draw one over the other.
fn check_histories(walk: &Walk<'_>, faults: &mut Faults) {
    let writers = writers(walk);
    for (index, image) in walk.plan.images.iter().enumerate() {
        let Some(of) = image.origin.previous_of() else { continue };
        let is_made_here = walk.plan.image(of).origin == Origin::Transient;
        let writers = writers.get(&of).map_or(&[][..], Vec::as_slice);
        let are_drawn = writers.iter().all(|pass| walk.plan.passes[*pass].pass.drawing().is_some());
        let count = writers.len();
        if is_made_here && (count == 0 || count > 1 && !are_drawn) {
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
    for (pass, access) in walk.uses().filter(|(_, access)| access.writes) {
        access.resource.image().into_iter().for_each(|image| writers.entry(image).or_default().push(pass));
    }
    writers
}
