//! The state of a sequence between two frames, so that another session continues it bit for bit.

use afterimage_plan::{StateContent, StateItem};
use wgpu::TextureUsages;

use super::Session;
use crate::GpuError;
use crate::executor::StatePart;
use crate::platform::caught;
use crate::post::PostError;
use crate::store;

/// The contents of an item of the state of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct StateBytes {
    /// The item.
    pub item: StateItem,
    /// Its bytes: those of the buffer, or the texels of each frame, the last frame first, row by row without gaps.
    pub bytes: Vec<u8>,
}

impl Session {
    /// The state after the last frame, in the order of [`Plan::state`](afterimage_plan::Plan::state). Waits for the
    /// GPU.
    ///
    /// # Errors
    /// The device is lost or has no memory for the copies; [`GpuError::Format`] for a history that cannot be copied: a
    /// depth buffer, or several samples in a pixel.
    ///
    /// # Panics
    /// If nothing was loaded or rendered yet.
    pub fn read_state(&mut self) -> Result<Vec<StateBytes>, PostError> {
        let mut state = Vec::new();
        for item in self.plan().clone().state() {
            let mut bytes = Vec::new();
            for part in self.post.executor().state_parts(&item) {
                bytes.extend(match part {
                    StatePart::Buffer(buffer) => self.readback.bytes(&buffer, buffer.size())?,
                    StatePart::Image(stored) => {
                        check_copied(&item, stored.texture.usage(), TextureUsages::COPY_SRC)?;
                        self.readback.levels(&stored.texture, stored.desc.format)?
                    }
                });
            }
            if let StateContent::Buffer { bytes: length, .. } = item.content {
                bytes.truncate(length as usize);
            }
            state.push(StateBytes { item, bytes });
        }
        Ok(state)
    }

    /// Continues from a state: the next frame follows the one after which it was read, by a session with a plan of the
    /// same state. A frame with `reset` begins anew all the same. `last` is the number of the frame before, if it is
    /// known not to be the one before the next.
    ///
    /// # Errors
    /// As [`read_state`](Self::read_state).
    ///
    /// # Panics
    /// If nothing was loaded yet, or if the state is that of another plan: items or numbers of bytes differ.
    pub fn write_state(&mut self, state: &[StateBytes], last: Option<u32>) -> Result<(), PostError> {
        let items = self.plan().clone().state();
        assert_eq!(items.len(), state.len(), "the state is that of another plan");
        let queue = self.gpu.queue.clone();
        for (item, given) in items.iter().zip(state) {
            let parts = self.post.executor().state_parts(item);
            assert!(given.bytes.len().is_multiple_of(parts.len().max(1)), "the state is that of another plan");
            let length = given.bytes.len() / parts.len().max(1);
            for (part, bytes) in parts.iter().zip(given.bytes.chunks(length.max(1))) {
                match part {
                    StatePart::Buffer(buffer) => {
                        caught("the state of a sequence", || queue.write_buffer(buffer, 0, bytes))?;
                    }
                    StatePart::Image(stored) => {
                        check_copied(item, stored.texture.usage(), TextureUsages::COPY_DST)?;
                        store::upload_levels(&queue, stored, bytes)?;
                    }
                }
            }
        }
        self.post.executor().continue_state(last);
        Ok(())
    }

    /// Sets the number of the next frame, from which noise is made; further ones count on. Histories go on.
    pub fn number_next(&mut self, number: u32) {
        self.post.executor().number_next(number);
    }
}

fn check_copied(item: &StateItem, usage: TextureUsages, needed: TextureUsages) -> Result<(), GpuError> {
    match usage.contains(needed) {
        true => Ok(()),
        false => Err(GpuError::Format { what: format!("a copy of the history `{}`", item.name) }),
    }
}
