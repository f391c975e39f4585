//! The limits of a governor, and the reason why they are not held.

use std::fmt;

/// The limits that a [`Governor`](super::Governor) holds: `TierLimits::new(4.0).min_jod(9.0)`. Milliseconds alone are
/// limits, too.
#[derive(Clone, Debug, PartialEq)]
pub struct TierLimits {
    /// The budget in milliseconds.
    pub ms: f64,
    /// The least claim in JOD of a tier that may be chosen, 10 for no visible difference. With it, a tier without such
    /// a claim is not chosen. If no tier reaches it, as none reaches NaN, the best claim is the only choice, and the
    /// budget is not held.
    pub min_jod: Option<f64>,
    /// The display whose claims count, as `measure --display` names it; `None` for any.
    pub display: Option<String>,
}

impl TierLimits {
    /// A budget in milliseconds, and no other limit.
    pub fn new(ms: f64) -> Self {
        Self { ms, min_jod: None, display: None }
    }

    /// The same, without tiers that claim less than so many JOD, or nothing.
    pub fn min_jod(self, jod: f64) -> Self {
        Self { min_jod: Some(jod), ..self }
    }

    /// The same, with claims for this display alone.
    pub fn display(self, display: impl Into<String>) -> Self {
        Self { display: Some(display.into()), ..self }
    }
}

impl From<f64> for TierLimits {
    fn from(ms: f64) -> Self {
        Self::new(ms)
    }
}

/// The reason why a governor does not hold its limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Shortfall {
    /// The name of the tier that stays.
    pub tier: String,
    /// Its claim in JOD.
    pub jod: Option<f64>,
    /// The least claim in JOD of a tier that may be chosen.
    pub min_jod: Option<f64>,
    /// Milliseconds that 99 of 100 frames stay below, if they are over the budget.
    pub ms: Option<f64>,
    /// The budget in milliseconds.
    pub budget_ms: f64,
}

impl Shortfall {
    /// True if the tier claims less than the limits ask for, because each other one claims no more.
    pub fn is_of_quality(&self) -> bool {
        self.min_jod.is_some_and(|least| !self.jod.is_some_and(|jod| jod >= least))
    }
}

impl fmt::Display for Shortfall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { tier, jod, min_jod, ms, budget_ms } = self;
        let claimed = jod.map_or("without a claim".to_owned(), |jod| format!("of {jod:.2} JOD"));
        if let Some(least) = min_jod.filter(|_| self.is_of_quality()) {
            write!(f, "no tier claims {least:.2} JOD: {tier}, {claimed}, stays, and ")?;
            write!(f, "the budget of {budget_ms:.2} ms is not held")?;
            return ms.map_or(Ok(()), |ms| write!(f, "; frames take {ms:.2} ms"));
        }
        ms.map_or(Ok(()), |ms| write!(f, "{tier}, {claimed}, takes {ms:.2} ms, over {budget_ms:.2}, and "))?;
        match min_jod {
            Some(least) => write!(f, "no cheaper tier claims {least:.2} JOD"),
            None => write!(f, "no tier is cheaper"),
        }
    }
}
