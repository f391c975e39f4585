//! Nodes that do not run in every frame.
//!
//! The results of a node with `every` have memory of their own. Which passes work for them alone follows from the
//! finished plan.

use std::collections::{BTreeMap, BTreeSet};

use afterimage_graph::node::{BufferId, BufferLife, ImageId, InputValue, Origin, Pass, Recording, Resource};

use crate::builder::PlanBuilder;
use crate::plan::{Held, Turn, made_for};

/// What a node makes that can be held: images and buffers of its own. Nothing if it keeps a state of its own, unless
/// that stays as it is. The recording had these numbers of images and buffers before it.
pub(crate) fn results(
    recording: &Recording,
    made: &[InputValue],
    [images, buffers]: [usize; 2],
    turn: Turn,
) -> Vec<Resource> {
    let own_buffers = recording.buffers.iter().zip(0..).skip(buffers);
    let state = own_buffers.filter(|(buffer, _)| buffer.life == BufferLife::Persistent);
    let state: Vec<Resource> = state.map(|(_, id)| Resource::Buffer(BufferId(id))).collect();
    if !state.is_empty() && turn != Turn::First {
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

/// A node of which an earlier result is read makes it in every frame.
pub(crate) fn release_remembered(builder: &mut PlanBuilder) {
    let remembered = builder.kept();
    for held in &mut builder.held {
        if held.results.iter().filter_map(|result| result.image()).any(|image| remembered.contains(&image)) {
            held.results.clear();
        }
    }
}

/// Gives what is held memory of its own and a phase, once it is known which passes are needed.
pub(crate) fn hold(builder: &mut PlanBuilder) {
    let PlanBuilder { recording, held, .. } = builder;
    if held.is_empty() {
        return;
    }
    // The nodes that write each resource.
    let mut writers: BTreeMap<Resource, BTreeSet<&str>> = BTreeMap::new();
    for pass in &recording.passes {
        let nodes = || pass.nodes.iter().map(String::as_str);
        pass.writes().into_iter().for_each(|resource| writers.entry(resource).or_default().extend(nodes()));
    }
    for Held { node, results, .. } in held.iter_mut() {
        results.retain(|result| writers.get(result).is_some_and(|nodes| nodes.iter().eq([&node.as_str()])));
    }
    let nodes: BTreeSet<&str> = writers.into_values().flatten().collect();
    held.retain(|held| nodes.contains(held.node.as_str()));
    // What only states that stay are made from is not held: it is made with them.
    let settled: BTreeSet<&str> = recording.settled.iter().map(String::as_str).collect();
    let is_for_settled = |held: &Held| {
        let reads = |pass: &&Pass| pass.reads().iter().any(|resource| held.results.contains(resource));
        let mut readers = recording.passes.iter().filter(reads).peekable();
        readers.peek().is_some() && readers.all(|pass| pass.nodes.iter().all(|node| settled.contains(node.as_str())))
    };
    held.retain(|held| held.turn == Turn::First || !is_for_settled(held));
    let images: Vec<ImageId> = held.iter().flat_map(|held| &held.results).filter_map(|result| result.image()).collect();
    images.into_iter().for_each(|image| recording.images[image.0 as usize].origin = Origin::Held);
    follow_turns(builder);
    stagger(builder);
}

/// An earlier image that only held work reads is made in its turns too: what was one frame ago is then one turn ago. A
/// frame out of turn, as after a change of values, finds an older one.
fn follow_turns(builder: &mut PlanBuilder) {
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
        let mut lasting = lasting(builder);
        lasting.remove(&image);
        let reader = only_user(builder, &lasting, |pass| pass.reads().contains(&past_image));
        let Some(at) = reader.filter(|_| is_once && !is_read && !is_shown) else { continue };
        let Some(every) = builder.held[at].turn.every() else { continue };
        builder.held[at].results.push(image);
        if only_user(builder, &lasting, |pass| pass.writes().contains(&image)) == Some(at) {
            let frames = frames * every;
            builder.recording.images[past].origin = Origin::Previous { of, frames };
        } else {
            builder.held[at].results.pop();
        }
    }
}

/// The one held node for which alone some passes run, if there is one.
fn only_user(builder: &PlanBuilder, lasting: &BTreeSet<Resource>, is_one: impl Fn(&Pass) -> bool) -> Option<usize> {
    let passes: Vec<&Pass> = builder.recording.passes.iter().collect();
    let all = passes.iter().zip(made_for(&passes, &held(builder), lasting)).filter(|(pass, _)| is_one(pass));
    let users: BTreeSet<BTreeSet<usize>> = all.map(|(_, users)| users).collect();
    match users.first()?.iter().collect::<Vec<_>>()[..] {
        [at] if users.len() == 1 => Some(*at),
        _ => None,
    }
}

/// The places of the held results among all.
fn held(builder: &PlanBuilder) -> BTreeMap<Resource, usize> {
    let held = builder.held.iter().enumerate();
    held.flat_map(|(at, held)| held.results.iter().map(move |result| (*result, at))).collect()
}

/// What each frame must write: what leaves it, and what later frames read.
fn lasting(builder: &PlanBuilder) -> BTreeSet<Resource> {
    let images = builder.kept().into_iter().map(Resource::Image);
    let buffers = builder.recording.buffers.iter().zip(0..);
    let buffers = buffers.filter(|(buffer, _)| buffer.life == BufferLife::Persistent);
    images.chain(buffers.map(|(_, id)| Resource::Buffer(BufferId(id)))).collect()
}

/// Spreads the work over the frames: results run in frames of their own, but those that share passes which nobody else
/// needs run together, or these passes would run for each.
fn stagger(builder: &mut PlanBuilder) {
    let passes: Vec<&Pass> = builder.recording.passes.iter().collect();
    let mut groups: Vec<usize> = (0..builder.held.len()).collect();
    for sharing in made_for(&passes, &held(builder), &lasting(builder)) {
        let joined: BTreeSet<usize> = sharing.iter().map(|at| groups[*at]).collect();
        if let Some(first) = joined.first() {
            groups.iter_mut().filter(|group| joined.contains(group)).for_each(|group| *group = *first);
        }
    }
    // In the order of names, which every way of planning has.
    let mut by_name: Vec<usize> = (0..groups.len()).collect();
    by_name.sort_by_key(|at| &builder.held[*at].node);
    let mut numbers: BTreeMap<usize, u32> = BTreeMap::new();
    for at in by_name {
        let next = numbers.len() as u32;
        let number = *numbers.entry(groups[at]).or_insert(next);
        if let Turn::OneOf { every, phase } = &mut builder.held[at].turn {
            *phase = number % *every;
        }
    }
}
