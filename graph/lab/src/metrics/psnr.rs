//! Peak signal-to-noise ratio.

/// Decibels between codes of three channels: 10 log10(peak² / mean square error); infinite for equal pictures.
pub fn psnr(reference: &[[f32; 3]], other: &[[f32; 3]], peak: f64) -> f64 {
    let square = |(a, b): (&[f32; 3], &[f32; 3])| -> f64 {
        a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum()
    };
    let sum: f64 = reference.iter().zip(other).map(square).sum();
    let mean = sum / (3 * reference.len().max(1)) as f64;
    10.0 * (peak * peak / mean).log10()
}
