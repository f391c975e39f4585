//! The figures of a choice of quality switches, and the limit that a tier must keep.

use serde::{Deserialize, Serialize};

use crate::metrics::NO_DIFFERENCE;

/// Times that differ by less than this share are equal: the difference is noise.
pub(super) const MIN_SAVING: f64 = 0.01;
/// Errors below this number of codes are equal.
pub(super) const MIN_ERROR: f64 = 1e-3;
/// Claims state errors this factor above the worst that was measured, because other pictures can be a little worse.
pub const MARGIN: f64 = 1.1;
/// An error counts as smaller if it is smaller by at least this number of codes; less comes from rounding.
const MIN_GAIN: f64 = 0.05;

/// The 99.9th percentile in codes that a claim states of what was measured: near no difference, a factor adds less than
/// another picture does.
pub fn claimed_p999(measured: f64) -> f64 {
    (MARGIN * measured).max(measured + 0.05)
}

/// The FLIP that a claim states of what was measured.
pub fn claimed_flip(measured: f64) -> f64 {
    (MARGIN * measured).max(measured + 0.003)
}

/// The JOD that a claim states of what was measured.
pub fn claimed_jod(measured: f64) -> f64 {
    (NO_DIFFERENCE - MARGIN * (NO_DIFFERENCE - measured)).min(measured - 0.02)
}

/// The limit that a tuned pipeline must keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TuneTarget {
    /// The most milliseconds; the smallest error within them is searched.
    Budget(f64),
    /// The largest error in codes that may be claimed; the shortest time within it is searched.
    Error(f64),
    /// Every switch at its most accurate.
    MostAccurate,
}

/// The figures of a choice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Milliseconds of the median frame.
    pub ms: f64,
    /// The 99.9th percentile of the error, in codes.
    pub p999: f64,
    /// The same without the image where it is largest; `None` for one image.
    #[serde(default)]
    pub p999_without_worst: Option<f64>,
    pub max: f64,
    /// Bytes of transient images.
    pub bytes: u64,
    /// Bytes that the passes of a frame move.
    #[serde(default)]
    pub bytes_moved: u64,
}

impl Measured {
    /// The worse of each figure, of some images and of one more.
    pub(super) fn worst(self, other: Self) -> Self {
        let second = self.p999.min(other.p999);
        Self {
            ms: self.ms.max(other.ms),
            p999: self.p999.max(other.p999),
            p999_without_worst: Some(self.p999_without_worst.map_or(second, |before| before.max(second))),
            max: self.max.max(other.max),
            bytes: self.bytes.max(other.bytes),
            bytes_moved: self.bytes_moved.max(other.bytes_moved),
        }
    }

    /// The 99.9th percentile that a claim states, in codes.
    pub fn claimed_p999(&self) -> f64 {
        claimed_p999(self.p999)
    }

    /// True if a measurement can have these figures.
    pub(super) fn is_possible(&self) -> bool {
        let figures = [self.ms, self.p999, self.p999_without_worst.unwrap_or(0.0), self.max];
        figures.iter().all(|figure| figure.is_finite() && *figure >= 0.0)
    }

    pub(super) fn point(&self) -> (f64, f64) {
        (self.ms, self.p999.max(MIN_ERROR))
    }
}

impl TuneTarget {
    /// True if the figures are within the limit.
    pub(super) fn is_met(self, measured: &Measured) -> bool {
        match self {
            Self::Budget(ms) => measured.ms <= ms,
            Self::Error(codes) => measured.claimed_p999() <= codes,
            Self::MostAccurate => true,
        }
    }

    /// True if `a` is better than `b`: first what is within the limit, then the smaller other figure, then the
    /// smaller limited one.
    pub(super) fn prefers(self, a: &Measured, b: &Measured) -> bool {
        match (self.is_met(a), self.is_met(b)) {
            (true, true) => self.minimized(a) < self.minimized(b),
            (false, false) => self.limited(a) < self.limited(b),
            (a, _) => a,
        }
    }

    /// True if `a` is better than `b` by more than noise.
    pub(super) fn gains(self, a: &Measured, b: &Measured) -> bool {
        let (now, before) = (a.point(), b.point());
        let counts = match (self, self.is_met(b)) {
            (Self::Budget(_) | Self::MostAccurate, true) | (Self::Error(_) | Self::MostAccurate, false) => {
                now.1 < before.1 - MIN_GAIN
            }
            (Self::Error(_), true) | (Self::Budget(_), false) => now.0 < before.0 * (1.0 - MIN_SAVING),
        };
        self.prefers(a, b) && counts
    }

    /// The figure to minimize within the limit, and the one that decides between equals.
    fn minimized(self, measured: &Measured) -> (Ordered, Ordered) {
        let (ms, error) = measured.point();
        match self {
            Self::Budget(_) | Self::MostAccurate => (Ordered(error), Ordered(ms)),
            Self::Error(_) => (Ordered(ms), Ordered(error)),
        }
    }

    /// The figure that the limit is about, and the one that decides between equals.
    fn limited(self, measured: &Measured) -> (Ordered, Ordered) {
        let (first, second) = self.minimized(measured);
        (second, first)
    }
}

impl std::fmt::Display for TuneTarget {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Budget(ms) => write!(f, "within {ms} ms"),
            Self::Error(codes) => write!(f, "within {codes} codes"),
            Self::MostAccurate => write!(f, "the most accurate"),
        }
    }
}

/// Numbers in their total order.
#[derive(Clone, Copy, PartialEq)]
struct Ordered(f64);

impl PartialOrd for Ordered {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.0.total_cmp(&other.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_figure_of_the_other_images_is_the_second_largest_error() {
        let of = |p999: f64| Measured { p999, ..Measured::default() };
        let all = [2.0, 7.0, 3.0, 5.0].map(of).into_iter().reduce(Measured::worst).expect("four figures");
        assert_eq!((all.p999, all.p999_without_worst), (7.0, Some(5.0)));
    }

    #[test]
    fn a_claim_with_its_margin_decides_whether_a_limit_is_kept() {
        let of = |ms: f64, p999: f64| Measured { ms, p999, ..Measured::default() };
        assert!(TuneTarget::Error(1.1).is_met(&of(9.0, 1.0)) && !TuneTarget::Error(1.09).is_met(&of(9.0, 1.0)));
        assert!(TuneTarget::Budget(9.0).is_met(&of(9.0, 1.0)) && !TuneTarget::Budget(8.9).is_met(&of(9.0, 1.0)));
        // Within the limit the other figure decides, beyond it the limited one.
        let error = TuneTarget::Error(2.0);
        assert!(error.prefers(&of(1.0, 1.5), &of(2.0, 0.0)) && error.prefers(&of(5.0, 1.0), &of(1.0, 2.0)));
        assert!(error.prefers(&of(5.0, 3.0), &of(1.0, 4.0)));
        // A hundredth of the time is noise.
        assert!(!error.gains(&of(0.995, 0.0), &of(1.0, 0.0)) && error.gains(&of(0.98, 0.0), &of(1.0, 0.0)));
    }
}
