//! Single passes of the plan in use.

use wgpu::CommandEncoder;

use super::Executor;
use super::frame::Frame;
use super::host_draw::{DrawTargets, check_filled};
use super::record::record;
use crate::GpuError;

impl Executor {
    /// The attachments of a pass that the host fills, by the name of its node; `None` if the plan in use has none.
    pub fn draw_targets(&self, node: &str) -> Option<DrawTargets> {
        DrawTargets::of(self.plan()?, node)
    }

    /// Records one pass of a frame and no other, for measurements on devices whose timestamps are not reliable. It
    /// reads what the frames before have left, and the frame number stays.
    pub fn encode_pass(
        &mut self,
        encoder: &mut CommandEncoder,
        frame: &Frame<'_>,
        pass: usize,
    ) -> Result<(), GpuError> {
        let set = self.host_set(frame)?;
        let loaded = self.loaded.as_ref().ok_or(GpuError::NoPlan)?;
        check_filled(&loaded.plan, pass..pass + 1, &[])?;
        let ring_index = (self.frame_index % loaded.residency.ring_length) as usize;
        record(loaded, &loaded.sets[set], (ring_index, &self.frame_constants), pass..pass + 1, (encoder, &mut []));
        Ok(())
    }
}
