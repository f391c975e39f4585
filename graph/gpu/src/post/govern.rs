//! A pipeline that changes its tier by itself to hold a budget.

use afterimage_graph::check::Graph;

use super::Post;
use super::error::PostError;
use super::governed::{Governed, TierGraph, TimeSource};
use crate::error::GpuError;
use crate::governor::{GovernedTier, Governor, TierChange};

impl Post {
    /// Holds a budget in milliseconds from the next frame on: a [`Governor`] chooses one of the tiers, which are in
    /// order from the worst picture to the best, and begins with the first. Each change is one as by
    /// [`change`](Self::change), in the background, and [fades](Self::set_fade) if changes do.
    ///
    /// It measures the passes of this pipeline, as [`time_passes`](Self::time_passes) does, unless the host
    /// [reports](Self::report_frame_time) times of its own. Where the device has no timestamps inside passes and the
    /// host reports none, the first tier stays. A tier whose plan cannot be made is not taken again for a while.
    ///
    /// # Errors
    /// There is no tier. Nothing changes.
    pub fn govern(&mut self, budget_ms: f64, tiers: Vec<TierGraph>) -> Result<(), PostError> {
        if tiers.is_empty() {
            return Err(PostError::NoTier);
        }
        let (tiers, graphs): (Vec<GovernedTier>, Vec<Graph>) =
            tiers.into_iter().map(|tier| (tier.tier, tier.graph)).unzip();
        let governor = Governor::new(budget_ms, &tiers);
        self.change(graphs[governor.tier()].clone());
        let (source, taken) = (TimeSource::Passes, self.frame);
        self.governed = Some(Governed { governor, graphs, source, taken, seconds: 0.0, last_change: None });
        Ok(())
    }

    /// Replaces the graphs of the governed tiers, in the same order: the pipeline file has changed. The tier and what
    /// was learned of costs stay.
    ///
    /// # Errors
    /// There is another number of them than of tiers. Nothing changes.
    pub fn change_governed(&mut self, graphs: Vec<Graph>) -> Result<(), PostError> {
        let Some(governed) = &mut self.governed else { return Ok(()) };
        if graphs.len() != governed.graphs.len() {
            return Err(PostError::OtherTiers { wanted: governed.graphs.len(), given: graphs.len() });
        }
        governed.graphs = graphs;
        let graph = governed.present_graph();
        self.change(graph);
        Ok(())
    }

    /// Keeps the present tier from now on.
    pub fn stop_governing(&mut self) {
        self.governed = None;
    }

    /// What [chooses](Self::govern) the tier.
    pub fn governor(&self) -> Option<&Governor> {
        self.governed.as_ref().map(|governed| &governed.governor)
    }

    /// The same, for another budget.
    pub fn governor_mut(&mut self) -> Option<&mut Governor> {
        self.governed.as_mut().map(|governed| &mut governed.governor)
    }

    /// The last change of tier that the governor made, with its reason.
    pub fn tier_change(&self) -> Option<&TierChange> {
        self.governed.as_ref()?.last_change.as_ref()
    }

    /// Reports the GPU time of a frame in milliseconds, for [`govern`](Self::govern): for example that of the host's
    /// whole frame, if the budget is for that. `frame` is its number, as [`frame`](Self::frame) counts them; times come
    /// in the order of their frames. From the first call on, the passes are no longer the measure.
    pub fn report_frame_time(&mut self, frame: u64, ms: f64) {
        if let Some(governed) = &mut self.governed {
            governed.source = TimeSource::Host;
            if let Some(change) = governed.take(frame, ms) {
                self.change_tier(change);
            }
        }
    }

    /// Gives the governor the newest times, after a frame was recorded.
    pub(super) fn follow_governor(&mut self, dt: f32) -> Result<(), GpuError> {
        let Some(governed) = &mut self.governed else { return Ok(()) };
        governed.seconds += f64::from(dt);
        let has_tier = self.active.as_ref().is_some_and(|active| active.revision() == self.graph.revision.graph);
        if !has_tier || self.fade.is_running() {
            governed.taken = self.frame;
            let has_failed = !has_tier && !self.is_changing();
            if has_failed && let Some(governed) = &mut self.governed {
                governed.governor.refuse();
                let graph = governed.present_graph();
                self.change(graph);
            }
            return Ok(());
        }
        if governed.source != TimeSource::Passes {
            return Ok(());
        }
        if self.executor.timestamps().is_none() && !self.executor.enable_timing()? {
            governed.source = TimeSource::None;
        }
        if let Some(times) = &self.readings.pass_times.latest
            && let Some(change) = governed.take(times.frame, times.sum())
        {
            self.change_tier(change);
        }
        Ok(())
    }

    fn change_tier(&mut self, change: TierChange) {
        let Some(governed) = &mut self.governed else { return };
        log::info!("{change}");
        governed.last_change = Some(change);
        governed.taken = self.frame;
        let graph = governed.present_graph();
        self.change(graph);
    }
}
