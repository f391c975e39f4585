//! The guard at the entry of every graph: after it, no value is NaN, infinite or negative.

use super::math::Rgb;

/// The largest finite half float: the bound of images in `rgba16float`.
pub(crate) const LARGEST_HALF: f64 = 65504.0;

/// NaN and everything below zero become 0; everything above `largest` becomes `largest`
/// (formula book, 1.7).
pub(crate) fn guard(x: f64, largest: f64) -> f64 {
    if x.is_nan() { 0.0 } else { x.clamp(0.0, largest) }
}

/// [`guard`] on each channel with the bound of a half float.
pub(crate) fn guard_rgb(rgb: Rgb) -> Rgb {
    rgb.map(|x| guard(x, LARGEST_HALF))
}
