//! How the textures of a module are sampled.

/// How a module's textures are sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SampleMode {
    /// Finite numbers, filtered by the device.
    #[default]
    Plain,
    /// Finite numbers that the device cannot filter.
    ByHand,
    /// Signals and light of a display from host images: sanitized, then filtered by hand.
    Sanitized,
    /// Scene light of host images, with negative components: sanitized, then filtered by hand.
    SanitizedLight,
    /// Signed data of host images: sanitized, then filtered by hand.
    SanitizedSigned,
}

impl SampleMode {
    /// Values of constants of the library.
    pub(crate) fn constants(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Plain => &[],
            Self::ByHand => &[("TAP_BY_HAND", "true")],
            Self::Sanitized => &[("TAP_BY_HAND", "true"), ("TEXEL_SANITIZE", "1u")],
            Self::SanitizedLight => &[("TAP_BY_HAND", "true"), ("TEXEL_SANITIZE", "3u")],
            Self::SanitizedSigned => &[("TAP_BY_HAND", "true"), ("TEXEL_SANITIZE", "2u")],
        }
    }

    /// The WGSL expression of the texel of a texture at the pixel of the result.
    pub fn pixel_read(self, texture: &str) -> String {
        match self {
            Self::Plain | Self::ByHand => format!("textureLoad({texture}, at.pixel, 0)"),
            Self::Sanitized => format!("sanitize_texel({texture}, at.pixel, 1u)"),
            Self::SanitizedSigned => format!("sanitize_texel({texture}, at.pixel, 2u)"),
            Self::SanitizedLight => format!("sanitize_texel({texture}, at.pixel, 3u)"),
        }
    }
}
