//! CIEDE2000: color difference of display pictures (ISO/CIE 11664-6).
//!
//! The steps and the lints are those of Sharma, Wu and Dalal, "The CIEDE2000 color-difference formula: implementation
//! notes, supplementary test data, and mathematical observations", Color Research and Application 30 (2005).

use rayon::prelude::*;

use super::color::lab_of_srgb;

/// 25⁷, from which on chroma counts as high.
const HIGH_CHROMA: f64 = 6_103_515_625.0;

/// The difference of two CIELAB colors; 1 is about just noticeable. All weights are 1.
pub fn ciede2000_of(first: [f64; 3], second: [f64; 3]) -> f64 {
    let mean_chroma = (chroma(first) + chroma(second)) / 2.0;
    let stretch = 1.5 - 0.5 * high(mean_chroma);
    let (first, second) = (Polar::new(first, stretch), Polar::new(second, stretch));
    let lightness = second.lightness - first.lightness;
    let chroma = second.chroma - first.chroma;
    let hue = 2.0 * (first.chroma * second.chroma).sqrt() * (hue_difference(&first, &second) / 2.0).sin();
    let means = Means::of(&first, &second);
    let (l, c, h) = (lightness / means.weight_l(), chroma / means.weight_c(), hue / means.weight_h());
    (l * l + c * c + h * h + means.rotation() * c * h).max(0.0).sqrt()
}

/// The difference of each pixel of two sRGB signals.
pub fn ciede2000(reference: &[[f32; 3]], other: &[[f32; 3]]) -> Vec<f32> {
    let one = |(a, b): (&[f32; 3], &[f32; 3])| match a == b {
        true => 0.0,
        false => ciede2000_of(lab_of_srgb(*a), lab_of_srgb(*b)) as f32,
    };
    reference.par_iter().zip(other).map(one).collect()
}

fn chroma([_, a, b]: [f64; 3]) -> f64 {
    a.hypot(b)
}

/// From 0 for grays to 1 for vivid colors.
fn high(chroma: f64) -> f64 {
    let power = chroma.powi(7);
    (power / (power + HIGH_CHROMA)).sqrt()
}

/// Lightness, chroma and hue in radians, 0 to 2 pi; the a axis is stretched near gray.
struct Polar {
    lightness: f64,
    chroma: f64,
    hue: f64,
}

impl Polar {
    fn new([lightness, a, b]: [f64; 3], stretch: f64) -> Self {
        let a = a * stretch;
        let hue = if a == 0.0 && b == 0.0 { 0.0 } else { b.atan2(a).rem_euclid(std::f64::consts::TAU) };
        Self { lightness, chroma: a.hypot(b), hue }
    }
}

fn is_gray(first: &Polar, second: &Polar) -> bool {
    first.chroma * second.chroma == 0.0
}

/// The shorter way round from one hue to the other; 0 where one of them has none.
fn hue_difference(first: &Polar, second: &Polar) -> f64 {
    use std::f64::consts::{PI, TAU};
    if is_gray(first, second) {
        return 0.0;
    }
    let difference = second.hue - first.hue;
    match difference {
        d if d > PI => d - TAU,
        d if d < -PI => d + TAU,
        d => d,
    }
}

/// The middle of the two hues on the shorter way round; where one has none, the other.
fn mean_hue(first: &Polar, second: &Polar) -> f64 {
    use std::f64::consts::{PI, TAU};
    let sum = first.hue + second.hue;
    if is_gray(first, second) {
        return sum;
    }
    match (first.hue - second.hue).abs() <= PI {
        true => sum / 2.0,
        false if sum < TAU => (sum + TAU) / 2.0,
        false => (sum - TAU) / 2.0,
    }
}

/// The color halfway between the two, on which the weights depend.
struct Means {
    lightness: f64,
    chroma: f64,
    /// In degrees.
    hue: f64,
}

impl Means {
    fn of(first: &Polar, second: &Polar) -> Self {
        Self {
            lightness: (first.lightness + second.lightness) / 2.0,
            chroma: (first.chroma + second.chroma) / 2.0,
            hue: mean_hue(first, second).to_degrees(),
        }
    }

    fn weight_l(&self) -> f64 {
        let square = (self.lightness - 50.0).powi(2);
        1.0 + 0.015 * square / (20.0 + square).sqrt()
    }

    fn weight_c(&self) -> f64 {
        1.0 + 0.045 * self.chroma
    }

    fn weight_h(&self) -> f64 {
        let cos = |degrees: f64| degrees.to_radians().cos();
        let t = 1.0 - 0.17 * cos(self.hue - 30.0) + 0.24 * cos(2.0 * self.hue) + 0.32 * cos(3.0 * self.hue + 6.0)
            - 0.20 * cos(4.0 * self.hue - 63.0);
        1.0 + 0.015 * self.chroma * t
    }

    /// The interplay of chroma and hue among blues.
    fn rotation(&self) -> f64 {
        let angle = 30.0 * (-((self.hue - 275.0) / 25.0).powi(2)).exp();
        -(2.0 * angle).to_radians().sin() * 2.0 * high(self.chroma)
    }
}
