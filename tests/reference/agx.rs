//! AgX (T. Sobotka), with the exact sigmoid and the polynomial fits in use.

use super::color::luminance;
use super::math::{Matrix, Rgb, inverse, transform};

/// Linear Rec.709 into the space of the curve.
pub(crate) const INSET: Matrix = [
    [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
    [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
    [0.0423756549057051, 0.0784336, 0.879142973793104],
];

/// Linear Rec.2020 into the space of the curve: the variant of Filament and three.js.
pub(crate) const INSET_2020: Matrix = [
    [0.856627153315983, 0.0951212405381588, 0.0482516061458583],
    [0.137318972929847, 0.761241990602591, 0.101439036467562],
    [0.11189821299995, 0.0767994186031903, 0.811302368396859],
];

/// The way back of [`INSET_2020`]; it is no inverse, but a rotated and widened set of primaries.
pub(crate) const OUTSET_2020: Matrix = [
    [1.1271005818144368, -0.11060664309660323, -0.016493938717834573],
    [-0.1413297634984383, 1.157823702216272, -0.016493938717834257],
    [-0.14132976349843826, -0.11060664309660294, 1.2519364065950405],
];

/// The darkest input, in log2: ten stops below middle gray.
pub(crate) fn darkest() -> f64 {
    0.18_f64.log2() - 10.0
}

/// The brightest input, in log2: six and a half stops above middle gray.
pub(crate) fn brightest() -> f64 {
    0.18_f64.log2() + 6.5
}

/// A grade inside AgX: slope, power and saturation of an ASC CDL.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Look {
    pub(crate) slope: Rgb,
    pub(crate) power: f64,
    pub(crate) saturation: f64,
}

pub(crate) const BASE: Look = Look { slope: [1.0; 3], power: 1.0, saturation: 1.0 };

pub(crate) const PUNCHY: Look = Look { slope: [1.0; 3], power: 1.35, saturation: 1.4 };

pub(crate) const GOLDEN: Look = Look { slope: [1.0, 0.9, 0.5], power: 0.8, saturation: 0.8 };

/// The sigmoid of the reference configuration, on log2 normalized to [0, 1].
pub(crate) fn sigmoid(t: f64) -> f64 {
    let (x0, y0, slope) = (10.0 / 16.5, 0.5, 2.0);
    let hyperbola = |u: f64, p: f64| u / (1.0 + u.powf(p)).powf(1.0 / p);
    let scale = |run: f64, rise: f64, p: f64| {
        let full: f64 = slope * run;
        (full.powf(-p) * ((full / rise).powf(p) - 1.0)).powf(-1.0 / p)
    };
    if t < x0 {
        let k = scale(x0, y0, 3.0);
        y0 - k * hyperbola(slope * (x0 - t) / k, 3.0)
    } else {
        let k = scale(1.0 - x0, 1.0 - y0, 3.25);
        y0 + k * hyperbola(slope * (t - x0) / k, 3.25)
    }
}

/// The sixth-degree fit that is printed most often (B. Wrensch); misses 0 and 1 a little.
pub(crate) fn polynomial6(t: f64) -> f64 {
    horner(&[15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232], t)
}

/// The seventh-degree fit that is printed most often; worse than the sixth.
pub(crate) fn polynomial7(t: f64) -> f64 {
    horner(&[-17.86, 78.01, -126.7, 92.06, -28.72, 4.361, -0.1718, 0.002857], t)
}

/// The sixth-degree fit of the formula book, 9.8, which meets 0 and 1.
pub(crate) fn polynomial6_constrained(t: f64) -> f64 {
    let coefficients = [15.1220424, -38.901444, 30.3767436, -5.92929872, 0.207851246, 0.124105529, 0.0];
    horner(&coefficients, t)
}

/// A polynomial, highest power first.
fn horner(coefficients: &[f64], t: f64) -> f64 {
    coefficients.iter().fold(0.0, |sum, c| sum * t + c)
}

/// The display value, still encoded for a display of gamma 2.2.
pub(crate) fn encoded(rgb: Rgb, curve: impl Fn(f64) -> f64, look: &Look) -> Rgb {
    let (low, high) = (darkest(), brightest());
    let inside = transform(&INSET, rgb.map(|x| x.max(0.0)))
        .map(|v| curve(((v.max(1e-10).log2() - low) / (high - low)).clamp(0.0, 1.0)));
    let looked = apply_look(inside, look);
    transform(&inverse(&INSET), looked).map(|x| x.clamp(0.0, 1.0))
}

/// The display-linear value: [`encoded`] to the power of 2.2.
pub(crate) fn linear(rgb: Rgb, curve: impl Fn(f64) -> f64, look: &Look) -> Rgb {
    encoded(rgb, curve, look).map(|x| x.powf(2.2))
}

/// AgX for an HDR display with a peak of `peak` times SDR white: Rec.2020 in and out. The curve is that of Godot 4.6
/// (A. Pestaluky 2025) with a contrast of 1.25 and a white of 16.29 times the peak.
pub(crate) fn hdr(rgb: Rgb, peak: f64) -> Rgb {
    let (crossover, contrast): (f64, f64) = (0.18, 1.25);
    let toe_a = (1.0 / crossover - 1.0) * crossover.powf(contrast);
    let denominator = crossover.powf(contrast) + toe_a;
    let slope = contrast * crossover.powf(contrast - 1.0) * toe_a / (denominator * denominator);
    let shoulder_max = peak - crossover;
    let w = (16.29 * peak - crossover).powi(2) / shoulder_max * slope;
    let curve = |x: f64| {
        if x < crossover {
            return x.powf(contrast) / (x.powf(contrast) + toe_a);
        }
        let s = x - crossover;
        (crossover + slope * s * (1.0 + s / w) / (1.0 + slope * s / shoulder_max)).min(peak)
    };
    transform(&OUTSET_2020, transform(&INSET_2020, rgb).map(|x| curve(x.max(0.0))))
}

fn apply_look(rgb: Rgb, look: &Look) -> Rgb {
    let powered = [0, 1, 2].map(|i| (rgb[i] * look.slope[i]).max(0.0).powf(look.power));
    let y = luminance(powered);
    powered.map(|x| y + look.saturation * (x - y))
}

#[test]
fn the_fits_stay_as_close_to_the_sigmoid_as_the_formula_book_says() {
    let worst = |fit: fn(f64) -> f64| {
        let error = |i: i32| {
            let t = f64::from(i) / 4096.0;
            (fit(t) - sigmoid(t)).abs()
        };
        (0..=4096).map(error).fold(0.0, f64::max)
    };
    assert!((worst(polynomial6) - 0.00577).abs() < 1e-4, "{}", worst(polynomial6));
    assert!((worst(polynomial7) - 0.0179).abs() < 1e-4, "{}", worst(polynomial7));
    let constrained = worst(polynomial6_constrained);
    assert!((constrained - 0.0033).abs() < 1e-4, "{constrained}");
}

#[test]
fn a_rec2020_white_comes_back_white() {
    for matrix in [INSET_2020, OUTSET_2020] {
        for x in transform(&matrix, [1.0; 3]) {
            assert!((x - 1.0).abs() < 1e-3, "{x}");
        }
    }
}
