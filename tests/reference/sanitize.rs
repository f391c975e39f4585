//! What every host image is sanitized to: no value is NaN, infinite or negative.

use super::image::Image;
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

/// The image as nodes read it. NaN, negative infinity, and an infinity that no neighbour of the pixel shares become the
/// lower median of the finite neighbours in the same channel; then [`sanitize`].
pub(crate) fn sanitized(image: &Image) -> Image {
    Image::new(image.width, image.height, |x, y| {
        [0, 1, 2, 3].map(|channel| repaired(image, x as i64, y as i64, channel))
    })
}

fn repaired(image: &Image, x: i64, y: i64, channel: usize) -> f64 {
    let value = image.texel(x, y)[channel];
    let near: Vec<f64> = neighbours(image, x, y).map(|pixel| pixel[channel]).collect();
    let is_light = value == f64::INFINITY && near.contains(&f64::INFINITY);
    let mut finite: Vec<f64> = near.iter().filter(|v| v.is_finite()).map(|v| sanitize(*v, LARGEST_HALF)).collect();
    finite.sort_by(f64::total_cmp);
    if value.is_finite() || is_light || finite.is_empty() {
        return sanitize(value, LARGEST_HALF);
    }
    finite[(finite.len() - 1) / 2]
}

fn neighbours(image: &Image, x: i64, y: i64) -> impl Iterator<Item = [f64; 4]> + '_ {
    let around = (-1..=1).flat_map(|j| (-1..=1).map(move |i| (i, j))).filter(|offset| *offset != (0, 0));
    let at = around.map(move |(i, j)| (x + i, y + j));
    let is_inside = |(x, y): &(i64, i64)| (0..image.width as i64).contains(x) && (0..image.height as i64).contains(y);
    at.filter(is_inside).map(|(x, y)| image.texel(x, y))
}

#[test]
fn only_isolated_infinities_are_repaired() {
    let image = Image::new(5, 3, |x, y| match (x, y) {
        (0, 0) => [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.0],
        (3..=4, 1) => [f64::INFINITY, 7.0, -1.0, 1.0],
        _ => [1.0 + x as f64, 2.0, 3.0, 1.0],
    });
    let clean = sanitized(&image);
    // The three neighbours of the corner have 1, 2 and 2 in red.
    assert_eq!(clean.texel(0, 0), [2.0, 2.0, 3.0, 1.0]);
    assert_eq!(clean.texel(3, 1), [LARGEST_HALF, 7.0, 0.0, 1.0]);
    let nothing = sanitized(&Image::new(2, 2, |_, _| [f64::NAN; 4]));
    assert_eq!(nothing.pixels, [[0.0; 4]; 4]);
}
