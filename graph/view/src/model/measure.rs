//! Measures what each node would save.

use afterimage_gpu::wgpu;

use super::{FrameImages, Model, Moment, Savings};
use crate::Problem;

impl Model {
    /// Begins to measure what each node would save if it were off. Any change ends it.
    ///
    /// # Errors
    /// The device has no timestamps inside of passes, or nothing has run yet.
    pub fn measure_savings(&mut self) -> Result<(), Problem> {
        let shown = self.chains.shown.as_ref().filter(|shown| shown.pass_times().is_some());
        let shown = shown.ok_or_else(|| Problem::message("no GPU times have arrived from this device"))?;
        let Some(graph) = self.present_graph() else { return Ok(()) };
        self.savings = Savings::of(shown, graph);
        Ok(())
    }

    /// What each node would save, as far as it has been measured since the last change.
    pub fn savings(&self) -> Option<&Savings> {
        self.savings.as_ref()
    }

    pub(super) fn is_measuring(&self) -> bool {
        self.savings.as_ref().is_some_and(|savings| savings.left() > 0)
    }

    /// Records the frame without a node, if that is measured.
    pub(super) fn record_savings(&mut self, encoder: &mut wgpu::CommandEncoder, images: &FrameImages, moment: Moment) {
        if let (Some(savings), Some(shown)) = (&mut self.savings, &self.chains.shown) {
            savings.frame(shown, encoder, images, moment);
        }
    }
}
