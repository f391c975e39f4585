//! The color spaces that tables are made for.

use afterimage_graph::color::{Chromaticities, Colorimetry, Transfer};
use afterimage_graph::prelude::*;

use super::encoding::Encoding;
use super::{Logarithm, Step};
use crate::adaptation::ARRI_WIDE_GAMUT_3;

choices! {
    /// The color space of a table's numbers: primaries, and the function between light and numbers. Light of 1 is that
    /// of the image.
    pub enum LutSpace {
        /// For `from`: that of the image, so that its numbers are not converted. For `to`: that of `from`.
        Same,
        /// Linear light, Rec.709.
        LinearRec709,
        /// Linear light, Rec.2020.
        LinearRec2020,
        /// ACES2065-1: linear light, AP0.
        Aces,
        /// ACEScg: linear light, AP1.
        AcesCg,
        /// ACEScct: a logarithm with a linear part near black, AP1.
        AcesCct,
        /// ARRI LogC3 at EI 800, ARRI Wide Gamut 3.
        LogC3,
        /// sRGB (IEC 61966-2-1).
        Srgb,
        /// Display P3: the function of sRGB, the primaries of P3 with D65.
        DisplayP3,
        /// A power of 2.2, Rec.709.
        Gamma22,
        /// A power of 2.4, Rec.709 (ITU-R BT.1886 with a black of 0).
        Gamma24,
        /// The perceptual quantizer, Rec.2020 (ITU-R BT.2100). Light of 1 has the luminance `white_nits`.
        Pq,
    }
}

impl LutSpace {
    fn primaries(self) -> Chromaticities {
        match self {
            Self::LinearRec2020 | Self::Pq => Chromaticities::REC2020,
            Self::Aces => Chromaticities::ACES_AP0,
            Self::AcesCg | Self::AcesCct => Chromaticities::ACES_CG,
            Self::LogC3 => ARRI_WIDE_GAMUT_3,
            Self::DisplayP3 => Chromaticities::DISPLAY_P3,
            Self::Same | Self::LinearRec709 | Self::Srgb | Self::Gamma22 | Self::Gamma24 => Chromaticities::REC709,
        }
    }

    fn encoding(self, white_nits: f64) -> Encoding {
        match self {
            Self::Same | Self::LinearRec709 | Self::LinearRec2020 | Self::Aces | Self::AcesCg => Encoding::Linear,
            Self::AcesCct => Encoding::Log(aces_cct()),
            Self::LogC3 => Encoding::Log(log_c3()),
            Self::Srgb | Self::DisplayP3 => Encoding::srgb(),
            Self::Gamma22 => Encoding::gamma(2.2),
            Self::Gamma24 => Encoding::gamma(2.4),
            Self::Pq => Encoding::Pq(white_nits),
        }
    }

    /// The colorimetry of an image in this space. `None` for logarithms.
    pub fn colorimetry(self, white_nits: f64) -> Option<Colorimetry> {
        let transfer = match self {
            Self::AcesCct | Self::LogC3 => return None,
            Self::Same | Self::LinearRec709 | Self::LinearRec2020 | Self::Aces | Self::AcesCg => Transfer::Linear,
            Self::Srgb | Self::DisplayP3 => Transfer::Srgb,
            Self::Gamma22 => Transfer::Gamma(2.2.into()),
            Self::Gamma24 => Transfer::Gamma(2.4.into()),
            Self::Pq => Transfer::Pq,
        };
        let white_nits = (self == Self::Pq).then_some(white_nits.into());
        Some(Colorimetry { white_nits, ..Colorimetry::new(self.primaries(), transfer) })
    }

    /// True if an image for a display or a file can be in this space.
    pub fn is_for_displays(self) -> bool {
        !matches!(self, Self::Same | Self::Aces | Self::AcesCg | Self::AcesCct | Self::LogC3)
    }

    /// Steps from linear color with these primaries to this space.
    pub fn numbers_of(self, light: Chromaticities, white_nits: f64) -> Vec<Step> {
        let primaries = Step::matrix(light.conversion(&self.primaries()));
        std::iter::once(primaries).chain(self.encode(white_nits)).collect()
    }

    /// Steps from linear color in the primaries of this space to its encoded values.
    pub fn encode(self, white_nits: f64) -> Vec<Step> {
        self.encoding(white_nits).encode()
    }

    /// Steps from this space to linear color with these primaries.
    pub fn to_light(self, light: Chromaticities, white_nits: f64) -> Vec<Step> {
        let primaries = Step::matrix(self.primaries().conversion(&light));
        self.encoding(white_nits).decode().into_iter().chain([primaries]).collect()
    }
}

/// ACEScct (Academy S-2016-001).
fn aces_cct() -> Logarithm {
    let (slope, offset) = (10.5402377416545, 0.0729055341958355);
    Logarithm { slope, offset, end: 0.0078125, a: 1.0, b: 0.0, scale: 1.0 / 17.52, shift: 9.72 / 17.52 }
}

/// ARRI LogC3 at EI 800 (ARRI, "ALEXA Log C Curve", 2012).
fn log_c3() -> Logarithm {
    let (cut, a, b, c, d, e, f) = (0.010591, 5.555556, 0.052272, 0.247190, 0.385537, 5.367655, 0.092809);
    Logarithm { slope: e, offset: f, end: cut, a, b, scale: c * 2.0_f64.log10(), shift: d }
}
