//! The errors of a variant against the truth.

use afterimage_lab::metrics::{self, PIXELS_PER_DEGREE, Range, Shown, difference, mean, percentile, psnr, ssim};

/// The share of pixels that the percentiles leave out is one in a thousand.
pub(crate) const SHARE: f64 = 0.999;

/// How far a clip is from the truth: the worst of its frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Errors {
    /// The largest error of a channel, in codes.
    pub(crate) max: f64,
    /// Its 99.9 percentile.
    pub(crate) p999: f64,
    /// Decibels; infinite for no error.
    pub(crate) psnr: f64,
    /// 1 for no error.
    pub(crate) ssim: f64,
    /// The mean CIEDE2000 or dE ITP.
    pub(crate) colour: f64,
    /// Its 99.9 percentile.
    pub(crate) colour_p999: f64,
    /// The mean FLIP.
    pub(crate) flip: f64,
    /// What changes between frames and does not in the truth; `None` for single frames.
    pub(crate) flicker: Option<Flicker>,
}

/// The change from frame to frame of the error of a channel, in codes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Flicker {
    /// The largest.
    pub(crate) max: f64,
    /// The 99.9 percentile.
    pub(crate) p999: f64,
}

impl Errors {
    /// Those of a perfect copy of one frame.
    pub(crate) const NONE: Self = Self {
        max: 0.0,
        p999: 0.0,
        psnr: f64::INFINITY,
        ssim: 1.0,
        colour: 0.0,
        colour_p999: 0.0,
        flip: 0.0,
        flicker: None,
    };

    /// Those of a perfect copy of so many frames.
    pub(crate) fn none(frames: usize) -> Self {
        Self { flicker: (frames > 1).then_some(Flicker { max: 0.0, p999: 0.0 }), ..Self::NONE }
    }

    /// The worse of each.
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
            colour: self.colour.max(other.colour),
            colour_p999: self.colour_p999.max(other.colour_p999),
            flip: self.flip.max(other.flip),
            flicker,
        }
    }

    /// The figures by the names that they have in files. `None` where there is none, or none that is finite.
    pub(crate) fn named(&self, range: Range) -> [(&'static str, Option<f64>); 9] {
        let (colour, colour_p999) = match range {
            Range::Sdr => ("ciede2000_mean", "ciede2000_p999"),
            Range::Hdr => ("deitp_mean", "deitp_p999"),
        };
        [
            ("max", Some(self.max)),
            ("p999", Some(self.p999)),
            ("psnr", Some(self.psnr).filter(|psnr| psnr.is_finite())),
            ("ssim", Some(self.ssim)),
            (colour, Some(self.colour)),
            (colour_p999, Some(self.colour_p999)),
            ("flip", Some(self.flip)),
            ("flicker_max", self.flicker.map(|flicker| flicker.max)),
            ("flicker_p999", self.flicker.map(|flicker| flicker.p999)),
        ]
    }
}

/// The errors of one frame.
pub(crate) fn errors(truth: &Shown, shown: &Shown) -> Errors {
    if truth.pixels == shown.pixels {
        return Errors::NONE;
    }
    let (codes, other) = (truth.codes(), shown.codes());
    let off = difference(&codes, &other);
    let colours = match truth.range {
        Range::Sdr => metrics::ciede2000(&truth.pixels, &shown.pixels),
        Range::Hdr => metrics::delta_e_itp(&truth.pixels, &shown.pixels),
    };
    Errors {
        max: percentile(&off, 1.0),
        p999: percentile(&off, SHARE),
        psnr: psnr(&codes, &other, truth.range.peak()),
        ssim: ssim(truth, shown),
        colour: mean(&colours),
        colour_p999: percentile(&colours, SHARE),
        flip: mean(&metrics::flip(truth, shown, PIXELS_PER_DEGREE)),
        flicker: None,
    }
}

/// Follows the error of each channel from frame to frame.
#[derive(Default)]
pub(crate) struct Follower {
    before: Option<Vec<[f32; 3]>>,
}

impl Follower {
    /// Takes the next frame; `None` for the first.
    pub(crate) fn next(&mut self, truth: &Shown, shown: &Shown) -> Option<Flicker> {
        let (codes, other) = (truth.codes(), shown.codes());
        let minus = |(a, b): (&[f32; 3], &[f32; 3])| std::array::from_fn(|c| b[c] - a[c]);
        let error: Vec<[f32; 3]> = codes.iter().zip(&other).map(minus).collect();
        let before = self.before.replace(error)?;
        let change = difference(&before, self.before.as_deref().unwrap_or_default());
        Some(Flicker { max: percentile(&change, 1.0), p999: percentile(&change, SHARE) })
    }
}
