//! Textures that are brought into their state before a batch, where the dispatches would not do so by themselves in time.
//!
//! wgpu puts a barrier before a dispatch that uses an image in another way than the frame did before; an image's first mention in a frame records
//! its state and waits for nothing. Two things are left to us. Images that several passes of a batch read must change in one batch, or the second
//! pass would wait for the first. And a new resident of shared memory is strange to wgpu: before its first write the device must wait for
//! whoever used the memory. Every barrier waits for all dispatches before it, so where the batch begins with one anyway, nothing is touched for that: each
//! transition costs the host as much as half a dispatch, and a barrier of its own.

use afterimage_graph::node::{ImageId, Resource};
use afterimage_plan::{AliasingBarrier, BatchBarriers, Plan, Use};
use wgpu::{TextureUsages, TextureUses, TextureView};

use super::loaded::{ExplicitTransition, Loaded, Run};
use crate::layout::Pipeline;
use crate::store::Store;

/// For each pass, what must be touched before it, for each ring_index; nothing at all for most.
pub(super) fn explicit_transitions(
    loaded: &Loaded,
    store: &Store,
    runs: &[Run],
    views: &[TextureView],
) -> Vec<Vec<Vec<ExplicitTransition>>> {
    let plan = &loaded.plan;
    let mut explicit_transitions: Vec<Vec<Vec<ExplicitTransition>>> = runs.iter().map(|_| Vec::new()).collect();
    let mut finished = vec![false; plan.recording.images.len()];
    for (batch, barriers) in plan.batches.iter().zip(&plan.barriers) {
        // A draw ends the pass of the dispatches before it. The next begins with the barriers of all that follows, which are then missing there.
        let first = batch.start;
        let is_dispatched = runs[..batch.end].iter().all(|run| matches!(run.pipeline, Pipeline::Compute(_)));
        let made: Vec<ImageId> = images_to_read(barriers).filter(|(_, from)| from.writes()).map(|(i, _)| i).collect();
        let mut wanted = Vec::new();
        if !is_dispatched || !all_read_by(plan, first, &made) {
            let batch = images_to_read(barriers).filter(|_| batch.len() > 1);
            wanted.extend(batch.map(|(image, _)| (image, TextureUses::RESOURCE)));
        }
        if loaded.placed.is_some() {
            let waits = is_dispatched && !made.is_empty();
            let strange = barriers.aliasing.iter().filter(|new| !(waits && were_read(new, &finished)));
            wanted.extend(strange.map(|new| (new.image, TextureUses::STORAGE_WRITE_ONLY)));
        }
        explicit_transitions[first] = for_each_phase(loaded, store, views, &wanted);
        images_to_read(barriers).for_each(|(image, _)| finished[image.0 as usize] = true);
    }
    explicit_transitions
}

/// The images that begin to be read in the batch, and their use before.
fn images_to_read(barriers: &BatchBarriers) -> impl Iterator<Item = (ImageId, Use)> {
    let read = barriers.transitions.iter().filter(|transition| transition.to == Use::Read);
    read.filter_map(|transition| match transition.resource {
        Resource::Image(image) => Some((image, transition.from)),
        Resource::Buffer(_) => None,
    })
}

/// Whether one pass reads all of these images: then its own barrier is the batch.
fn all_read_by(plan: &Plan, pass: usize, images: &[ImageId]) -> bool {
    let reads = plan.recording.passes[pass].reads();
    images.iter().all(|image| reads.contains(&Resource::Image(*image)))
}

/// Whether the residents before were read after they were written: only then is waiting enough, without a barrier for their writes.
fn were_read(new: &AliasingBarrier, finished: &[bool]) -> bool {
    new.residents.iter().all(|resident| finished[resident.0 as usize])
}

fn for_each_phase(
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
