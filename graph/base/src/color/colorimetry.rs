//! The meaning of an image's numbers as light.

use serde::{Deserialize, Serialize};

use super::{Chromaticities, Decimal, Transfer, Xy};

/// The luminance of diffuse white in HDR, in cd/m2 (ITU-R BT.2408).
pub const GRAPHICS_WHITE: Decimal = Decimal::new(203.0);

/// Colorimetry of an image.
///
/// | transfer | a signal of 1 | `white_nits` |
/// |---|---|---|
/// | `Linear`, `Srgb`, `Gamma` | `white_nits` | the luminance of 1 |
/// | `Pq` | 10000 cd/m2 | the luminance of SDR white, whose signal is below 1 |
/// | `Hlg` | `peak_nits` | the luminance of SDR white on a display with that peak |
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Colorimetry {
    /// The primaries and the white of the RGB numbers.
    pub primaries: Chromaticities,
    /// The transfer function of the numbers.
    pub transfer: Transfer,
    /// The luminance of SDR white in cd/m2, which is 1 before a transfer function. `None` where no luminance is stated:
    /// then only ratios have a meaning.
    pub white_nits: Option<Decimal>,
    /// The highest luminance that the image can have, in cd/m2. `None` where there is no limit, as for scene light.
    pub peak_nits: Option<Decimal>,
    /// The chromaticity that appears white after a chromatic adaptation, if it is not the white of the primaries.
    pub adopted_white: Option<Xy>,
}

impl Colorimetry {
    /// Linear light without a stated luminance: scene light.
    pub const fn linear(primaries: Chromaticities) -> Self {
        Self::new(primaries, Transfer::Linear)
    }

    /// sRGB without a stated luminance.
    pub const SRGB: Self = Self::new(Chromaticities::REC709, Transfer::Srgb);

    /// Primaries and a transfer function, nothing else stated.
    pub const fn new(primaries: Chromaticities, transfer: Transfer) -> Self {
        Self { primaries, transfer, white_nits: None, peak_nits: None, adopted_white: None }
    }

    /// The same with luminances of SDR white and of the peak, in cd/m2.
    pub fn nits(self, white: f64, peak: f64) -> Self {
        Self { white_nits: Some(white.into()), peak_nits: Some(peak.into()), ..self }
    }

    /// Returns whether light above SDR white can be stored: `Pq` and `Hlg`.
    pub fn is_hdr(&self) -> bool {
        matches!(self.transfer, Transfer::Pq | Transfer::Hlg)
    }
}
