//! What every host image is sanitized to: no value is NaN, infinite or negative.

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
