//! The search: a greedy descent from the most accurate choice, always by the step that saves most time for its error,
//! then a local search.
//!
//! Steps are tried in the order of the switches and the first of equal steps wins, so equal figures give equal results.

use serde::{Deserialize, Serialize};

use crate::LabError;
use crate::measure::beats;

/// A step counts if it saves at least this share of the time; less is noise.
const MIN_SAVING: f64 = 0.01;
/// Errors below this number of codes are equal.
const MIN_ERROR: f64 = 1e-3;
/// Claims state errors this factor above the worst that was measured, because other pictures can be a little worse.
pub const MARGIN: f64 = 1.1;
/// An error counts as smaller if it is smaller by at least this number of codes; less comes from rounding.
const MIN_GAIN: f64 = 0.05;

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
    /// The largest error.
    pub max: f64,
    /// Bytes of transient images.
    pub bytes: u64,
    /// Whether the errors are predicted from those of the switches, and not measured.
    #[serde(default)]
    pub is_predicted: bool,
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
            is_predicted: self.is_predicted || other.is_predicted,
        }
    }

    /// The 99.9th percentile that a claim states, in codes.
    pub fn claimed_p999(&self) -> f64 {
        MARGIN * self.p999
    }

    /// Whether a measurement can have these figures.
    pub(super) fn is_possible(&self) -> bool {
        let figures = [self.ms, self.p999, self.p999_without_worst.unwrap_or(0.0), self.max];
        figures.iter().all(|figure| figure.is_finite() && *figure >= 0.0)
    }

    pub(super) fn point(&self) -> (f64, f64) {
        (self.ms, self.p999.max(MIN_ERROR))
    }
}

impl TuneTarget {
    /// Whether the figures are within the limit.
    pub(super) fn is_met(self, measured: &Measured) -> bool {
        match self {
            Self::Budget(ms) => measured.ms <= ms,
            Self::Error(codes) => measured.claimed_p999() <= codes,
            Self::MostAccurate => true,
        }
    }

    /// Whether `a` is better than `b`: first what is within the limit, then the smaller other figure, then the
    /// smaller limited one.
    fn prefers(self, a: &Measured, b: &Measured) -> bool {
        match (self.is_met(a), self.is_met(b)) {
            (true, true) => self.minimized(a) < self.minimized(b),
            (false, false) => self.limited(a) < self.limited(b),
            (a, _) => a,
        }
    }

    /// Whether `a` is better than `b` by more than noise.
    fn gains(self, a: &Measured, b: &Measured) -> bool {
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

/// The figures of a choice.
type Evaluate<'o> = dyn FnMut(&[usize]) -> Result<Measured, LabError> + 'o;

/// A choice and its figures.
pub(super) type Candidate = (Vec<usize>, Measured);

/// The best choice that the search finds, of switches with these numbers of choices.
pub(super) fn search(sizes: &[usize], target: TuneTarget, evaluate: &mut Evaluate<'_>) -> Result<Candidate, LabError> {
    let mut found = Vec::new();
    descend(sizes, target, evaluate, &mut found)?;
    let mut best = best_of(&found, target);
    loop {
        let mut near = vec![best.clone()];
        for choice in neighbors(&best.0, sizes) {
            let measured = evaluate(&choice)?;
            near.push((choice, measured));
        }
        let better = best_of(&near, target);
        if !target.gains(&better.1, &best.1) {
            return refine(best, target, evaluate);
        }
        best = better;
    }
}

/// The choice without steps that save nothing: each switch becomes more accurate while that costs no time.
fn refine(best: Candidate, target: TuneTarget, evaluate: &mut Evaluate<'_>) -> Result<Candidate, LabError> {
    let mut best = best;
    // All these steps together may cost no more than the least saving of one step.
    let most = best.1.ms / (1.0 - MIN_SAVING);
    for switch in 0..best.0.len() {
        for at in 0..best.0[switch] {
            let mut choice = best.0.clone();
            choice[switch] = at;
            let measured = evaluate(&choice)?;
            if measured.ms <= most && measured.point().1 <= best.1.point().1 && target.is_met(&measured) {
                best = (choice, measured);
                break;
            }
        }
    }
    Ok(best)
}

/// Steps from the most accurate choice to faster ones, until the target is reached or no step saves time. All choices
/// are kept.
fn descend(
    sizes: &[usize],
    target: TuneTarget,
    evaluate: &mut Evaluate<'_>,
    found: &mut Vec<Candidate>,
) -> Result<(), LabError> {
    let exact = vec![0; sizes.len()];
    let mut here = (exact.clone(), evaluate(&exact)?);
    found.push(here.clone());
    while !matches!(target, TuneTarget::Budget(ms) if here.1.ms <= ms) {
        let mut steps = Vec::new();
        for choice in neighbors(&here.0, sizes).into_iter().filter(|choice| is_cheaper(choice, &here.0)) {
            let measured = evaluate(&choice)?;
            steps.push((choice, measured));
        }
        found.extend(steps.iter().cloned());
        let allowed = |(_, m): &&Candidate| {
            let saves = m.ms < here.1.ms * (1.0 - MIN_SAVING);
            saves && (matches!(target, TuneTarget::Budget(_)) || target.is_met(m))
        };
        let gain = |(_, m): &Candidate| (here.1.ms - m.ms) / (m.point().1 - here.1.point().1).max(MIN_ERROR);
        let Some(next) = first_largest(steps.iter().filter(allowed), gain) else { return Ok(()) };
        here = next.clone();
    }
    Ok(())
}

/// The best of the Pareto-optimal choices; the first of equal ones.
pub(super) fn best_of(all: &[Candidate], target: TuneTarget) -> Candidate {
    let on_front = |a: &&Candidate| !all.iter().any(|b| beats(b.1.point(), a.1.point()));
    let mut front = all.iter().filter(on_front);
    let first = front.next().expect("of some candidates, at least one is on the front");
    front.fold(first, |best, next| if target.prefers(&next.1, &best.1) { next } else { best }).clone()
}

fn first_largest<'c>(
    all: impl Iterator<Item = &'c Candidate>,
    gain: impl Fn(&Candidate) -> f64,
) -> Option<&'c Candidate> {
    all.fold(None, |best, next| match best {
        Some(best) if gain(next) <= gain(best) => Some(best),
        _ => Some(next),
    })
}

/// Every choice that differs in one switch, in the order of the switches.
fn neighbors(from: &[usize], sizes: &[usize]) -> Vec<Vec<usize>> {
    let mut all = Vec::new();
    for (switch, size) in sizes.iter().enumerate() {
        for at in (0..*size).filter(|at| *at != from[switch]) {
            let mut choice = from.to_vec();
            choice[switch] = at;
            all.push(choice);
        }
    }
    all
}

fn is_cheaper(choice: &[usize], than: &[usize]) -> bool {
    choice.iter().zip(than).all(|(a, b)| a >= b)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
mod tests {
    use super::*;

    /// Three switches: what each choice costs in time and in error.
    const COSTS: [&[(f64, f64)]; 3] =
        [&[(4.0, 0.0), (2.0, 0.3), (1.0, 4.0)], &[(3.0, 0.0), (1.5, 0.1)], &[(1.0, 0.0), (0.9, 2.0)]];
    const SIZES: [usize; 3] = [3, 2, 2];

    fn figures(choice: &[usize]) -> Measured {
        let parts = || COSTS.iter().zip(choice).map(|(costs, at)| costs[*at]);
        let (ms, p999) = (parts().map(|p| p.0).sum(), parts().map(|p| p.1).sum());
        Measured { ms, p999, max: 2.0 * p999, ..Measured::default() }
    }

    fn every_choice() -> Vec<Vec<usize>> {
        (0..12).map(|i| vec![i / 4, i / 2 % 2, i % 2]).collect()
    }

    fn best_by_trying_all(target: TuneTarget) -> Measured {
        let all: Vec<Candidate> = every_choice().into_iter().map(|choice| (choice.clone(), figures(&choice))).collect();
        best_of(&all, target).1
    }

    #[test]
    fn finds_what_trying_everything_finds() {
        for target in [
            TuneTarget::Budget(8.0),
            TuneTarget::Budget(6.5),
            TuneTarget::Budget(4.6),
            TuneTarget::Budget(3.6),
            TuneTarget::Error(0.0),
            TuneTarget::Error(0.4),
            TuneTarget::Error(5.0),
        ] {
            let (choice, found) = search(&SIZES, target, &mut |choice| Ok(figures(choice))).unwrap();
            assert!(target.is_met(&found), "{target}: {choice:?}");
            assert_eq!(found, best_by_trying_all(target), "{target}: {choice:?}");
        }
    }

    #[test]
    fn comes_closest_where_the_goal_cannot_be_met() {
        let target = TuneTarget::Budget(1.0);
        let (choice, found) = search(&SIZES, target, &mut |choice| Ok(figures(choice))).unwrap();
        assert!(!target.is_met(&found));
        assert_eq!(choice, [2, 1, 1]);
    }

    #[test]
    fn what_other_images_claim_is_the_second_largest_error() {
        let of = |p999: f64| Measured { p999, ..Measured::default() };
        let all = [2.0, 7.0, 3.0, 5.0].map(of).into_iter().reduce(Measured::worst).unwrap();
        assert_eq!((all.p999, all.p999_without_worst), (7.0, Some(5.0)));
    }

    #[test]
    fn equal_figures_lead_to_equal_choices() {
        let run = || {
            let mut asked = Vec::new();
            let found = search(&SIZES, TuneTarget::Budget(4.6), &mut |choice| {
                asked.push(choice.to_vec());
                Ok(figures(choice))
            });
            (found.unwrap(), asked)
        };
        assert_eq!(run(), run());
    }
}
