//! Sanitized host images: no value is NaN or infinite, and only scene light has negative components.

use super::color::luminance;
use super::image::Image;
use super::math::Rgb;

/// The largest finite half float: the bound of images in `rgba16float`.
pub(crate) const MAX_HALF: f64 = 65504.0;

/// NaN and everything below zero become 0; everything above `largest` becomes `largest`
/// (formula book, 1.7).
pub(crate) fn sanitize(x: f64, largest: f64) -> f64 {
    if x.is_nan() { 0.0 } else { x.clamp(0.0, largest) }
}

/// [`sanitize`] on each channel with the bound of a half float.
pub(crate) fn sanitize_rgb(rgb: Rgb) -> Rgb {
    rgb.map(|x| sanitize(x, MAX_HALF))
}

/// The image of scene light as nodes read it. NaN, negative infinity, and an infinity that no neighbor of the pixel
/// shares become the least of four numbers of the same channel: of each pair of opposite neighbors the larger finite
/// one; then [`sanitize_scene`].
pub(crate) fn sanitized(image: &Image) -> Image {
    Image::new(image.width, image.height, |x, y| {
        sanitize_scene([0, 1, 2, 3].map(|channel| repaired(image, x as i64, y as i64, channel)))
    })
}

/// A pixel of scene light: NaN and negative infinity become 0, the rest is limited to the largest half float. Negative
/// components stay, scaled so that the luminance is at least 0. Negative alpha becomes 0.
pub(crate) fn sanitize_scene([r, g, b, a]: [f64; 4]) -> [f64; 4] {
    let bounded = |x: f64| if x.is_nan() || x == f64::NEG_INFINITY { 0.0 } else { x.clamp(-MAX_HALF, MAX_HALF) };
    let [r, g, b] = extended([r, g, b].map(bounded));
    [r, g, b, sanitize(a, MAX_HALF)]
}

/// Light whose negative components are as small as it takes for a luminance of 0 or more.
pub(crate) fn extended(rgb: Rgb) -> Rgb {
    let (light, missing) = (luminance(rgb.map(|x| x.max(0.0))), luminance(rgb.map(|x| (-x).max(0.0))));
    let share = if missing > light { light / missing } else { 1.0 };
    rgb.map(|x| if x < 0.0 { share * x } else { x })
}

fn repaired(image: &Image, x: i64, y: i64, channel: usize) -> f64 {
    let value = image.texel(x, y)[channel];
    let at = |x: i64, y: i64| {
        let is_inside = (0..image.width as i64).contains(&x) && (0..image.height as i64).contains(&y);
        if is_inside { image.texel(x, y)[channel] } else { f64::NAN }
    };
    let pairs = [(1, 0), (-1, 1), (0, 1), (1, 1)].map(|(dx, dy)| [at(x + dx, y + dy), at(x - dx, y - dy)]);
    let is_light = value == f64::INFINITY && pairs.as_flattened().contains(&f64::INFINITY);
    if value.is_finite() || is_light {
        return value;
    }
    let larger = |pair: [f64; 2]| pair.into_iter().filter(|x| x.is_finite()).reduce(f64::max);
    let least = pairs.into_iter().filter_map(larger).reduce(f64::min);
    least.map_or(value, |x| x.clamp(-MAX_HALF, MAX_HALF))
}

#[test]
fn scene_light_keeps_negative_components_but_no_negative_luminance() {
    assert_eq!(sanitize_scene([-0.5, 1.0, -0.1, -1.0]), [-0.5, 1.0, -0.1, 0.0]);
    assert_eq!(sanitize_scene([f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.0]), [0.0, MAX_HALF, 0.0, 1.0]);
    assert_eq!(sanitize_scene([-1.0, -2.0, -3.0, 1.0]), [-0.0, -0.0, -0.0, 1.0]);
    let [r, g, b, _] = sanitize_scene([1.0, -7.0, 2.0, 1.0]);
    assert!((r, b) == (1.0, 2.0) && g < 0.0 && luminance([r, g, b]).abs() < 1e-15, "{g}");
}

#[test]
fn only_isolated_infinities_are_repaired() {
    let image = Image::new(5, 3, |x, y| match (x, y) {
        (0, 0) => [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.0],
        (3..=4, 1) => [f64::INFINITY, 7.0, -1.0, 1.0],
        _ => [1.0 + x as f64, 2.0, 3.0, 1.0],
    });
    let clean = sanitized(&image);
    // The three neighbors of the corner have 1, 2 and 2 in red, and none has an opposite one.
    assert_eq!(clean.texel(0, 0), [1.0, 2.0, 3.0, 1.0]);
    assert_eq!(clean.texel(3, 1), [MAX_HALF, 7.0, -1.0, 1.0]);
    let nothing = sanitized(&Image::new(2, 2, |_, _| [f64::NAN; 4]));
    assert_eq!(nothing.pixels, [[0.0; 4]; 4]);
}
