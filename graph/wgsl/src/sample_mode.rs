//! How the textures of a module are read.

/// How a module's textures are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SampleMode {
    /// Finite numbers, filtered by the device.
    #[default]
    Plain,
    /// Finite numbers that the device cannot filter.
    ByHand,
    /// Colors of host images: sanitized, then filtered by hand.
    Sanitized,
    /// Signed data of host images: sanitized, then filtered by hand.
    SanitizedSigned,
}

impl SampleMode {
    pub(crate) fn settings(self) -> String {
        let sanitize = match self {
            Self::Plain | Self::ByHand => 0,
            Self::Sanitized => 1,
            Self::SanitizedSigned => 2,
        };
        let by_hand = self != Self::Plain;
        format!("const TEXEL_SANITIZE: u32 = {sanitize}u;\nconst TAP_BY_HAND: bool = {by_hand};")
    }

    /// The function that a loaded texel goes through; empty for none.
    pub fn sanitize_call(self) -> &'static str {
        match self {
            Self::Plain | Self::ByHand => "",
            Self::Sanitized => "sanitize",
            Self::SanitizedSigned => "sanitize_signed",
        }
    }
}
