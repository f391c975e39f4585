//! The passes of meters, which make the state without the rest of a frame.

use afterimage_graph::node::{BufferId, Resource};
use wgpu::{Buffer, CommandEncoder};

use super::{Executor, Frame, FrameCommands, FrameKind};
use crate::GpuError;
use crate::frame_constants::FrameConstants;

impl Executor {
    /// A buffer of the plan in use.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn plan_buffer(&self, buffer: BufferId) -> Option<&Buffer> {
        self.loaded.as_ref().map(|loaded| &loaded.residency.buffers[buffer.0 as usize])
    }

    /// Records some passes of a frame, which need no draws of the host, and no other. What these do not write stays as
    /// the frames before have left it; the frame number stays, too. Unless `frame` resets, state and histories go on.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn encode_passes(
        &mut self,
        encoder: &mut CommandEncoder,
        frame: &Frame<'_>,
        passes: &[usize],
    ) -> Result<(), GpuError> {
        let number = self.frame_index.wrapping_add(self.number_offset);
        let constants = FrameConstants::new(frame.time, frame.dt, number, frame.kind == FrameKind::Cut);
        let levels = self.view_levels(frame)?;
        let frame = &Frame { levels: &levels, ..*frame };
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
            fills_all_tables: true,
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
