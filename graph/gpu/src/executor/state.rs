//! The memory of the state of a plan: buffers that outlive frames, and the textures of histories.

use afterimage_plan::{StateContent, StateItem};
use wgpu::Buffer;

use super::Executor;
use crate::executor::loaded::residency::{ImageBinding, ring_place};
use crate::store::Stored;

/// A part of the memory of an item of the state.
#[derive(Clone)]
pub(crate) enum StatePart {
    /// A buffer.
    Buffer(Buffer),
    /// The image of one frame.
    Image(Stored),
}

impl Executor {
    /// The memory of an item of the plan in use, as the next frame reads it: a buffer, or an image for each frame, the
    /// last frame first.
    pub(crate) fn state_parts(&self, item: &StateItem) -> Vec<StatePart> {
        let Some(loaded) = &self.loaded else { return Vec::new() };
        match item.content {
            StateContent::Buffer { buffer, .. } => {
                vec![StatePart::Buffer(loaded.residency.buffers[buffer.0 as usize].clone())]
            }
            StateContent::History { image, frames, .. } => {
                let ImageBinding::Ring(ring, _) = &loaded.residency.bindings[image.0 as usize] else {
                    return Vec::new();
                };
                let of_age = |age| StatePart::Image(ring[ring_place(ring.len(), self.frame_index, age)].clone());
                (1..=frames).map(of_age).collect()
            }
        }
    }

    /// Notes that the memory of the state was written: the next frame continues from it.
    pub(crate) fn continue_state(&mut self) {
        self.fresh = false;
        if let Some(loaded) = &mut self.loaded {
            loaded.uninitialized.clear();
        }
    }
}
