//! Frames that are measured in any order, and the state that follows from what was measured.

use afterimage_gpu::internal::{caught, submit};
use afterimage_gpu::{Frame, FrameStep, GpuError, InputImage};
use afterimage_graph::node::BlockData;
use afterimage_plan::Metering;

use super::{Session, with_frame};

impl Session {
    /// Measures a frame of the loaded plan: runs the passes that measure and no other. Returns the bytes of each buffer
    /// of [`Metering::measured`]. Waits for the GPU.
    ///
    /// # Errors
    /// As [`encode`](Self::encode).
    ///
    /// # Panics
    /// If nothing was loaded yet, or if the meters are those of another plan.
    pub fn measure(
        &mut self,
        metering: &Metering,
        images: &[InputImage],
        step: FrameStep,
    ) -> Result<Vec<Vec<u8>>, GpuError> {
        self.submit_passes(images, step, &metering.measuring)?;
        let mut measured = Vec::new();
        for id in &metering.measured {
            let length = self.plan().buffers[id.0 as usize].bytes;
            let buffer = self.post.executor().loaded().expect("a plan is loaded").plan_buffer(*id).clone();
            let mut bytes = self.readback.bytes(&buffer, buffer.size())?;
            bytes.truncate(length as usize);
            measured.push(bytes);
        }
        Ok(measured)
    }

    /// Puts what was measured in a frame together with the state before it, which begins anew if `step` resets: after
    /// it the state of [`Metering::state`] is that after the frame. Other state is as before. `images` are bound and
    /// not read: those of any frame.
    ///
    /// # Errors
    /// As [`encode`](Self::encode).
    ///
    /// # Panics
    /// If nothing was loaded yet, or if the meters are those of another plan.
    pub fn integrate(
        &mut self,
        metering: &Metering,
        images: &[InputImage],
        step: FrameStep,
        measured: &[Vec<u8>],
    ) -> Result<(), GpuError> {
        assert_eq!(metering.measured.len(), measured.len(), "the meters are those of another plan");
        let queue = self.gpu.queue.clone();
        for (id, bytes) in metering.measured.iter().zip(measured) {
            let buffer = self.post.executor().loaded().expect("a plan is loaded").plan_buffer(*id).clone();
            caught("what was measured", || queue.write_buffer(&buffer, 0, bytes))?;
        }
        self.submit_passes(images, step, &metering.integrating)
    }

    fn submit_passes(&mut self, images: &[InputImage], step: FrameStep, passes: &[usize]) -> Result<(), GpuError> {
        let blocks: Vec<(&str, &BlockData)> = self.blocks.iter().map(|(name, data)| (name.as_str(), data)).collect();
        let executor = self.post.executor();
        submit(&self.gpu.device, &self.gpu.queue, "the passes of meters", |encoder| {
            with_frame(images, step, |frame| {
                executor.encode_passes(encoder, &Frame { blocks: &blocks, ..*frame }, passes)
            })
        })
    }
}
