//! A change of tier, and its reason.

use std::fmt;

/// The reason for a change of tier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TierChangeReason {
    /// Frames take more than the budget, or will soon do so.
    Over,
    /// More than one frame of a hundred is over the budget, and the others are not.
    Spikes,
    /// A better tier is expected to stay within the budget.
    Room,
    /// A better tier might do so: it was not tried yet, or failed long ago.
    Trial,
}

/// A change of tier.
#[derive(Clone, Debug, PartialEq)]
pub struct TierChange {
    /// The name of the tier before.
    pub from: String,
    /// The name of the tier from now on.
    pub to: String,
    /// The reason.
    pub reason: TierChangeReason,
    /// Milliseconds at the tier before that were compared with the budget: those that 99 of 100 frames stay below, or
    /// after a trial that has failed, those that the last frames exceed.
    pub ms: f64,
    /// The same at the tier from now on, as expected from the changes so far.
    pub expected_ms: f64,
    /// The budget in milliseconds.
    pub budget_ms: f64,
    /// The claim of the tier from now on in JOD.
    pub jod: Option<f64>,
    /// The least claim in JOD of a tier that may be chosen.
    pub min_jod: Option<f64>,
}

impl fmt::Display for TierChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { from, to, reason, ms, expected_ms, budget_ms, jod, min_jod } = self;
        write!(f, "{from} to {to}: ")?;
        match reason {
            TierChangeReason::Over => write!(f, "{ms:.2} ms, over {budget_ms:.2}; {expected_ms:.2} ms expected"),
            TierChangeReason::Spikes => {
                write!(f, "more than 1 % of the frames over {budget_ms:.2} ms, {ms:.2} ms without spikes")
            }
            TierChangeReason::Room => write!(f, "{ms:.2} ms; {expected_ms:.2} ms expected, within {budget_ms:.2}"),
            TierChangeReason::Trial => {
                write!(f, "{ms:.2} ms, within {budget_ms:.2}; a trial, {expected_ms:.2} ms are a guess")
            }
        }?;
        jod.map_or(Ok(()), |jod| write!(f, "; {jod:.2} JOD"))?;
        min_jod.map_or(Ok(()), |least| write!(f, ", at least {least:.2}"))
    }
}
