//! Explicit transitions: textures that are brought into their state before a batch, where the dispatches do not cause
//! the barrier in time.
//!
//! wgpu puts a barrier before a dispatch that uses an image in another way than the frame did before; the first use of
//! an image in a frame records its state and waits for nothing. Two cases are left. Images that several passes of a
//! batch read must change before the batch, or the second pass would wait for the first. And wgpu does not know that a
//! texture aliases another, so before its first write the device must wait for the passes that used the memory. A
//! barrier waits for all dispatches before it, so where the batch begins with one anyway, none is added: each
//! transition costs the host as much as half a dispatch, and a barrier of its own.

use afterimage_graph::node::{ImageId, Resource};
use afterimage_plan::{AliasingBarrier, Batch, Plan, Use};
use wgpu::{TextureUsages, TextureUses, TextureView};

use super::loaded::{ExplicitTransition, Loaded, Run};
use crate::layout::Pipeline;
use crate::store::Store;

/// For each pass the transitions before it, for each ring index; none for most.
pub(super) fn explicit_transitions(
    loaded: &Loaded,
    store: &Store,
    runs: &[Run],
    views: &[TextureView],
) -> Vec<Vec<Vec<ExplicitTransition>>> {
    let plan = &loaded.plan;
    let mut explicit_transitions: Vec<Vec<Vec<ExplicitTransition>>> = runs.iter().map(|_| Vec::new()).collect();
    let mut finished = vec![false; plan.images.len()];
    for (batch, aliasing) in plan.batches.iter().zip(&loaded.placement.aliasing) {
        // A draw ends the compute pass of the dispatches before it. The next compute pass begins with the barriers of
        // all that follows, which are then missing there.
        let first = batch.passes.start;
        let is_dispatched = runs[..batch.passes.end].iter().all(|run| matches!(run.pipeline, Pipeline::Compute(_)));
        let made: Vec<ImageId> = images_to_read(batch).filter(|(_, from)| from.writes()).map(|(i, _)| i).collect();
        let mut wanted = Vec::new();
        if !is_dispatched || !all_read_by(plan, first, &made) {
            let read = images_to_read(batch).filter(|_| batch.passes.len() > 1);
            wanted.extend(read.map(|(image, _)| (image, TextureUses::RESOURCE)));
        }
        if loaded.placed.is_some() {
            let waits = is_dispatched && !made.is_empty();
            let unordered = aliasing.iter().filter(|barrier| !(waits && were_read(barrier, &finished)));
            wanted.extend(unordered.map(|barrier| (barrier.image, TextureUses::STORAGE_WRITE_ONLY)));
        }
        explicit_transitions[first] = for_each_ring_index(loaded, store, views, &wanted);
        images_to_read(batch).for_each(|(image, _)| finished[image.0 as usize] = true);
    }
    explicit_transitions
}

/// The images that begin to be read in the batch, and their use before.
fn images_to_read(batch: &Batch) -> impl Iterator<Item = (ImageId, Use)> {
    let read = batch.transitions.iter().filter(|transition| transition.to == Use::Read);
    read.filter_map(|transition| Some((transition.resource.image()?, transition.from)))
}

/// Whether one pass reads all of these images: then its own barrier is enough.
fn all_read_by(plan: &Plan, pass: usize, images: &[ImageId]) -> bool {
    let reads = plan.passes[pass].pass.reads();
    images.iter().all(|image| reads.contains(&Resource::Image(*image)))
}

/// Whether the images that used the memory before were read after they were written: only then is it enough to wait,
/// without a barrier for their writes.
fn were_read(barrier: &AliasingBarrier, finished: &[bool]) -> bool {
    barrier.owners.iter().all(|owner| finished[owner.0 as usize])
}

fn for_each_ring_index(
    loaded: &Loaded,
    store: &Store,
    views: &[TextureView],
    wanted: &[(ImageId, TextureUses)],
) -> Vec<Vec<ExplicitTransition>> {
    if wanted.is_empty() {
        return Vec::new();
    }
    let transition = |(image, state): &(ImageId, TextureUses), ring_index| {
        let view = loaded.view(store, *image, views, ring_index).clone();
        let storable = view.texture().usage().contains(TextureUsages::STORAGE_BINDING);
        let state = if storable { *state } else { TextureUses::RESOURCE };
        ExplicitTransition { view, state }
    };
    (0..loaded.ring_length)
        .map(|ring_index| wanted.iter().map(|wanted| transition(wanted, ring_index)).collect())
        .collect()
}
