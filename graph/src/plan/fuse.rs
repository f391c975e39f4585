//! Step 4: a kernel function whose result is read only as "this pixel" becomes part of its reader; the image between them is never stored.

use super::Draft;
use crate::node::{Arg, ImageId, Origin, Pass, Resource, Step, Work};

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

pub(crate) fn fuse(draft: &mut Draft) -> Vec<Fused> {
    let mut fused = Vec::new();
    let mut producer_at = 0;
    while producer_at < draft.recording.passes.len() {
        match only_reader(draft, producer_at) {
            Some(reader_at) => {
                let producer = draft.recording.passes.remove(producer_at);
                fused.push(merge(draft, producer, reader_at - 1));
                // What the merged pass holds may now be fusable from the beginning.
                producer_at = 0;
            }
            None => producer_at += 1,
        }
    }
    fused
}

/// The one later pass that reads this pass's result, if the two can be one.
fn only_reader(draft: &Draft, producer_at: usize) -> Option<usize> {
    let passes = &draft.recording.passes;
    let Work::Steps { steps, result } = &passes[producer_at].work else { return None };
    let image = draft.recording.image(*result);
    if image.origin != Origin::Transient || draft.is_kept(*result) {
        return None;
    }
    let mut readers = (0..passes.len()).filter(|at| passes[*at].reads().contains(&Resource::Image(*result)));
    let reader_at = readers.next()?;
    if readers.next().is_some() || reader_at < producer_at {
        return None;
    }
    let Work::Steps { steps: reader_steps, result: reader_result } = &passes[reader_at].work else { return None };
    let only_pixels = reader_steps.iter().flat_map(|s| &s.args).all(|arg| *arg != Arg::Texture(*result));
    let same_size = draft.recording.image(*reader_result).desc.size == image.desc.size;
    let room = textures(steps) + textures(reader_steps) <= MOST_TEXTURES;
    (only_pixels && same_size && room).then_some(reader_at)
}

fn textures(steps: &[Step]) -> usize {
    steps.iter().flat_map(|s| &s.args).filter(|arg| arg.resource().is_some()).count()
}

fn merge(draft: &mut Draft, producer: Pass, reader_at: usize) -> Fused {
    let Pass { nodes, label, work: Work::Steps { mut steps, result: between } } = producer else {
        unreachable!("only passes of steps are fused")
    };
    let reader = &mut draft.recording.passes[reader_at];
    let Work::Steps { steps: reader_steps, .. } = &mut reader.work else {
        unreachable!("only passes of steps are fused")
    };
    let before = steps.len();
    for mut step in std::mem::take(reader_steps) {
        step.args.iter_mut().for_each(|arg| *arg = moved(*arg, between, before));
        steps.push(step);
    }
    *reader_steps = steps;
    reader.nodes.splice(0..0, nodes);
    reader.nodes.dedup();
    reader.label = format!("{label} + {}", reader.label);
    let nodes = reader.nodes.clone();
    let image = draft.recording.image(between);
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

