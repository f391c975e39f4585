//! What every host image is sanitized to: no value is NaN or infinite, and only scene light has negative components.

use super::color::luminance;
use super::math::Rgb;

/// The largest finite half float: the bound of images in `rgba16float`.
pub(crate) const LARGEST_HALF: f64 = 65504.0;

/// NaN and everything below zero become 0; everything above `largest` becomes `largest`
/// (formula book, 1.7).
pub(crate) fn sanitize(x: f64, largest: f64) -> f64 {
    if x.is_nan() { 0.0 } else { x.clamp(0.0, largest) }
}

/// [`sanitize`] on each channel with the bound of a half float.
pub(crate) fn sanitize_rgb(rgb: Rgb) -> Rgb {
    rgb.map(|x| sanitize(x, LARGEST_HALF))
}

/// Scene light as nodes read it: NaN and negative infinity become 0, the rest is limited to the largest half float.
/// Negative components stay, scaled so that the luminance is at least 0. Negative alpha becomes 0.
pub(crate) fn sanitize_scene([r, g, b, a]: [f64; 4]) -> [f64; 4] {
    let bounded =
        |x: f64| if x.is_nan() || x == f64::NEG_INFINITY { 0.0 } else { x.clamp(-LARGEST_HALF, LARGEST_HALF) };
    let [r, g, b] = extended([r, g, b].map(bounded));
    [r, g, b, sanitize(a, LARGEST_HALF)]
}

/// Light whose negative components are as small as it takes for a luminance of 0 or more.
pub(crate) fn extended(rgb: Rgb) -> Rgb {
    let (light, missing) = (luminance(rgb.map(|x| x.max(0.0))), luminance(rgb.map(|x| (-x).max(0.0))));
    let share = if missing > light { light / missing } else { 1.0 };
    rgb.map(|x| if x < 0.0 { share * x } else { x })
}

#[test]
fn scene_light_keeps_negative_components_but_no_negative_luminance() {
    assert_eq!(sanitize_scene([-0.5, 1.0, -0.1, -1.0]), [-0.5, 1.0, -0.1, 0.0]);
    assert_eq!(sanitize_scene([f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.0]), [0.0, LARGEST_HALF, 0.0, 1.0]);
    assert_eq!(sanitize_scene([-1.0, -2.0, -3.0, 1.0]), [-0.0, -0.0, -0.0, 1.0]);
    let [r, g, b, _] = sanitize_scene([1.0, -7.0, 2.0, 1.0]);
    assert!((r, b) == (1.0, 2.0) && g < 0.0 && luminance([r, g, b]).abs() < 1e-15, "{g}");
}
