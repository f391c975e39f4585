//! Nodes that do not run in every frame, and values that are read a frame later.
//!
//! The results of a node with `every` have memory of their own. Which passes work for them alone follows from the
//! finished plan. The passes of a node with `late` come after all that read its value.

use std::collections::{BTreeMap, BTreeSet};

use afterimage_graph::check::Graph;
use afterimage_graph::node::{BufferLife, ImageId, InputValue, Origin, Pass, Recording, Resource};

use crate::builder::PlanBuilder;
use crate::plan::Held;

/// What a node makes that can be held: images and buffers of its own. Nothing if it keeps a state of its own. The
/// recording had these numbers of images and buffers before it.
pub(crate) fn results(recording: &Recording, made: &[InputValue], [images, buffers]: [usize; 2]) -> Vec<Resource> {
    let own_buffers = &recording.buffers[buffers..];
    if own_buffers.iter().any(|buffer| buffer.life == BufferLife::Persistent) {
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
    all.filter(is_own).collect::<BTreeSet<_>>().into_iter().collect()
}

/// The number of each node with `every` among all of them, by their names: what staggers them.
pub(crate) fn turns(graph: &Graph) -> BTreeMap<&str, u32> {
    let names: BTreeSet<&str> =
        graph.nodes.iter().filter(|node| node.every > 1).map(|node| node.name.as_str()).collect();
    names.into_iter().zip(0..).collect()
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

/// Gives what is held memory of its own, once it is known which passes are needed.
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
    let images: Vec<ImageId> = held.iter().flat_map(|held| &held.results).filter_map(|result| result.image()).collect();
    images.into_iter().for_each(|image| recording.images[image.0 as usize].origin = Origin::Held);
}

/// Puts the passes of late values behind all others.
///
/// In a frame that begins anew a late value is made first, and what it is made from is made again with all others. So
/// that needs to be possible: a value stays where it is if it is made from what a pass keeps or draws, or in several
/// passes, or if it is not kept.
pub(crate) fn put_off(builder: &mut PlanBuilder, graph: &Graph) {
    let nodes: BTreeSet<&str> = graph.nodes.iter().filter(|node| node.late).map(|node| node.name.as_str()).collect();
    if nodes.is_empty() {
        return;
    }
    let recording = &mut builder.recording;
    let passes = std::mem::take(&mut recording.passes);
    let is_kept = |resource: &Resource| match *resource {
        Resource::Buffer(buffer) => recording.buffer(buffer).life == BufferLife::Persistent,
        Resource::Image(_) => false,
    };
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    passes.iter().for_each(|pass| *counts.entry(&pass.nodes[0]).or_default() += 1);
    let is_late = |node: &str| nodes.contains(node) && counts.get(node) == Some(&1);
    let mut once: BTreeSet<Resource> = BTreeSet::new();
    let mut late = Vec::new();
    for pass in &passes {
        let (reads, writes) = (pass.reads(), pass.writes());
        let is_made_once = pass.drawing().is_some() || reads.iter().any(|read| once.contains(read));
        late.push(is_late(&pass.nodes[0]) && !is_made_once && writes.iter().all(is_kept));
        if is_made_once || writes.iter().any(is_kept) {
            once.extend(writes);
        }
    }
    let mut late = late.into_iter();
    let (late, others): (Vec<Pass>, Vec<Pass>) = passes.into_iter().partition(|_| late.next() == Some(true));
    builder.late = late.iter().map(|pass| pass.nodes[0].clone()).collect();
    recording.passes = others.into_iter().chain(late).collect();
}
