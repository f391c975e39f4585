//! The Purkinje shift: how colors look in the dark (formula book, 11).
//!
//! The full model follows Cao et al. (2008), Kirk and O'Brien (2011) and Patry (2021).

use super::color::luminance;
use super::math::{Matrix, Rgb, diagonal, dot, inverse, mix, product, smooth_step};
use super::sanitize::extended;

/// Linear Rec.709 to the responses of the L, M and S cones under D65.
pub(crate) const LMS_FROM_REC709: Matrix =
    [[7.696847, 18.424824, 2.068096], [2.431137, 18.697937, 3.012463], [0.289117, 1.401833, 13.792292]];

/// Linear Rec.709 to the response of the rods under D65.
pub(crate) const ROD_FROM_REC709: Rgb = [0.466386, 15.564362, 10.059963];

/// The largest sensitivities of the cones (Cao et al. 2008).
const SENSITIVITY: Rgb = [0.63721, 0.39242, 1.6064];

/// How strongly rods act on each cone's pathway (Cao et al. 2008).
const ROD_STRENGTH: Rgb = [0.2, 0.2, 0.3];

/// Cone responses to the three opponent channels: M − L, S − (L + M), L + M.
const OPPONENT: Matrix = [[-1.0, 1.0, 0.0], [-1.0, -1.0, 1.0], [1.0, 1.0, 0.0]];

/// The effect's strength for a scene illuminance in lux, a ramp in log10 from 0.01 to 10.
/// NaN gives 0.
pub(crate) fn strength_log(lux: f64) -> f64 {
    if lux.is_nan() || lux >= 10.0 {
        0.0
    } else if lux <= 0.01 {
        1.0
    } else {
        1.0 - smooth_step(0.0, 1.0, (lux.log10() + 2.0) / 3.0)
    }
}

/// The same with a ramp that is linear in lux.
pub(crate) fn strength_linear(lux: f64) -> f64 {
    if lux.is_nan() { 0.0 } else { 1.0 - smooth_step(0.01, 10.0, lux) }
}

/// The matrix C: the regulated rod signal per cone pathway, to a change of linear Rec.709.
pub(crate) fn rod_matrix() -> Matrix {
    let (k, s, k3, rw, p) = (45.0, 10.0, 0.6, 0.139, 0.6189);
    let to_opponent: Matrix =
        [[-(k3 + rw), 1.0 + k3 * rw, 0.0], [p * k3, (1.0 - p) * k3, 1.0], [p * s, (1.0 - p) * s, 0.0]]
            .map(|row| row.map(|x: f64| x * k / s));
    let strengths = [0, 1, 2].map(|i| ROD_STRENGTH[i] / SENSITIVITY[i]);
    let to_lms = product(&inverse(&OPPONENT), &product(&to_opponent, &diagonal(strengths)));
    product(&inverse(&LMS_FROM_REC709), &to_lms)
}

/// The full model: `scale` (380) brings exposed colors to the mesopic range of the model.
pub(crate) fn full(rgb: Rgb, strength: f64, scale: f64) -> Rgb {
    let light = rgb.map(|x| scale * x.max(0.0));
    let rod = dot(ROD_FROM_REC709, light);
    let regulated = [0, 1, 2].map(|i| {
        let drive = dot(LMS_FROM_REC709[i], light) + ROD_STRENGTH[i] * rod;
        1.0 / (1.0 + (0.33 / SENSITIVITY[i] * drive).max(0.0)).sqrt()
    });
    let c = rod_matrix();
    // No component becomes more negative than the light is.
    extended([0, 1, 2].map(|i| (rgb[i] + strength / scale * rod * dot(c[i], regulated)).max(rgb[i].min(0.0))))
}

/// The simple model for a scene illuminance in lux: gray, blue and brighter as light fades.
pub(crate) fn simple(rgb: Rgb, lux: f64) -> Rgb {
    let gray = 0.7 * (1.0 - smooth_step(0.01, 10.0, lux));
    let blue = 0.3 * (1.0 - smooth_step(0.01, 5.0, lux));
    let boost = 0.5 * (1.0 - smooth_step(0.001, 1.0, lux));
    let y = luminance(rgb);
    let [r, g, b] = rgb.map(|x| mix(x, y, gray));
    [mix(r, 0.9 * y, blue), g, mix(b, 1.2 * y, blue)].map(|x| x + boost * y)
}

#[test]
fn an_unknown_illuminance_changes_nothing() {
    assert_eq!(strength_log(f64::NAN), 0.0);
    assert_eq!(strength_linear(f64::NAN), 0.0);
    assert_eq!(full([0.3, 0.2, 0.1], 0.0, 380.0), [0.3, 0.2, 0.1]);
}
