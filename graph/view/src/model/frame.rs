//! Renders a frame: the images, the shown pipeline and the others.

use afterimage_gpu::wgpu;

use super::{Chain, FrameImages, Model, Moment};
use crate::Problem;

/// What a call of [`Model::render`] has done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rendered {
    New,
    /// Nothing has changed, so nothing was rendered.
    Same,
    /// The previous pictures stay: see [`Model::problem`].
    Failed,
    /// Nothing yet: the window is shown first, because the first plan may compile for seconds.
    Later,
}

impl Model {
    /// Records the next frame, `elapsed` seconds after the last call, if time runs or something has changed.
    pub fn render(&mut self, encoder: &mut wgpu::CommandEncoder, elapsed: f64) -> Rendered {
        self.faults.take(&self.gpu, &self.chains);
        let advanced = self.clock.advance(elapsed);
        let is_changing = self.chains.shown.iter().chain(&self.chains.inspected).any(Chain::is_changing);
        let must_run = self.is_stale || is_changing || self.faults.is_busy();
        if self.graph.is_none() || advanced.is_none() && !must_run {
            return Rendered::Same;
        }
        let moment = advanced.unwrap_or_else(|| self.clock.again());
        match self.record(encoder, moment) {
            Ok(()) => {
                self.is_stale = false;
                self.forget_problem();
                Rendered::New
            }
            Err(problem) => {
                self.is_stale = false;
                self.problem = Some(problem);
                Rendered::Failed
            }
        }
    }

    fn record(&mut self, encoder: &mut wgpu::CommandEncoder, moment: Moment) -> Result<(), Problem> {
        let chains = &mut self.chains;
        let Some(shown) = &mut chains.shown else { return Ok(()) };
        if let Some((_, chain)) = &chains.compared {
            self.images.require(&chain.graph().inputs)?;
        }
        let images = self.images.at(moment, &shown.graph().inputs, encoder)?;
        shown.frame(encoder, &images, moment)?;
        for chain in [&mut chains.inspected, &mut chains.reference].into_iter().flatten() {
            chain.frame(encoder, &images, moment)?;
        }
        if let Some((_, chain)) = &mut chains.compared {
            let images = self.images.again(&chain.graph().inputs)?;
            chain.frame(encoder, &images, moment)?;
        }
        self.faults.record(&self.gpu, encoder, &mut self.chains, &images)?;
        self.fed = images;
        Ok(())
    }

    /// The images that the last frame was made from.
    pub fn fed(&self) -> &FrameImages {
        &self.fed
    }
}
