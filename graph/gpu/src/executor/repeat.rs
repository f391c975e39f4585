//! A frame once more with other values of parameters: only the passes run that these reach.

use afterimage_graph::node::{BufferId, Resource};
use wgpu::CommandEncoder;

use crate::executor::loaded::Loaded;
use crate::frame_constants::FrameConstants;

impl Loaded {
    /// For each pass whether it runs in a frame that repeats the last one; `None` if all do.
    pub(crate) fn reached(&self) -> Option<Vec<bool>> {
        let last = self.repeat.as_ref().filter(|repeat| repeat.constants.is_some())?;
        let uniforms = self.uniforms.bytes();
        if self.plan.blocks.iter().any(|own| last.differs(uniforms, own.offset, own.block.bytes())) {
            return None;
        }
        let blocks = self.plan.passes.iter().map(|pass| &pass.uniform);
        let differ = blocks.map(|block| last.differs(uniforms, block.offset, block.bytes.len())).collect();
        Some(self.plan.reached_from(differ))
    }

    /// Before a frame: keeps the state for a repetition of it.
    pub(crate) fn keep_state(&self, encoder: &mut CommandEncoder) {
        let Some(repeat) = &self.repeat else { return };
        for (&index, kept) in self.persistent.iter().zip(&repeat.state) {
            encoder.copy_buffer_to_buffer(&self.residency.buffers[index], 0, kept, 0, None);
        }
    }

    /// Before a frame is repeated: restores the state that the passes write which run.
    pub(crate) fn restore_state(&self, reached: Option<&[bool]>, encoder: &mut CommandEncoder) {
        let Some(repeat) = &self.repeat else { return };
        for (&index, kept) in self.persistent.iter().zip(&repeat.state) {
            if self.is_written(index, reached) {
                encoder.copy_buffer_to_buffer(kept, 0, &self.residency.buffers[index], 0, None);
            }
        }
    }

    /// Whether a pass that runs writes a buffer; all run if it is not stated which.
    pub(crate) fn is_written(&self, buffer: usize, reached: Option<&[bool]>) -> bool {
        let buffer = Resource::Buffer(BufferId(buffer as u32));
        let mut passes = self.plan.work().enumerate();
        reached.is_none_or(|reached| passes.any(|(at, pass)| reached[at] && pass.writes().contains(&buffer)))
    }

    /// The last frame cannot be repeated: something else has run, or must run.
    pub(crate) fn forget_frame(&mut self) {
        if let Some(repeat) = &mut self.repeat {
            repeat.constants = None;
        }
    }

    /// The constants of the last frame, if it can be repeated from the state before it.
    pub(crate) fn last_constants(&self) -> Option<FrameConstants> {
        self.repeat.as_ref()?.constants
    }

    /// Notes that a frame with these constants was recorded.
    pub(crate) fn note_frame(&mut self, constants: FrameConstants, can_be_repeated: bool) {
        let Some(repeat) = &mut self.repeat else { return };
        repeat.uniforms.clear();
        repeat.uniforms.extend_from_slice(self.uniforms.bytes());
        repeat.constants = Some(constants).filter(|_| can_be_repeated);
    }
}
