//! The passes of meters, which make the state without the rest of a frame.

use afterimage_graph::node::{BufferId, Resource};
use wgpu::{Buffer, CommandEncoder};

use super::frame_counter::FrameNumbers;
use super::{Executor, Frame, FrameCommands, FrameKind};
use crate::GpuError;

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
        let numbers = FrameNumbers { resets: frame.kind == FrameKind::Cut, ..self.frames.next(frame.kind) };
        let constants = numbers.constants(frame);
        let levels = self.view_levels(frame)?;
        let frame = &Frame { levels: &levels, ..*frame };
        let loaded = self.loaded.as_mut().ok_or(GpuError::NoPlan)?;
        let groups = self.host.bind(&self.compiler, loaded, frame)?;
        loaded.set_host_uniforms(frame)?;
        loaded.due.choose_only(passes);
        self.begin_frame(encoder, constants, false)?;
        let loaded = self.loaded.as_mut().ok_or(GpuError::NoPlan)?;
        let commands = FrameCommands {
            loaded,
            groups: &loaded.bind_groups[groups],
            ring_index: (numbers.index % loaded.residency.ring_length) as usize,
            constants: &constants,
        };
        commands.clear_zeroed(encoder);
        for &pass in passes {
            commands.record(pass..pass + 1, encoder, &mut []);
        }
        let written: Vec<Resource> = passes.iter().flat_map(|pass| loaded.plan.passes[*pass].pass.writes()).collect();
        loaded.uninitialized.retain(|resource| !written.contains(resource));
        loaded.set_last_constants(None);
        self.frames.is_fresh = false;
        Ok(())
    }
}
