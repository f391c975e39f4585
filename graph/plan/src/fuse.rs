//! Step 4: a kernel function whose result is read only as "this pixel" becomes part of its reader; the image between them is never stored.
//!
//! A light one, which does little to one pixel, becomes part of each of several readers: to do it again costs less than to store it.

use crate::PlanBuilder;
use crate::pass_graph::PassGraph;
use afterimage_graph::node::{Arg, ImageId, Origin, Pass, Recording, Resource, Step, Work};

/// An image that fusion has removed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fused {
    /// The image, as `node.port`.
    pub image: String,
    /// The nodes of the pass that now holds both ends.
    pub nodes: Vec<String>,
    /// Bytes that are neither written nor read any more, in one frame.
    pub bytes_saved: u64,
}

/// More bindings than this in one pass, and a small device refuses it.
const MOST_TEXTURES: usize = 12;
/// Readers that a light pass is copied into.
const MOST_COPIES: usize = 4;

pub(crate) fn fuse(draft: &mut PlanBuilder) -> Vec<Fused> {
    let mut web = PassGraph::new(draft);
    let mut fused = Vec::new();
    let mut pending: Vec<usize> = (0..web.len()).rev().collect();
    while let Some(number) = pending.pop() {
        let readers = pixel_readers(&web, &draft.recording, number);
        let Some((last, others)) = readers.split_last() else { continue };
        let producer = web.take(number).expect("a producer was found");
        // Copies for all but the last, so that a long chain is not copied at every link.
        let copies: Vec<Pass> = others.iter().map(|_| producer.clone()).collect();
        for (reader, producer) in others.iter().zip(copies).chain([(last, producer)]) {
            fused.push(merge(&mut web, &draft.recording, producer, *reader));
            // Two readers of one image may have become one: who makes that image may follow.
            let reads = web.get(*reader).map(Pass::reads).unwrap_or_default();
            pending.extend(reads.into_iter().flat_map(|resource| web.writers(resource).collect::<Vec<_>>()));
        }
    }
    web.finish(draft);
    fused
}

/// The passes that this one can become part of: all that read its result, or none.
fn pixel_readers(web: &PassGraph, recording: &Recording, number: usize) -> Vec<usize> {
    let Some(Work::Steps { steps, result }) = web.get(number).map(|pass| &pass.work) else { return Vec::new() };
    let image = recording.image(*result);
    if image.origin != Origin::Transient || web.is_kept(*result) {
        return Vec::new();
    }
    let readers: Vec<usize> = web.readers(Resource::Image(*result)).collect();
    let takes = |reader: &usize| {
        let Some(Work::Steps { steps: reader_steps, result: reader_result }) = web.get(*reader).map(|pass| &pass.work)
        else {
            return false;
        };
        let only_pixels = reader_steps.iter().flat_map(|s| &s.args).all(|arg| *arg != Arg::Texture(*result));
        let same_size = recording.image(*reader_result).desc.size == image.desc.size;
        only_pixels && same_size && textures(steps) + textures(reader_steps) <= MOST_TEXTURES
    };
    let few = readers.len() == 1 || readers.len() <= MOST_COPIES && is_light(steps);
    if few && readers.iter().all(takes) { readers } else { Vec::new() }
}

/// Whether doing the steps again for each reader costs less than storing what they give: they are few and look at one pixel of one image.
fn is_light(steps: &[Step]) -> bool {
    let args = || steps.iter().flat_map(|step| &step.args);
    let pixels = args().filter(|arg| matches!(arg, Arg::Pixel(_))).count();
    steps.len() <= 2 && pixels <= 1 && !args().any(|arg| matches!(arg, Arg::Texture(_)))
}

fn textures(steps: &[Step]) -> usize {
    steps.iter().flat_map(|s| &s.args).filter(|arg| arg.resource().is_some()).count()
}

fn merge(web: &mut PassGraph, recording: &Recording, producer: Pass, reader_number: usize) -> Fused {
    let Pass { mut nodes, label, work: Work::Steps { mut steps, result: between } } = producer else {
        unreachable!("only passes of steps are fused")
    };
    let reader = web.take(reader_number).expect("a reader was found");
    let Work::Steps { steps: reader_steps, result } = reader.work else {
        unreachable!("only passes of steps are fused")
    };
    let before = steps.len();
    for mut step in reader_steps {
        step.args.iter_mut().for_each(|arg| *arg = moved(*arg, between, before));
        steps.push(step);
    }
    nodes.extend(reader.nodes);
    nodes.dedup();
    let label = format!("{label} + {}", reader.label);
    web.put(reader_number, Pass { nodes: nodes.clone(), label, work: Work::Steps { steps, result } });
    let image = recording.image(between);
    Fused { image: image.label.clone(), nodes, bytes_saved: 2 * image.desc.bytes() }
}

/// An argument of the reader after `before` steps were put in front of it.
fn moved(arg: Arg, between: ImageId, before: usize) -> Arg {
    match arg {
        Arg::Pixel(image) if image == between => Arg::Step(before - 1),
        Arg::Step(earlier) => Arg::Step(earlier + before),
        other => other,
    }
}
