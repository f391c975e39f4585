//! Other pictures to compare the shown one with.

/// Another picture to compare the shown one with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CompareWith {
    /// The pipeline as the file has it, without the user's changes.
    Written,
    /// The same pipeline with 32-bit intermediates.
    Reference,
    /// Another tier, with the user's changes; `None` is the pipeline without one.
    Tier(Option<String>),
    Pipeline(String),
}

impl CompareWith {
    pub fn name(&self) -> String {
        match self {
            Self::Written => "as saved".into(),
            Self::Reference => "32-bit reference".into(),
            Self::Tier(None) => "no tier".into(),
            Self::Tier(Some(tier)) => format!("tier {tier}"),
            Self::Pipeline(name) => format!("{name}.ron"),
        }
    }
}
