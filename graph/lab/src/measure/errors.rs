//! The errors of a variant against the reference.

use crate::metrics::{self, PIXELS_PER_DEGREE, Range, Shown, difference, mean, percentile, psnr, ssim};

/// The percentile of errors: one pixel in a thousand has a larger one.
pub(crate) const SHARE: f64 = 0.999;

/// The differences of a clip from the reference: the worst of its frames.
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
            flicker,
        }
    }

    /// The figures by their names in files; `None` for a figure that does not apply or is infinite.
    pub(crate) fn named(&self, range: Range) -> [(&'static str, Option<f64>); 9] {
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
        flicker: None,
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
