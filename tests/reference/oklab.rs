//! Oklab (Ottosson 2020): hue, and the gamut step of `ToneMap`.

use super::curves::soft_floor;
use super::math::{Matrix, Rgb, inverse, largest, transform};

/// Linear Rec.709 to cone responses, as published.
const LMS: Matrix = [
    [0.4122214708, 0.5363325363, 0.0514459929],
    [0.2119034982, 0.6806995451, 0.1073969566],
    [0.0883024619, 0.2817188376, 0.6299787005],
];

/// Cube roots of cone responses to L, a and b, as published.
const LAB: Matrix = [
    [0.2104542553, 0.7936177850, -0.0040720468],
    [1.9779984951, -2.4285922050, 0.4505937099],
    [0.0259040371, 0.7827717662, -0.8086757660],
];

/// Linear Rec.709 to L, a, b.
pub(crate) fn oklab(rgb: Rgb) -> Rgb {
    transform(&LAB, transform(&LMS, rgb).map(f64::cbrt))
}

/// L, a, b to linear Rec.709.
pub(crate) fn from_oklab(lab: Rgb) -> Rgb {
    transform(&inverse(&LMS), transform(&inverse(&LAB), lab).map(|x| x.powi(3)))
}

pub(crate) fn chroma(rgb: Rgb) -> f64 {
    let [_, a, b] = oklab(rgb);
    a.hypot(b)
}

/// The hue in degrees.
pub(crate) fn hue(rgb: Rgb) -> f64 {
    let [_, a, b] = oklab(rgb);
    b.atan2(a).to_degrees()
}

/// The angle between the hues of two colors, 0 to 180 degrees.
pub(crate) fn turn(a: Rgb, b: Rgb) -> f64 {
    let turn = (hue(a) - hue(b)).rem_euclid(360.0);
    turn.min(360.0 - turn)
}

/// The hue of a light in degrees: each cone response is at least about a sixth of their mean.
pub(crate) fn hue_of_light(light: Rgb) -> f64 {
    let lms = transform(&LMS, light);
    let mean = lms.map(|x| x.max(0.0)).iter().sum::<f64>() / 3.0;
    hue(transform(&inverse(&LMS), lms.map(|x| soft_floor(x, 0.17 * mean))))
}

/// A mapped color with the hue of the light that it was made of.
pub(crate) fn with_hue(mapped: Rgb, light: Rgb) -> Rgb {
    let [lightness, ..] = oklab(mapped);
    let (amount, angle) = (chroma(mapped), hue_of_light(light).to_radians());
    from_oklab([lightness, amount * angle.cos(), amount * angle.sin()])
}

/// The largest share of the chroma, because of red next to the blue of a gamut, of a color with this chroma in units of
/// its lightness. From where red, in units of the gray, falls by less than 1.2 for a chroma of the lightness on, it is
/// taken to fall by that.
fn dent_end(red: impl Fn(f64) -> f64, chroma: f64) -> f64 {
    let step = 1e-3 / chroma.max(1e-12);
    let falls = |at: f64| red(at + step) - red(at) < -1.2 * 1e-3;
    let shares = (0..4000).map(|number| f64::from(number) * step);
    let Some(bend) = falls(0.0).then(|| shares.into_iter().find(|at| !falls(*at))).flatten() else {
        return f64::INFINITY;
    };
    bend + (red(bend) + 0.01).max(0.0) / (1.2 * chroma)
}

/// A color in the gamut from 0 to `peak`: chroma above the share `knee` of the gamut's is compressed at one lightness and
/// hue. Of the share that is lost, the distance of the brightest channel from the peak is the share by which all channels
/// grow.
pub(crate) fn fitted(rgb: Rgb, peak: f64, knee: f64) -> Rgb {
    let [lightness, a, b] = oklab(rgb);
    let lightness = lightness.clamp(0.0, peak.cbrt());
    let scaled = |share: f64| from_oklab([lightness, a * share, b * share]);
    let limit = 1.0 / knee.max(1e-3);
    let gray = lightness.powi(3);
    let end = dent_end(|share| scaled(share)[0] / gray, a.hypot(b) / lightness);
    let is_inside = |share: f64| share <= end && scaled(share).iter().all(|x| (-0.01 * gray..=peak).contains(x));
    if is_inside(limit) {
        return scaled(1.0);
    }
    let (mut low, mut high) = (0.0, limit);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if is_inside(middle) { low = middle } else { high = middle }
    }
    let reach = 1.0 / low.max(1e-12);
    let over = reach - knee;
    let bent = if over > 0.0 { knee + over * (1.0 - knee) / (1.0 - knee + over) } else { reach };
    let fitted = scaled(bent / reach).map(|x| x.clamp(0.0, peak));
    let gain = 1.0 + (1.0 - bent / reach) * (peak - largest(fitted)) / peak;
    fitted.map(|x| x * gain)
}

#[test]
fn published_colors() {
    // Ottosson's table of XYZ examples, as linear Rec.709 red and the CSS Color 4 samples of sRGB.
    let red = oklab([1.0, 0.0, 0.0]);
    assert!(largest([red[0] - 0.62796, red[1] - 0.22486, red[2] - 0.12585].map(f64::abs)) < 1e-5, "{red:?}");
    assert!((hue([0.0, 0.0, 1.0]).rem_euclid(360.0) - 264.052).abs() < 0.01, "{}", hue([0.0, 0.0, 1.0]));
    assert!(chroma([0.5; 3]) < 1e-6);
}

#[test]
fn a_fitted_color_keeps_its_hue_and_becomes_no_darker() {
    for rgb in [[1.4, 0.2, -0.1], [0.1, -0.05, 0.9], [0.4, 0.9, -0.2]] {
        let to = fitted(rgb, 1.0, 0.8);
        assert!(turn(rgb, to) < 1e-3 && oklab(to)[0] > oklab(rgb)[0] - 1e-6, "{rgb:?} became {to:?}");
        assert!(chroma(to) < chroma(rgb), "{rgb:?} became {to:?}");
    }
}
