//! Lift-gamma-gain, the ASC CDL, and simple operators on encoded values (formula book, 7).

use super::color::luminance;
use super::math::{Rgb, zip};

/// The three controls of a lift-gamma-gain grade.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LiftGammaGain {
    pub(crate) lift: Rgb,
    pub(crate) gamma: Rgb,
    pub(crate) gain: Rgb,
}

impl LiftGammaGain {
    /// Gain, then lift that fades with luminance, then gamma.
    pub(crate) fn apply(&self, rgb: Rgb) -> Rgb {
        let gained = zip(rgb, self.gain, |x, gain| x * gain);
        let shade = (1.0 - luminance(gained)).clamp(0.0, 1.0);
        self.power(zip(gained, self.lift, |x, lift| x + lift * shade))
    }

    /// The same with a lift that fades with each channel instead.
    pub(crate) fn apply_per_channel(&self, rgb: Rgb) -> Rgb {
        let lifted = zip(rgb, self.lift, |x, lift| x + lift * (1.0 - x.min(1.0)));
        self.power(zip(lifted, self.gain, |x, gain| x * gain))
    }

    fn power(&self, rgb: Rgb) -> Rgb {
        zip(rgb, self.gamma, gamma)
    }
}

/// The controls of the ASC Color Decision List.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cdl {
    pub(crate) slope: Rgb,
    pub(crate) offset: Rgb,
    pub(crate) power: Rgb,
    pub(crate) saturation: f64,
}

impl Cdl {
    /// Slope, offset, power of what is positive, then saturation.
    pub(crate) fn apply(&self, rgb: Rgb) -> Rgb {
        let scaled = zip(rgb, self.slope, |x, slope| x * slope);
        let moved = zip(scaled, self.offset, |x, offset| x + offset);
        let powered = zip(moved, self.power, |x, power| if x > 0.0 { x.powf(power) } else { x });
        saturation(powered, self.saturation)
    }
}

/// Moves away from gray of the same luminance: 0 is gray, 1 changes nothing.
pub(crate) fn saturation(rgb: Rgb, amount: f64) -> Rgb {
    let y = luminance(rgb);
    rgb.map(|x| y + amount * (x - y))
}

pub(crate) fn brightness(x: f64, amount: f64) -> f64 {
    x + amount
}

/// Scales the distance from `pivot`.
pub(crate) fn contrast(x: f64, amount: f64, pivot: f64) -> f64 {
    (x - pivot) * amount + pivot
}

/// Contrast about `pivot` in stops, for scene-linear values.
pub(crate) fn contrast_log(x: f64, amount: f64, pivot: f64) -> f64 {
    pivot * (x.max(0.0) / pivot).powf(amount)
}

/// `x^(1/gamma)`; negative x gives 0, and gamma is never below 1e-3.
pub(crate) fn gamma(x: f64, gamma: f64) -> f64 {
    x.max(0.0).powf(1.0 / gamma.max(1e-3))
}

pub(crate) fn balance(rgb: Rgb, amounts: Rgb) -> Rgb {
    zip(rgb, amounts, |x, amount| x * amount)
}

#[test]
fn lift_per_channel_moves_black_and_keeps_white() {
    let grade = LiftGammaGain { lift: [0.1, 0.2, 0.0], gamma: [1.0; 3], gain: [2.0, 1.0, 0.5] };
    assert_eq!(grade.apply_per_channel([0.0; 3]), [0.2, 0.2, 0.0]);
    assert_eq!(grade.apply_per_channel([1.0; 3]), [2.0, 1.0, 0.5]);
    assert_eq!(grade.apply_per_channel([4.0; 3]), [8.0, 4.0, 2.0]);
}
