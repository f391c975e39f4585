//! The errors of a variant against the reference.

use crate::metrics::{self, NO_DIFFERENCE, PIXELS_PER_DEGREE, Range, Shown, difference, mean, percentile, psnr, ssim};

/// The percentile of errors: one pixel in a thousand has a larger one.
pub(crate) const SHARE: f64 = 0.999;

/// The differences of a sequence from the reference: the worst of its frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// The largest error of a channel, in codes.
    pub max: f64,
    /// Its 99.9th percentile.
    pub p999: f64,
    /// Decibels; infinite for no error.
    pub psnr: f64,
    /// 1 for no error.
    pub ssim: f64,
    /// The mean CIEDE2000 or dE ITP.
    pub color: f64,
    /// Its 99.9th percentile.
    pub color_p999: f64,
    pub flip: f64,
    /// The quality of the whole sequence in JOD; 10 for no visible difference. A frame of it has none of its own.
    pub jod: f64,
    /// The change from frame to frame that the reference does not have; `None` for single frames.
    pub flicker: Option<Flicker>,
}

/// The change from frame to frame of the error of a channel, in codes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flicker {
    pub max: f64,
    /// The 99.9th percentile.
    pub p999: f64,
}

impl Errors {
    /// No difference in one frame.
    pub(crate) const NONE: Self = Self {
        max: 0.0,
        p999: 0.0,
        psnr: f64::INFINITY,
        ssim: 1.0,
        color: 0.0,
        color_p999: 0.0,
        flip: 0.0,
        jod: NO_DIFFERENCE,
        flicker: None,
    };

    /// No difference in this number of frames.
    pub(crate) fn none(frames: usize) -> Self {
        Self { flicker: (frames > 1).then_some(Flicker { max: 0.0, p999: 0.0 }), ..Self::NONE }
    }

    /// The worse of each figure.
    pub(crate) fn worst(self, other: Self) -> Self {
        let flicker = match (self.flicker, other.flicker) {
            (Some(a), Some(b)) => Some(Flicker { max: a.max.max(b.max), p999: a.p999.max(b.p999) }),
            (a, b) => a.or(b),
        };
        Self {
            max: self.max.max(other.max),
            p999: self.p999.max(other.p999),
            psnr: self.psnr.min(other.psnr),
            ssim: self.ssim.min(other.ssim),
            color: self.color.max(other.color),
            color_p999: self.color_p999.max(other.color_p999),
            flip: self.flip.max(other.flip),
            jod: self.jod.min(other.jod),
            flicker,
        }
    }

    /// The figures by their names in files; `None` for a figure that does not apply or is infinite.
    pub(crate) fn named(&self, range: Range) -> [(&'static str, Option<f64>); 10] {
        let (color, color_p999) = match range {
            Range::Sdr => ("ciede2000_mean", "ciede2000_p999"),
            Range::Hdr => ("deitp_mean", "deitp_p999"),
        };
        [
            ("max", Some(self.max)),
            ("p999", Some(self.p999)),
            ("psnr", Some(self.psnr).filter(|psnr| psnr.is_finite())),
            ("ssim", Some(self.ssim)),
            (color, Some(self.color)),
            (color_p999, Some(self.color_p999)),
            ("flip", Some(self.flip)),
            ("jod", Some(self.jod)),
            ("flicker_max", self.flicker.map(|flicker| flicker.max)),
            ("flicker_p999", self.flicker.map(|flicker| flicker.p999)),
        ]
    }
}

/// The errors of one frame.
pub(crate) fn errors(reference: &Shown, shown: &Shown) -> Errors {
    if reference.pixels == shown.pixels {
        return Errors::NONE;
    }
    let (codes, other) = (reference.codes(), shown.codes());
    let differences = difference(&codes, &other);
    let colors = match reference.range {
        Range::Sdr => metrics::ciede2000(&reference.pixels, &shown.pixels),
        Range::Hdr => metrics::delta_e_itp(&reference.pixels, &shown.pixels),
    };
    Errors {
        max: percentile(&differences, 1.0),
        p999: percentile(&differences, SHARE),
        psnr: psnr(&codes, &other, reference.range.peak()),
        ssim: ssim(reference, shown),
        color: mean(&colors),
        color_p999: percentile(&colors, SHARE),
        flip: mean(&metrics::flip(reference, shown, PIXELS_PER_DEGREE)),
        ..Errors::NONE
    }
}

/// The error of each channel from frame to frame.
#[derive(Default)]
pub(crate) struct ErrorTrace {
    previous: Option<Vec<[f32; 3]>>,
}

impl ErrorTrace {
    /// Adds the next frame; `None` for the first one.
    pub(crate) fn next(&mut self, reference: &Shown, shown: &Shown) -> Option<Flicker> {
        let (codes, other) = (reference.codes(), shown.codes());
        let minus = |(a, b): (&[f32; 3], &[f32; 3])| std::array::from_fn(|c| b[c] - a[c]);
        let error: Vec<[f32; 3]> = codes.iter().zip(&other).map(minus).collect();
        let previous = self.previous.replace(error)?;
        let change = difference(&previous, self.previous.as_deref().unwrap_or_default());
        Some(Flicker { max: percentile(&change, 1.0), p999: percentile(&change, SHARE) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A gray picture of these codes, of an SDR display.
    fn gray(codes: &[f32]) -> Shown {
        let pixels = codes.iter().map(|code| [code / 255.0; 3]).collect();
        Shown { width: codes.len(), height: 1, range: Range::Sdr, pixels }
    }

    #[track_caller]
    fn close(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-3, "{found} is not {expected}");
    }

    #[test]
    fn a_shift_of_three_codes_is_an_error_of_three_codes() {
        let found = errors(&gray(&[100.0; 2000]), &gray(&[103.0; 2000]));
        close(found.max, 3.0);
        close(found.p999, 3.0);
        close(found.psnr, 20.0 * (255.0_f64 / 3.0).log10());
        assert!(found.ssim < 1.0 && found.flip > 0.0);
        // For grays CIEDE2000 is the difference of L* over its weight: L* of these codes is 42.37 and 43.60.
        let lightness = |code: f64| 116.0 * ((code / 255.0 + 0.055) / 1.055).powf(2.4).cbrt() - 16.0;
        let (a, b) = (lightness(100.0), lightness(103.0));
        let middle = (0.5 * (a + b) - 50.0).powi(2);
        close(found.color, (b - a) / (1.0 + 0.015 * middle / (20.0 + middle).sqrt()));
    }

    #[test]
    fn the_largest_channel_counts_whatever_its_sign() {
        let (reference, mut other) = (gray(&[100.0; 4]), gray(&[100.0; 4]));
        other.pixels[2] = [105.0 / 255.0, 91.0 / 255.0, 1.0 / 2.55];
        let found = errors(&reference, &other);
        close(found.max, 9.0);
        assert_eq!(errors(&reference, &reference), Errors::NONE);
    }

    #[test]
    fn one_pixel_of_a_thousand_is_beyond_the_percentile_and_two_are_not() {
        let with = |wrong: usize| {
            let codes: Vec<f32> = (0..1000).map(|at| if at < wrong { 108.0 } else { 100.0 }).collect();
            errors(&gray(&[100.0; 1000]), &gray(&codes))
        };
        for (wrong, p999) in [(1, 0.0), (2, 8.0)] {
            close(with(wrong).max, 8.0);
            close(with(wrong).p999, p999);
        }
    }

    #[test]
    fn the_worst_of_two_frames_is_the_worse_of_each_figure() {
        let flat = [100.0; 1000];
        let mut spot = flat;
        spot[500] = 200.0;
        let (shifted, spotted) = (errors(&gray(&flat), &gray(&[102.0; 1000])), errors(&gray(&flat), &gray(&spot)));
        let worst = shifted.worst(spotted);
        close(worst.p999, 2.0);
        close(worst.max, 100.0);
        assert_eq!((worst.psnr, worst.ssim), (shifted.psnr.min(spotted.psnr), shifted.ssim.min(spotted.ssim)));
    }

    #[test]
    fn only_an_error_that_changes_flickers() {
        let flicker = |frames: [[f32; 2]; 3]| {
            let mut trace = ErrorTrace::default();
            let all = frames.map(|[reference, shown]| trace.next(&gray(&[reference; 8]), &gray(&[shown; 8])));
            assert_eq!(all[0], None, "a first frame follows none");
            all[1..].iter().map(|flicker| flicker.expect("the frame before is known").max).fold(0.0, f64::max)
        };
        close(flicker([[50.0, 52.0], [50.0, 52.0], [50.0, 52.0]]), 0.0);
        close(flicker([[50.0, 52.0], [90.0, 92.0], [50.0, 52.0]]), 0.0);
        close(flicker([[50.0, 52.0], [50.0, 49.0], [50.0, 49.0]]), 3.0);
        close(flicker([[50.0, 50.0], [54.0, 50.0], [50.0, 50.0]]), 4.0);
    }
}
