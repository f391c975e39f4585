//! A Gaussian that is made at a lower resolution.

use afterimage_graph::prelude::*;

use crate::downsample;
use crate::gaussian::Blur;

/// Records the blur of an image that is halved so many times, to be enlarged by a tent of radius 1 if it is smaller
/// than the source. The blur is as much narrower as halvings and the enlargement widen it, and ends at `reach` standard
/// deviations.
pub(crate) fn record(pass: &mut Recorder<'_>, source: ImageId, halvings: u32, sigma: f32, reach: f32) -> ImageId {
    let whole = pass.desc(source).size;
    let (mut image, mut desc) = (source, ImageDesc::new(whole));
    for _ in 0..halvings {
        if desc.size.levels() == 0 {
            break;
        }
        desc = desc.half();
        let half = pass.transient(format_args!("half {}", desc.size), desc);
        downsample::halve(pass, image, half);
        image = half;
    }
    let (across, blurred) = (pass.transient("across", desc), pass.transient("blurred", desc));
    let blur = |side, whole| Blur::of_variance(variance(sigma, side, whole), reach);
    blur(desc.size.width, whole.width).along(pass, [1, 0], image, across);
    blur(desc.size.height, whole.height).along(pass, [0, 1], across, blurred);
    blurred
}

/// The variance of the blur of a side that is scaled by halvings, in its texels, for a blur of `sigma` pixels. A
/// halving by `Tap13` has the variance 7/4 in texels of its source, so all of them together have 7/12 (1 - scale^2) in
/// texels of the result. The tent that enlarges has 2/3 + scale^2 / 12 at the pixels.
fn variance(sigma: f32, side: u32, whole: u32) -> f64 {
    let scale = f64::from(side) / f64::from(whole);
    let filters = if side == whole { 0.0 } else { 1.25 - 0.5 * scale * scale };
    ((f64::from(sigma) * scale).powi(2) - filters).max(0.0)
}
