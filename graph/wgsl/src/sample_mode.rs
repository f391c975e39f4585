//! Sampling of the textures of a module.

use afterimage_base::image::Signedness;
use serde::Serialize;

/// Sampling of a module's textures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
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

    /// The mode that sanitizes to these limits.
    pub fn sanitizing(signedness: Signedness) -> Self {
        match signedness {
            Signedness::Unsigned => Self::Sanitized,
            Signedness::Extended => Self::SanitizedLight,
            Signedness::Signed => Self::SanitizedSigned,
        }
    }

    /// The WGSL expression of the texel of a texture at the pixel of the result.
    pub fn pixel_read(self, texture: &str) -> String {
        match self.number() {
            None => format!("textureLoad({texture}, at.pixel, 0)"),
            Some(number) => format!("sanitize_texel({texture}, at.pixel, {number}u)"),
        }
    }

    /// Returns whether texels are sanitized.
    pub fn sanitizes(self) -> bool {
        self.number().is_some()
    }

    /// The WGSL expression of the largest bits of a loaded texel: those of the limit at most, if nothing about it has
    /// to change.
    pub fn largest_bits(self, texel: &str) -> String {
        format!("sanitize_largest(bitcast<vec4u>({texel}), {}u)", self.number().unwrap_or(0))
    }

    /// The WGSL expression of a loaded texel, sanitized.
    pub fn sanitized(self, texture: &str, at: &str, texel: &str) -> String {
        format!("sanitize_loaded({texture}, {at}, {texel}, {}u)", self.number().unwrap_or(0))
    }

    /// The WGSL expression of the result of an untrusted kernel, within the limits of the mode.
    pub fn limited(self, value: &str) -> String {
        self.number().map_or(value.to_owned(), |number| format!("sanitize_result({value}, {number}u)"))
    }

    /// The number of the mode in WGSL, if it sanitizes.
    fn number(self) -> Option<u32> {
        match self {
            Self::Plain | Self::ByHand => None,
            Self::Sanitized => Some(1),
            Self::SanitizedSigned => Some(2),
            Self::SanitizedLight => Some(3),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number stands in the constants of a module and in each read of a pixel: 0 to 3 of `sampling.wgsl`.
    #[test]
    fn each_mode_has_one_number_in_all_code() {
        for (signedness, number) in [(Signedness::Unsigned, 1), (Signedness::Signed, 2), (Signedness::Extended, 3)] {
            let mode = SampleMode::sanitizing(signedness);
            assert_eq!(mode.pixel_read("t"), format!("sanitize_texel(t, at.pixel, {number}u)"));
            assert_eq!(mode.sanitized("t", "p", "v"), format!("sanitize_loaded(t, p, v, {number}u)"));
            assert_eq!(mode.limited("v"), format!("sanitize_result(v, {number}u)"));
            assert!(mode.constants().contains(&("TEXEL_SANITIZE", ["1u", "2u", "3u"][number - 1])), "{mode:?}");
        }
        for mode in [SampleMode::Plain, SampleMode::ByHand] {
            assert_eq!((mode.pixel_read("t"), mode.limited("v")), ("textureLoad(t, at.pixel, 0)".into(), "v".into()));
        }
    }
}
