//! The error of a choice, predicted from those of its switches.
//!
//! Errors have signs, and some cancel: so signed images are added, and the figures are those of the sum. Two filters,
//! one of which reads what the other makes, are measured as a pair.

use half::f16;

use crate::measure::errors::SHARE;
use crate::metrics::percentile;

/// Signed differences from the reference, in codes, of each frame of each clip. Of large images some pixels are kept.
pub(super) struct SignedErrors(Vec<Vec<Frame>>);

/// The channels of the pixels that are kept.
type Frame = Vec<[f16; 3]>;

/// Pixels of all frames that are kept at most, and of one frame: at least, if it has them, and at most. That is enough
/// for one of a thousand.
const MAX_PIXELS: usize = 1 << 20;
const FRAME_PIXELS: (usize, usize) = (1 << 13, 1 << 16);

impl SignedErrors {
    /// Keeps differences of all pixels, by clip and frame.
    pub(super) fn new(clips: &[Vec<Vec<[f32; 3]>>]) -> Self {
        let frames: usize = clips.iter().map(Vec::len).sum();
        let most = (MAX_PIXELS / frames.max(1)).clamp(FRAME_PIXELS.0, FRAME_PIXELS.1);
        let mut kept = Vec::with_capacity(clips.len());
        for frames in clips {
            kept.push(frames.iter().map(|frame| sampled(frame, most)).collect());
        }
        Self(kept)
    }

    /// The 99.9th percentile and the largest error of each clip, of a choice of several switches. `exact` is the error
    /// of the most accurate choice, which each of `parts` contains; what it adds to that counts by its factor.
    pub(super) fn of_sum(exact: &Self, parts: &[(&Self, f32)]) -> Vec<(f64, f64)> {
        let mut clips = Vec::with_capacity(exact.0.len());
        for (clip, frames) in exact.0.iter().enumerate() {
            let mut worst = (0.0_f64, 0.0_f64);
            for (number, frame) in frames.iter().enumerate() {
                let mut sums = Vec::with_capacity(frame.len());
                for (pixel, base) in frame.iter().enumerate() {
                    let base = base.map(f32::from);
                    let mut sum = base;
                    for (part, factor) in parts {
                        let part = part.0[clip][number][pixel];
                        for (channel, sum) in sum.iter_mut().enumerate() {
                            *sum += factor * (f32::from(part[channel]) - base[channel]);
                        }
                    }
                    sums.push(sum.map(f32::abs).into_iter().fold(0.0, f32::max));
                }
                worst = (worst.0.max(percentile(&sums, SHARE)), worst.1.max(percentile(&sums, 1.0)));
            }
            clips.push(worst);
        }
        clips
    }
}

/// Every so many pixels of a frame, `most` of them.
fn sampled(frame: &[[f32; 3]], most: usize) -> Frame {
    let step = frame.len().div_ceil(most).max(1);
    frame.iter().step_by(step).map(|pixel| pixel.map(f16::from_f32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(error: f32) -> SignedErrors {
        SignedErrors::new(&[vec![vec![[error, 0.0, -error]; 10]]])
    }

    #[test]
    fn errors_of_opposite_signs_cancel_and_others_add_up() {
        let (exact, up, down) = (flat(0.25), flat(2.25), flat(-1.75));
        assert_eq!(SignedErrors::of_sum(&exact, &[(&up, 1.0), (&down, 1.0)]), [(0.25, 0.25)]);
        assert_eq!(SignedErrors::of_sum(&exact, &[(&up, 1.0), (&up, 1.0)]), [(4.25, 4.25)]);
        assert_eq!(SignedErrors::of_sum(&exact, &[(&up, 3.0), (&down, -1.0)]), [(8.25, 8.25)]);
        assert_eq!(SignedErrors::of_sum(&exact, &[]), [(0.25, 0.25)]);
    }

    #[test]
    fn large_frames_are_sampled() {
        let frame: Vec<[f32; 3]> = (0..200_000).map(|at| [at as f32 / 200_000.0; 3]).collect();
        let errors = SignedErrors::new(&[vec![frame]]);
        let (p999, max) = SignedErrors::of_sum(&errors, &[])[0];
        assert!((p999 - 0.999).abs() < 1e-3 && (max - 1.0).abs() < 1e-3, "{p999} {max}");
    }
}
