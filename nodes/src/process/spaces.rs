//! The colour spaces that tables are made for.

use afterimage_graph::color::{Chromaticities, Transfer};
use afterimage_graph::prelude::*;

use super::{LIMIT, Logarithm, Power, Step};
use crate::color::ARRI_WIDE_GAMUT_3;

choices! {
    /// The colour space of a table's numbers: primaries, and the function between light and numbers. 1 is the light 1 of
    /// the image.
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
        /// sRGB.
        Srgb,
        /// Display P3: the function of sRGB, the primaries of P3 with D65.
        DisplayP3,
        /// A power of 2.2, Rec.709.
        Gamma22,
        /// A power of 2.4, Rec.709 (ITU-R BT.1886 with a black of 0).
        Gamma24,
        /// The perceptual quantiser, Rec.2020 (ITU-R BT.2100). Light of 1 has the luminance `white_nits`.
        Pq,
    }
}

/// The function from light to numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Encoding {
    Linear,
    Log(Logarithm),
    /// From light to numbers, and back. Both for 0 to 1.
    Display([Power; 2]),
    Pq,
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

    fn encoding(self) -> Encoding {
        match self {
            Self::Same | Self::LinearRec709 | Self::LinearRec2020 | Self::Aces | Self::AcesCg => Encoding::Linear,
            Self::AcesCct => Encoding::Log(aces_cct()),
            Self::LogC3 => Encoding::Log(log_c3()),
            Self::Srgb | Self::DisplayP3 => Encoding::Display(srgb()),
            Self::Gamma22 => Encoding::Display([2.2_f64.recip(), 2.2].map(|exponent| Power::plain(exponent, 0.0))),
            Self::Gamma24 => Encoding::Display([2.4_f64.recip(), 2.4].map(|exponent| Power::plain(exponent, 0.0))),
            Self::Pq => Encoding::Pq,
        }
    }

    /// Whether an image for a display or a file can be in this space.
    pub(crate) fn is_for_displays(self) -> bool {
        !matches!(self, Self::Same | Self::Aces | Self::AcesCg | Self::AcesCct | Self::LogC3)
    }

    /// Linear light with these primaries to this space.
    pub(crate) fn from_light(self, light: Chromaticities, white_nits: f64) -> Vec<Step> {
        let primaries = Step::matrix(light.conversion(&self.primaries()));
        std::iter::once(primaries).chain(self.encode(white_nits)).collect()
    }

    /// Linear light in the primaries of this space to its numbers.
    pub(crate) fn encode(self, white_nits: f64) -> Vec<Step> {
        match self.encoding() {
            Encoding::Linear => Vec::new(),
            Encoding::Log(curve) => vec![Step::Logarithm([curve; 3])],
            Encoding::Display([encode, _]) => vec![Step::limits(0.0, 1.0), Step::Power([encode; 3])],
            Encoding::Pq => vec![Step::limits(0.0, LIMIT), Step::PqEncode(white_nits)],
        }
    }

    /// This space to linear light with these primaries.
    pub(crate) fn to_light(self, light: Chromaticities, white_nits: f64) -> Vec<Step> {
        let mut steps = match self.encoding() {
            Encoding::Linear => Vec::new(),
            Encoding::Log(curve) => vec![Step::Antilog([curve.inverse(); 3])],
            Encoding::Display([_, decode]) => vec![Step::limits(0.0, 1.0), Step::Power([decode; 3])],
            Encoding::Pq => vec![Step::limits(0.0, 1.0), Step::PqDecode(white_nits)],
        };
        steps.push(Step::matrix(self.primaries().conversion(&light)));
        steps
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

/// sRGB (IEC 61966-2-1): from light to numbers, and back.
fn srgb() -> [Power; 2] {
    let plain = Power::plain(1.0, 12.92);
    [
        Power { end: 0.0031308, exponent: 1.0 / 2.4, scale: 1.055, shift: -0.055, ..plain },
        Power { slope: 1.0 / 12.92, end: 0.04045, a: 1.0 / 1.055, b: 0.055 / 1.055, exponent: 2.4, ..plain },
    ]
}

/// Luminance in cd/m2, limited to 0 to 10000, to the perceptual quantiser.
pub(super) fn pq_encode(nits: f64) -> f64 {
    Transfer::Pq.to_signal(nits / 10000.0)
}

/// The perceptual quantiser, limited to 0 to 1, to luminance in cd/m2.
pub(super) fn pq_decode(signal: f64) -> f64 {
    10000.0 * Transfer::Pq.to_light(signal)
}
