//! How the textures of a module are read.

/// How a module's textures are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SampleMode {
    /// Finite numbers, filtered by the device.
    #[default]
    Plain,
    /// Finite numbers that the device cannot filter.
    ByHand,
    /// Colours from outside: guarded, then filtered by hand.
    Guarded,
    /// Signed data from outside: guarded, then filtered by hand.
    GuardedSigned,
}

impl SampleMode {
    pub(crate) fn settings(self) -> String {
        let guard = match self {
            Self::Plain | Self::ByHand => 0,
            Self::Guarded => 1,
            Self::GuardedSigned => 2,
        };
        let by_hand = self != Self::Plain;
        format!("const TEXEL_GUARD: u32 = {guard}u;\nconst TAP_BY_HAND: bool = {by_hand};")
    }

    /// The function that a loaded texel goes through; empty for none.
    pub fn guard_call(self) -> &'static str {
        match self {
            Self::Plain | Self::ByHand => "",
            Self::Guarded => "guard",
            Self::GuardedSigned => "guard_signed",
        }
    }
}
