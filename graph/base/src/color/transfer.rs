//! Transfer functions in f64.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::Decimal;

/// The function between linear light and the numbers of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Transfer {
    /// None: the numbers are linear light.
    Linear,
    /// sRGB (IEC 61966-2-1). 1 is white.
    Srgb,
    /// A power: light is the signal to the power of the exponent, such as 2.2. 1 is white.
    Gamma(Decimal),
    /// Perceptual quantizer (SMPTE ST 2084). A signal of 1 is 10000 cd/m2.
    Pq,
    /// Hybrid log-gamma (ITU-R BT.2100). A signal of 1 is the peak of the display.
    Hlg,
}

/// Its name as reports have it: `Srgb`, `Gamma 2.2`.
impl fmt::Display for Transfer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Linear => f.write_str("Linear"),
            Self::Srgb => f.write_str("Srgb"),
            Self::Gamma(exponent) => write!(f, "Gamma {exponent}"),
            Self::Pq => f.write_str("Pq"),
            Self::Hlg => f.write_str("Hlg"),
        }
    }
}

/// Constants of SMPTE ST 2084.
const M1: f64 = 2610.0 / 16384.0;
const M2: f64 = 2523.0 / 32.0;
const C1: f64 = 3424.0 / 4096.0;
const C2: f64 = 2413.0 / 128.0;
const C3: f64 = 2392.0 / 128.0;

/// Constants of ITU-R BT.2100, table 5.
const A: f64 = 0.17883277;
const B: f64 = 1.0 - 4.0 * A;
const C: f64 = 0.559_910_729_529_562;

impl Transfer {
    /// Light of a signal from 0 to 1, which is limited to that. The unit of the light: 1 is white for `Linear`, `Srgb`
    /// and `Gamma`; 10000 cd/m2 for `Pq`; and for `Hlg` it is scene light from 0 to 1, before the system gamma of the
    /// display. `Linear` limits nothing.
    pub fn to_light(self, signal: f64) -> f64 {
        if self == Self::Linear { signal } else { self.curve(signal.clamp(0.0, 1.0)) }
    }

    /// Light of any signal, as floats have it. The curves of `Srgb` and `Gamma` go on above 1; all are mirrored at 0.
    pub fn extended_to_light(self, signal: f64) -> f64 {
        let size = signal.abs();
        let size = if matches!(self, Self::Pq | Self::Hlg) { size.clamp(0.0, 1.0) } else { size };
        self.curve(size).copysign(signal)
    }

    fn curve(self, signal: f64) -> f64 {
        match self {
            Self::Linear => signal,
            Self::Srgb if signal <= 0.04045 => signal / 12.92,
            Self::Srgb => ((signal + 0.055) / 1.055).powf(2.4),
            Self::Gamma(exponent) => signal.powf(exponent.get()),
            Self::Pq => pq_to_light(signal),
            Self::Hlg if signal <= 0.5 => signal * signal / 3.0,
            Self::Hlg => (((signal - C) / A).exp() + B) / 12.0,
        }
    }

    /// The signal of light, in the units of [`to_light`](Self::to_light). Light is limited to 0 to 1, except for
    /// `Linear`.
    pub fn to_signal(self, light: f64) -> f64 {
        let bounded = light.clamp(0.0, 1.0);
        match self {
            Self::Linear => light,
            Self::Srgb if bounded <= 0.0031308 => bounded * 12.92,
            Self::Srgb => 1.055 * bounded.powf(1.0 / 2.4) - 0.055,
            Self::Gamma(exponent) => bounded.powf(1.0 / exponent.get()),
            Self::Pq => pq_to_signal(bounded),
            Self::Hlg if bounded <= 1.0 / 12.0 => (3.0 * bounded).sqrt(),
            Self::Hlg => A * (12.0 * bounded - B).ln() + C,
        }
    }
}

fn pq_to_light(signal: f64) -> f64 {
    let power = signal.powf(1.0 / M2);
    ((power - C1).max(0.0) / (C2 - C3 * power)).powf(1.0 / M1)
}

fn pq_to_signal(light: f64) -> f64 {
    let power = light.powf(M1);
    ((C1 + C2 * power) / (1.0 + C3 * power)).powf(M2)
}

/// The system gamma of an HLG display with that peak in cd/m2 (ITU-R BT.2100; BT.2390 outside of 400 to 2000 cd/m2).
pub fn hlg_gamma(peak_nits: f64) -> f64 {
    if (400.0..=2000.0).contains(&peak_nits) {
        1.2 + 0.42 * (peak_nits / 1000.0).log10()
    } else {
        1.2 * 1.111_f64.powf((peak_nits / 1000.0).log2())
    }
}
