//! A change of tier, and why.

use std::fmt;

/// Why a tier was changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TierChangeReason {
    /// Frames take more than the budget.
    Over,
    /// Frames take longer every second, and will soon take more than the budget.
    Rising,
    /// More than one frame of a hundred is over the budget, and the others are not.
    Spikes,
    /// The spikes are the same at a cheaper tier.
    SpikesStay,
    /// A better tier is expected to stay within the budget.
    Room,
    /// A better tier might do so: its cost is not known here, or was measured long ago.
    Trial,
}

/// A change of tier.
#[derive(Clone, Debug, PartialEq)]
pub struct TierChange {
    /// The name of the tier before.
    pub from: String,
    /// The name of the tier from now on.
    pub to: String,
    /// Why.
    pub reason: TierChangeReason,
    /// Milliseconds at the tier before that were compared with the budget: the median of the last frames, or what 99 of
    /// 100 frames stay below without spikes.
    pub ms: f64,
    /// The same at the tier from now on, as expected from the costs that are known.
    pub expected_ms: f64,
    /// The budget in milliseconds.
    pub budget_ms: f64,
    /// How many of the last frames were over the budget.
    pub frames_over: usize,
    /// The number of these last frames, all at the tier before.
    pub frames: usize,
}

impl fmt::Display for TierChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { from, to, reason, ms, expected_ms, budget_ms, frames_over, frames } = self;
        write!(f, "{from} to {to}: ")?;
        match reason {
            TierChangeReason::Over => write!(f, "{ms:.2} ms, over {budget_ms:.2}; {expected_ms:.2} ms expected"),
            TierChangeReason::Rising => {
                write!(f, "{ms:.2} ms soon, over {budget_ms:.2}; {expected_ms:.2} ms expected")
            }
            TierChangeReason::Room => write!(f, "{ms:.2} ms; {expected_ms:.2} ms expected, within {budget_ms:.2}"),
            TierChangeReason::Trial => {
                write!(f, "{ms:.2} ms, within {budget_ms:.2}; a trial, {expected_ms:.2} ms are a guess")
            }
            TierChangeReason::Spikes => {
                write!(f, "{frames_over} of {frames} frames over {budget_ms:.2} ms, {ms:.2} ms without spikes")
            }
            TierChangeReason::SpikesStay => {
                write!(
                    f,
                    "{frames_over} of {frames} frames over {budget_ms:.2} ms here, too, {ms:.2} ms without spikes"
                )
            }
        }
    }
}
