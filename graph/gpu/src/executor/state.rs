//! The memory of the state of a plan: buffers that outlive frames, and the textures of histories. The passes of meters,
//! which make the state without the rest of a frame.

use afterimage_graph::node::{BufferId, Resource};
use afterimage_plan::{StateContent, StateItem};
use wgpu::{Buffer, CommandEncoder};

use super::{Executor, Frame, FrameCommands, FrameKind};
use crate::GpuError;
use crate::executor::loaded::residency::{ImageBinding, ring_place};
use crate::frame_constants::FrameConstants;
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
                let of_age = |ring: &[Stored], age| ring[ring_place(ring.len(), self.frame_index, age)].clone();
                match &loaded.residency.bindings[image.0 as usize] {
                    ImageBinding::Ring(ring, _) => {
                        (1..=frames).map(|age| StatePart::Image(of_age(ring, age))).collect()
                    }
                    ImageBinding::Fixed(held) => vec![StatePart::Image(held.clone())],
                    _ => Vec::new(),
                }
            }
        }
    }

    /// Notes that the memory of the state was written: the next frame continues from it, after the frame `last`.
    pub(crate) fn continue_state(&mut self, last: Option<u32>) {
        self.fresh = false;
        self.last_number = last;
        if let Some(loaded) = &mut self.loaded {
            loaded.uninitialized.clear();
            loaded.turns.made.fill();
            loaded.forget_frame();
        }
    }

    /// A buffer of the plan in use.
    pub(crate) fn plan_buffer(&self, buffer: BufferId) -> Option<&Buffer> {
        self.loaded.as_ref().map(|loaded| &loaded.residency.buffers[buffer.0 as usize])
    }

    /// Records some passes of a frame, which need no draws of the host, and no other. What these do not write stays as
    /// the frames before have left it; the frame number stays, too. Unless `frame` resets, state and histories go on.
    pub(crate) fn encode_passes(
        &mut self,
        encoder: &mut CommandEncoder,
        frame: &Frame<'_>,
        passes: &[usize],
    ) -> Result<(), GpuError> {
        let number = self.frame_index.wrapping_add(self.number_offset);
        let constants = FrameConstants::new(frame.time, frame.dt, number, frame.kind == FrameKind::Cut);
        let groups = self.bind(frame)?;
        self.begin_frame(encoder, frame, constants, false)?;
        let loaded = self.loaded.as_mut().ok_or(GpuError::NoPlan)?;
        loaded.turns.begin(0, None);
        let written: Vec<Resource> = passes.iter().flat_map(|pass| loaded.plan.passes[*pass].pass.writes()).collect();
        for &buffer in &loaded.zeroed {
            if written.contains(&Resource::Buffer(BufferId(buffer as u32))) {
                encoder.clear_buffer(&loaded.residency.buffers[buffer], 0, None);
            }
        }
        let commands = FrameCommands {
            loaded,
            groups: &loaded.bind_groups[groups],
            ring_index: (self.frame_index % loaded.residency.ring_length) as usize,
            constants: &constants,
            reached: None,
            // No frame has filled those that these passes need.
            fills_tables: true,
        };
        for &pass in passes {
            commands.record(pass..pass + 1, encoder, &mut []);
        }
        loaded.uninitialized.retain(|resource| !written.contains(resource));
        loaded.forget_frame();
        self.fresh = false;
        Ok(())
    }
}
