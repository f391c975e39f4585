//! A pipeline in memory that changes its tier by itself to hold limits.

use super::Offline;
use crate::error::{Error, PostError};
use crate::governor::{Governor, TierChange, TierLimits};

impl Offline {
    /// Holds limits from the next frame on, as [`Post::govern`](crate::Post::govern) does: a [`Governor`] chooses one
    /// of these tiers, which are in order from the worst picture to the best, and begins with the first that reaches
    /// the floor. The host [reports](Self::report_frame_time) the time of each frame.
    ///
    /// # Errors
    /// There is no such tier, or none in the list. Nothing changes.
    pub fn govern(&mut self, limits: impl Into<TierLimits>, tiers: &[&str]) -> Result<(), Error> {
        if tiers.is_empty() {
            return Err(PostError::NoTier.into());
        }
        tiers.iter().try_for_each(|tier| self.graph_at(Some(tier)).map(drop))?;
        let governor = self.snapshot.governor(limits.into(), tiers);
        self.change(Some(governor.name().to_owned()), self.sets.clone())?;
        self.governor = Some(governor);
        Ok(())
    }

    /// Keeps the present tier from now on.
    pub fn stop_governing(&mut self) {
        self.governor = None;
    }

    /// The governor that [chooses](Self::govern) the tier.
    pub fn governor(&self) -> Option<&Governor> {
        self.governor.as_ref()
    }

    /// Reports the milliseconds of the last frame, and the seconds since the frame before. Returns the change that the
    /// next frame has; none without a governor.
    ///
    /// # Errors
    /// The tier that is chosen does not fit the changed parameters. It is not chosen again for a while.
    pub fn report_frame_time(&mut self, ms: f64, dt: f64) -> Result<Option<TierChange>, Error> {
        let Some(governor) = &mut self.governor else { return Ok(None) };
        let Some(change) = governor.frame(governor.tier(), ms, dt) else { return Ok(None) };
        let changed = self.change(Some(change.to.clone()), self.sets.clone());
        if let (Err(_), Some(governor)) = (&changed, &mut self.governor) {
            governor.refuse();
        }
        changed.map(|()| Some(change))
    }
}
