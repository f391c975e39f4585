//! The frames in which passes run: results of some nodes are cached, and passes that only they need run with them.

use std::collections::{BTreeMap, BTreeSet};

use afterimage_graph::node::{BufferId, BufferLife, ImageId, InputValue, Origin, Pass, Recording, Resource};

use crate::builder::PlanBuilder;
use crate::plan::{CachedResults, PlannedImage, Refresh, Savings, ScheduledPass, passes_only_for};

/// The images and buffers of a node that can be cached. None if it keeps a state, unless `Once` initializes it. The
/// recording had these numbers of images and buffers before the node.
pub(crate) fn results(
    recording: &Recording,
    made: &[InputValue],
    [images, buffers]: [usize; 2],
    refresh: Refresh,
) -> Vec<Resource> {
    let own_buffers = recording.buffers.iter().zip(0..).skip(buffers);
    let state = own_buffers.filter(|(buffer, _)| buffer.life == BufferLife::Persistent);
    let state: Vec<Resource> = state.map(|(_, id)| Resource::Buffer(BufferId(id))).collect();
    if !state.is_empty() && refresh != Refresh::Once {
        return Vec::new();
    }
    let all = made.iter().flat_map(|value| match value {
        InputValue::Image(image) => vec![Resource::Image(*image)],
        InputValue::Pyramid(levels) => levels.iter().copied().map(Resource::Image).collect(),
        InputValue::Buffer(buffer) => vec![Resource::Buffer(*buffer)],
        InputValue::Block(_) | InputValue::Zero | InputValue::Absent => Vec::new(),
    });
    let is_own = |resource: &Resource| match *resource {
        Resource::Image(image) => image.0 as usize >= images && recording.image(image).origin == Origin::Transient,
        Resource::Buffer(buffer) => {
            let life = recording.buffers.get(buffer.0 as usize).map(|buffer| &buffer.life);
            buffer.0 as usize >= buffers && !matches!(life, Some(BufferLife::Constant(_)))
        }
    };
    all.filter(is_own).chain(state).collect::<BTreeSet<_>>().into_iter().collect()
}

/// Caches no results of nodes of which a later frame reads an image.
pub(crate) fn exclude_histories(builder: &mut PlanBuilder) {
    let read_later = builder.kept();
    for cached in &mut builder.savings.cached {
        if cached.results.iter().filter_map(|result| result.image()).any(|image| read_later.contains(&image)) {
            cached.results.clear();
        }
    }
}

/// Gives cached results memory of their own and a phase, once it is known which passes are needed.
pub(crate) fn cache_results(builder: &mut PlanBuilder) {
    let PlanBuilder { recording, savings: Savings { cached, .. }, .. } = builder;
    if cached.is_empty() {
        return;
    }
    // The nodes that write each resource.
    let mut writers: BTreeMap<Resource, BTreeSet<&str>> = BTreeMap::new();
    for pass in &recording.passes {
        let nodes = || pass.nodes.iter().map(String::as_str);
        pass.writes().into_iter().for_each(|resource| writers.entry(resource).or_default().extend(nodes()));
    }
    for CachedResults { node, results, .. } in cached.iter_mut() {
        results.retain(|result| writers.get(result).is_some_and(|nodes| nodes.iter().eq([&node.as_str()])));
    }
    let nodes: BTreeSet<&str> = writers.into_values().flatten().collect();
    cached.retain(|cached| nodes.contains(cached.node.as_str()));
    // Nodes that run once are enough of a cache for what only they read.
    let settled: BTreeSet<&str> = recording.settled.iter().map(String::as_str).collect();
    let is_read_once = |cached: &CachedResults| {
        let reads = |pass: &&Pass| pass.reads().iter().any(|resource| cached.results.contains(resource));
        let mut readers = recording.passes.iter().filter(reads).peekable();
        readers.peek().is_some() && readers.all(|pass| pass.nodes.iter().all(|node| settled.contains(node.as_str())))
    };
    cached.retain(|cached| cached.refresh == Refresh::Once || !is_read_once(cached));
    let images: Vec<ImageId> =
        cached.iter().flat_map(|cached| &cached.results).filter_map(|result| result.image()).collect();
    images.into_iter().for_each(|image| recording.images[image.0 as usize].origin = Origin::Retained);
    follow_readers(builder);
    stagger(builder);
}

/// Fills in the frames in which each pass runs.
pub(crate) fn refresh(passes: &mut [ScheduledPass], images: &[PlannedImage], builder: &PlanBuilder) {
    let results = builder.savings.cached.iter();
    let mut cached: BTreeMap<Resource, Refresh> =
        results.flat_map(|cached| cached.results.iter().map(|result| (*result, cached.refresh))).collect();
    // A retained image that is not a result of a node is a baked LUT.
    for (_, id) in images.iter().zip(0..).filter(|(image, _)| image.origin == Origin::Retained) {
        cached.entry(Resource::Image(ImageId(id))).or_insert(Refresh::OnChange);
    }
    let recorded: Vec<&Pass> = passes.iter().map(|scheduled| &scheduled.pass).collect();
    let refreshes = passes_only_for(&recorded, &cached, &persistent(builder), Refresh::EachFrame);
    passes.iter_mut().zip(refreshes).for_each(|(scheduled, refresh)| scheduled.refresh = refresh);
}

/// An image that one node with `every` alone reads in later frames is computed in the frames of that node, so that one
/// frame ago becomes `every` frames ago. A frame that is due for another reason, such as new values, reads an older
/// image.
fn follow_readers(builder: &mut PlanBuilder) {
    let pasts: Vec<(usize, ImageId, u32)> = (builder.recording.images.iter().enumerate())
        .filter_map(|(past, image)| match image.origin {
            Origin::Previous { of, frames } => Some((past, of, frames)),
            _ => None,
        })
        .collect();
    for &(past, of, frames) in &pasts {
        let (past_image, image) = (Resource::Image(ImageId(past as u32)), Resource::Image(of));
        let is_read = builder.recording.passes.iter().any(|pass| pass.reads().contains(&image));
        let is_shown = builder.outputs.iter().any(|output| output.image == of);
        let is_once = pasts.iter().filter(|(_, other, _)| *other == of).count() == 1;
        let mut persistent = persistent(builder);
        persistent.remove(&image);
        let reader = only_user(builder, &persistent, |pass| pass.reads().contains(&past_image));
        let Some(at) = reader.filter(|_| is_once && !is_read && !is_shown) else { continue };
        let Some(every) = builder.savings.cached[at].refresh.every() else { continue };
        builder.savings.cached[at].results.push(image);
        if only_user(builder, &persistent, |pass| pass.writes().contains(&image)) == Some(at) {
            let frames = frames * every;
            builder.recording.images[past].origin = Origin::Previous { of, frames };
        } else {
            builder.savings.cached[at].results.pop();
        }
    }
}

/// The index of the one node with cached results for which alone some passes run.
fn only_user(builder: &PlanBuilder, persistent: &BTreeSet<Resource>, is_one: impl Fn(&Pass) -> bool) -> Option<usize> {
    let users = users(builder, persistent);
    let all = builder.recording.passes.iter().zip(users).filter(|(pass, _)| is_one(pass));
    let users: BTreeSet<BTreeSet<Option<usize>>> = all.map(|(_, users)| users).collect();
    match users.first()?.iter().collect::<Vec<_>>()[..] {
        [Some(at)] if users.len() == 1 => Some(*at),
        _ => None,
    }
}

/// For each pass the indices of the nodes with cached results for which alone it runs; `None` stands for all frames.
fn users(builder: &PlanBuilder, persistent: &BTreeSet<Resource>) -> Vec<BTreeSet<Option<usize>>> {
    let passes: Vec<&Pass> = builder.recording.passes.iter().collect();
    let cached = builder.savings.cached.iter().enumerate();
    let cached = cached.flat_map(|(at, cached)| cached.results.iter().map(move |result| (*result, Some(at)))).collect();
    passes_only_for(&passes, &cached, persistent, None)
}

/// The resources that each frame must write: outputs, and those that later frames read.
fn persistent(builder: &PlanBuilder) -> BTreeSet<Resource> {
    let images = builder.kept().into_iter().map(Resource::Image);
    let buffers = builder.recording.buffers.iter().zip(0..);
    let buffers = buffers.filter(|(buffer, _)| buffer.life == BufferLife::Persistent);
    images.chain(buffers.map(|(_, id)| Resource::Buffer(BufferId(id)))).collect()
}

/// Spreads the work over the frames: nodes run in frames of their own, but those that share passes which no other frame
/// needs run together, because these passes would run for each.
fn stagger(builder: &mut PlanBuilder) {
    let mut groups: Vec<usize> = (0..builder.savings.cached.len()).collect();
    for users in users(builder, &persistent(builder)) {
        let joined: BTreeSet<usize> = users.into_iter().flatten().map(|at| groups[at]).collect();
        if let Some(first) = joined.first() {
            groups.iter_mut().filter(|group| joined.contains(group)).for_each(|group| *group = *first);
        }
    }
    // In the order of names, which every way of planning has.
    let mut by_name: Vec<usize> = (0..groups.len()).collect();
    by_name.sort_by_key(|at| &builder.savings.cached[*at].node);
    let mut numbers: BTreeMap<usize, u32> = BTreeMap::new();
    for at in by_name {
        let next = numbers.len() as u32;
        let number = *numbers.entry(groups[at]).or_insert(next);
        if let Refresh::Every { every, phase } = &mut builder.savings.cached[at].refresh {
            *phase = number % *every;
        }
    }
}
