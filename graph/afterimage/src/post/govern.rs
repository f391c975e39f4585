//! A pipeline that changes its tier by itself to hold a budget.

use afterimage_gpu::{GpuError, LoadedPlan};
use afterimage_graph::check::Graph;

use super::Post;
use super::governed::{Governed, TimeSource};
use crate::error::{Error, PostError};
use crate::governor::{GovernedTier, Governor, TierChange};

impl Post {
    /// Holds a budget in milliseconds from the next frame on: a [`Governor`] chooses one of these tiers, which are in
    /// order from the worst picture to the best, and begins with the first. It begins with the costs that the pipeline
    /// [claims](Self::claim). Each change is one as by [`set_tier`](Self::set_tier), in the background, and
    /// [fades](Self::set_fade) if changes do.
    ///
    /// It measures the passes of this pipeline, as [`time_passes`](Self::time_passes) does, unless the host
    /// [reports](Self::report_frame_time) times of its own. Where the device has no timestamps inside passes and the
    /// host reports none, the first tier stays. A tier whose plan cannot be made is not taken again for a while.
    ///
    /// # Errors
    /// There is no such tier, or none in the list. Nothing changes.
    pub fn govern(&mut self, budget_ms: f64, tiers: &[&str]) -> Result<(), Error> {
        if tiers.is_empty() {
            return Err(PostError::NoTier.into());
        }
        let snapshot = &self.files()?.snapshot;
        let graphs = tiers.iter().map(|tier| snapshot.graph(Some(tier))).collect::<Result<Vec<Graph>, Error>>()?;
        let tiers = tiers.iter().map(|tier| {
            let cost = snapshot.claim(tier).and_then(|claim| claim.ms);
            GovernedTier { name: (*tier).to_owned(), cost }
        });
        let governor = Governor::new(budget_ms, &tiers.collect::<Vec<_>>());
        self.change(graphs[governor.tier()].clone());
        let (source, taken) = (TimeSource::Passes, self.frame);
        self.governed = Some(Governed { governor, graphs, source, taken, seconds: 0.0, last_change: None });
        Ok(())
    }

    /// Keeps the present tier from now on.
    pub fn stop_governing(&mut self) {
        let tier = self.tier().map(str::to_owned);
        if let (Some(_), Some(opened)) = (self.governed.take(), &mut self.opened) {
            opened.tier = tier;
        }
    }

    /// The governor that [chooses](Self::govern) the tier.
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
        let revision = self.values.revision.graph;
        let has_tier = self.plans.active.as_ref().is_some_and(|active| active.revision() == revision);
        if !has_tier || self.fade.is_running() {
            governed.taken = self.frame;
            if !has_tier && !self.plans.is_changing() {
                governed.governor.refuse();
                let graph = governed.present_graph();
                self.change(graph);
            }
            return Ok(());
        }
        if governed.source != TimeSource::Passes {
            return Ok(());
        }
        if self.executor.loaded().and_then(LoadedPlan::timestamps).is_none() && !self.executor.enable_timing()? {
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
