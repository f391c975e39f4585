//! Images that are larger than the device, in bands of rows.

use afterimage_gpu::{
    BandReader, BandStats, BandWriter, BandedFrame, FrameStep, bytes_of_whole_frame, render_in_bands,
};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_plan::{BandLimits, HostInputs, Plan, PlanError};

use super::Session;
use crate::error::PostError;

impl Session {
    /// `true` if the device has no memory for a frame of these images as a whole and for the texels on their way, or
    /// for one of the images.
    ///
    /// # Errors
    /// The graph cannot be planned for another reason.
    pub fn needs_bands(&mut self, size: Size, inputs: &[(&str, ImageDesc)]) -> Result<bool, PostError> {
        match self.post.plan_for(self.described(size, inputs)) {
            Err(PlanError::TooLarge { .. } | PlanError::TooMuchMemory { .. }) => Ok(true),
            planned => {
                let bytes = bytes_of_whole_frame(&self.gpu, &*planned?, inputs) + self.gpu.memory_used_by_others();
                let is_refused = inputs.iter().any(|(_, desc)| self.gpu.check_fits(*desc).is_err());
                Ok(is_refused || bytes > self.gpu.caps.max_memory)
            }
        }
    }

    fn described(&self, size: Size, inputs: &[(&str, ImageDesc)]) -> HostInputs {
        self.uploads.host_inputs(size, inputs.iter().map(|(name, desc)| (*name, *desc, false)))
    }

    /// The plan for images of any size, to be rendered in bands.
    ///
    /// # Errors
    /// The graph cannot be planned for these images.
    pub fn plan_in_bands(&self, size: Size, inputs: &[(&str, ImageDesc)]) -> Result<Plan, PostError> {
        Ok(self.post.plan_in_bands(self.described(size, inputs))?)
    }

    /// Renders one frame with a plan of [`plan_in_bands`](Self::plan_in_bands): bit for bit what the plan makes of
    /// whole images. `values` are those of nodes after the frame, by `node.port`.
    ///
    /// # Errors
    /// As [`render_in_bands`].
    pub fn render_in_bands<R: BandReader, W: BandWriter<Error = R::Error>>(
        &mut self,
        plan: &Plan,
        limits: BandLimits,
        step: FrameStep,
        number: u32,
        values: &[String],
        files: (&mut R, &mut W),
    ) -> Result<BandStats, R::Error> {
        let frame = BandedFrame { step, number, blocks: &self.uploads.blocks, values };
        render_in_bands(&self.gpu, plan, limits, &frame, files)
    }
}
