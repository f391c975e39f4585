//! The split of a frame by passes.

use afterimage_gpu::{Clock, FrameStep, GpuError, InputImage, LoadedPlan, TimedCommands, median};

use super::{Session, with_frame};

impl Session {
    /// Median milliseconds of each pass of the loaded plan: by timestamps between the passes, or, where timestamps
    /// cannot be trusted, of each pass submitted alone.
    ///
    /// The sum is more than [`frame_time`](Self::frame_time), because passes of one batch do not overlap here, and each
    /// frame runs also the passes that run after a change of their uniforms.
    ///
    /// # Errors
    /// See [`encode`](Self::encode) and [`Clock::medians`].
    pub fn pass_times(
        &mut self,
        clock: &Clock,
        samples: u32,
        images: &[InputImage],
        steps: &mut dyn FnMut() -> FrameStep,
    ) -> Result<Vec<f64>, GpuError> {
        if !clock.is_gpu() || !self.executor().enable_timing()? {
            return self.alone(clock, samples, images, steps());
        }
        let mut all = vec![Vec::new(); self.plan().passes.len()];
        for _ in 0..samples {
            self.executor().loaded_mut().into_iter().for_each(LoadedPlan::force_on_change);
            let times = self.one(images, steps())?;
            all.iter_mut().zip(times).for_each(|(samples, time)| samples.push(time));
        }
        Ok(all.into_iter().map(median).collect())
    }

    /// Milliseconds of each pass of one frame by timestamps. `None` where the device has none inside passes, and on a
    /// processor, whose drivers count what a pass draws as time of a later one.
    ///
    /// # Errors
    /// See [`encode`](Self::encode).
    pub fn pass_times_once(&mut self, images: &[InputImage], step: FrameStep) -> Result<Option<Vec<f64>>, GpuError> {
        if self.gpu.is_processor() || !self.executor().enable_timing()? {
            return Ok(None);
        }
        self.one(images, step).map(Some)
    }

    fn one(&mut self, images: &[InputImage], step: FrameStep) -> Result<Vec<f64>, GpuError> {
        self.submit(images, step)?;
        Ok(self.executor().loaded().map_or(Ok(None), LoadedPlan::pass_times)?.unwrap_or_default())
    }

    fn alone(
        &mut self,
        clock: &Clock,
        samples: u32,
        images: &[InputImage],
        step: FrameStep,
    ) -> Result<Vec<f64>, GpuError> {
        let passes = self.plan().passes.len();
        let executor = self.executor();
        let mut one = |pass| {
            let work: TimedCommands<'_> =
                Box::new(|encoder| with_frame(images, step, |frame| executor.encode_pass(encoder, frame, pass)));
            Ok(clock.medians(samples, &mut [work])?[0].ms())
        };
        (0..passes).map(&mut one).collect()
    }
}
