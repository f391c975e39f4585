//! Transfer functions as steps of a process, in both directions.

use afterimage_graph::color::{Colorimetry, Transfer};

use super::{Hlg, LIMIT, Logarithm, Power, Step};

/// A transfer function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Encoding {
    /// None.
    Linear,
    Log(Logarithm),
    /// Encodes, and decodes. Both for 0 to 1.
    Display([Power; 2]),
    /// The perceptual quantizer, with the luminance of a linear value of 1 in cd/m2.
    Pq(f64),
    /// Hybrid log-gamma.
    Hlg(Hlg),
}

impl Encoding {
    /// sRGB (IEC 61966-2-1).
    pub fn srgb() -> Self {
        let plain = Power::plain(1.0, 12.92);
        Self::Display([
            Power { end: 0.0031308, exponent: 1.0 / 2.4, scale: 1.055, shift: -0.055, ..plain },
            Power { slope: 1.0 / 12.92, end: 0.04045, a: 1.0 / 1.055, b: 0.055 / 1.055, exponent: 2.4, ..plain },
        ])
    }

    /// A power.
    pub fn gamma(gamma: f64) -> Self {
        Self::Display([gamma.recip(), gamma].map(|exponent| Power::plain(exponent, 0.0)))
    }

    /// The encoding of an image. A linear value of 1 has the luminance `white_nits` where the image states none.
    pub fn of(image: &Colorimetry, white_nits: f64) -> Self {
        let white = image.white_nits.map_or(white_nits, |white| white.get());
        match image.transfer {
            Transfer::Linear => Self::Linear,
            Transfer::Srgb => Self::srgb(),
            Transfer::Gamma(gamma) => Self::gamma(gamma.get()),
            Transfer::Pq => Self::Pq(white),
            Transfer::Hlg => Self::Hlg(Hlg { white, peak: image.peak_nits.map_or(5.0 * white, |peak| peak.get()) }),
        }
    }

    /// Light to numbers.
    pub fn encode(self) -> Vec<Step> {
        match self {
            Self::Linear => Vec::new(),
            Self::Log(curve) => vec![Step::Logarithm([curve; 3])],
            Self::Display([encode, _]) => vec![Step::limits(0.0, 1.0), Step::Power([encode; 3])],
            Self::Pq(white) => vec![Step::limits(0.0, LIMIT), Step::PqEncode(white)],
            Self::Hlg(hlg) => vec![Step::HlgEncode(hlg)],
        }
    }

    /// Decodes to linear values.
    pub fn decode(self) -> Vec<Step> {
        match self {
            Self::Linear => Vec::new(),
            Self::Log(curve) => vec![Step::Antilog([curve.inverse(); 3])],
            Self::Display([_, decode]) => vec![Step::limits(0.0, 1.0), Step::Power([decode; 3])],
            Self::Pq(white) => vec![Step::limits(0.0, 1.0), Step::PqDecode(white)],
            Self::Hlg(hlg) => vec![Step::HlgDecode(hlg)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process::Process;

    /// The linear value of gray at a signal, in units of 203 cd/m2, which is graphics white.
    fn light(encoding: Encoding, signal: f64) -> f64 {
        Process::new(encoding.decode()).apply([signal; 3])[1]
    }

    #[test]
    fn graphics_white_has_the_signals_of_bt_2408() {
        // 58 % PQ and 75 % HLG on a display of 1000 cd/m2, both rounded to a percent.
        let hlg = Encoding::Hlg(Hlg { white: 203.0, peak: 1000.0 });
        assert!((light(hlg, 0.75) - 1.0).abs() < 0.01, "{}", light(hlg, 0.75));
        assert!((light(Encoding::Pq(203.0), 0.58) - 1.0).abs() < 0.02, "{}", light(Encoding::Pq(203.0), 0.58));
        assert!((light(hlg, 1.0) - 1000.0 / 203.0).abs() < 1e-6);
    }

    #[test]
    fn encodings_are_inverted_by_their_decodings() {
        let hlg = Encoding::Hlg(Hlg { white: 203.0, peak: 1000.0 });
        for encoding in [Encoding::srgb(), Encoding::gamma(2.4), Encoding::Pq(203.0), hlg] {
            let there_and_back = Process::new(encoding.encode().into_iter().chain(encoding.decode()));
            let color = [0.9, 0.18, 0.001];
            let found = there_and_back.apply(color);
            let error = (0..3).map(|channel| (found[channel] - color[channel]).abs()).fold(0.0, f64::max);
            assert!(error < 1e-6, "{encoding:?}: {found:?}");
        }
    }
}
