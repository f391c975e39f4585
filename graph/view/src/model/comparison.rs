//! Other pictures to compare the shown one with.

/// The place of a snapshot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    A,
    B,
}

impl Slot {
    pub const ALL: [Self; 2] = [Self::A, Self::B];

    pub fn name(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
        }
    }
}

/// Another picture to compare the shown one with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CompareWith {
    /// The pipeline as the file has it, without the user's changes.
    Written,
    /// The text and the values of a moment that the user has chosen.
    Snapshot(Slot),
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
            Self::Snapshot(slot) => format!("snapshot {}", slot.name()),
            Self::Reference => "32-bit reference".into(),
            Self::Tier(None) => "no tier".into(),
            Self::Tier(Some(tier)) => format!("tier {tier}"),
            Self::Pipeline(name) => format!("{name}.ron"),
        }
    }
}
