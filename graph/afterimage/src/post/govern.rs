//! A pipeline that changes its tier by itself to hold a budget.

use afterimage_gpu::{GpuError, LoadedPlan};

use super::Post;
use super::governed::{Governed, TimeSource};
use crate::error::{Error, PostError};
use crate::governor::{Governor, TierChange, TierLimits};

impl Post {
    /// Holds a budget in milliseconds from the next frame on: a [`Governor`] chooses one of these tiers, which are in
    /// order from the worst picture to the best, and begins with the first. It begins with the costs that the pipeline
    /// [claims](Self::claim). Each change is one as by [`set_tier`](Self::set_tier), in the background, and
    /// [fades](Self::set_fade) if changes do.
    ///
    /// With a floor, as in `TierLimits::new(4.0).min_jod(9.0)`, it never chooses a tier that claims less. Where no tier
    /// holds both limits, the floor comes first, and [`Governor::shortfall`] has the reason.
    ///
    /// It measures the passes of this pipeline, as [`time_passes`](Self::time_passes) does, unless the host
    /// [reports](Self::report_frame_time) times of its own. Where the device has no timestamps inside passes and the
    /// host reports none, the first tier stays. A tier whose plan cannot be made is not taken again for a while.
    ///
    /// # Errors
    /// There is no such tier, or none in the list. Nothing changes.
    pub fn govern(&mut self, limits: impl Into<TierLimits>, tiers: &[&str]) -> Result<(), Error> {
        if tiers.is_empty() {
            return Err(PostError::NoTier.into());
        }
        let governed = Governed::new(&self.files()?.snapshot, limits.into(), tiers, self.frame)?;
        governed.governor.shortfall().iter().for_each(|shortfall| log::info!("{shortfall}"));
        self.change(governed.present_graph());
        self.governed = Some(governed);
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
