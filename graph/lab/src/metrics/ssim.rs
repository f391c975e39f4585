//! SSIM: likeness of structure.

use super::Shown;
use super::plane::{Plane, gaussian};

/// The window of Wang et al.: a Gaussian of 1.5 pixels, eleven wide.
const DEVIATION: f64 = 1.5;
const RADIUS: usize = 5;

/// Mean SSIM of brightness; 1 for equal pictures.
///
/// Wang, Bovik, Sheikh and Simoncelli, "Image quality assessment: from error visibility to structural similarity",
/// IEEE Transactions on Image Processing 13 (2004), with K1 = 0.01 and K2 = 0.03. Only windows that lie in the
/// picture count, unless it is smaller than one.
pub fn ssim(reference: &Shown, other: &Shown) -> f64 {
    let kernel = gaussian(DEVIATION, RADIUS);
    let blur = |data: Vec<f32>| Plane::new(reference.width, data).convolved(&kernel, &kernel).data;
    // Small numbers keep their last bits in the squares of 32-bit floats if the mean of all is taken away first.
    let (a, b) = (reference.brightness(), other.brightness());
    let middle = super::mean(&a) as f32;
    let (a, b): (Vec<f32>, Vec<f32>) = a.iter().zip(&b).map(|(a, b)| (a - middle, b - middle)).unzip();
    let product = |x: &[f32], y: &[f32]| blur(x.iter().zip(y).map(|(x, y)| x * y).collect());
    let (aa, bb, ab) = (product(&a, &a), product(&b, &b), product(&a, &b));
    let (a, b) = (blur(a), blur(b));
    let peak = reference.range.peak();
    let moments = |at: usize| [a[at], b[at], aa[at], bb[at], ab[at]].map(f64::from);
    let windows: Vec<usize> = windows(reference.width, reference.height).collect();
    let sum: f64 = windows.iter().map(|at| likeness(moments(*at), f64::from(middle), peak)).sum();
    sum / windows.len() as f64
}

/// The middles of the windows that count.
fn windows(width: usize, height: usize) -> impl Iterator<Item = usize> {
    let inside = |length: usize| if length > 2 * RADIUS { RADIUS..length - RADIUS } else { 0..length };
    inside(height).flat_map(move |y| inside(width).map(move |x| y * width + x))
}

/// SSIM of one window from its moments about `middle`.
fn likeness([a, b, aa, bb, ab]: [f64; 5], middle: f64, peak: f64) -> f64 {
    let (c1, c2) = ((0.01 * peak).powi(2), (0.03 * peak).powi(2));
    let (variance_a, variance_b, covariance) = (aa - a * a, bb - b * b, ab - a * b);
    let (a, b) = (a + middle, b + middle);
    let brightness = (2.0 * a * b + c1) / (a * a + b * b + c1);
    brightness * (2.0 * covariance + c2) / (variance_a + variance_b + c2)
}
