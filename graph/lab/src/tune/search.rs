//! The search: from the most accurate choice, step by step to faster ones. Every choice that it looks at is measured.
//!
//! Each switch is measured alone first. Steps are tried in the order of what they save alone for their error alone, and
//! taken if the measurement of all switches together says so. Equal figures give equal results.

use std::collections::{BTreeMap, BTreeSet};

use super::target::{MIN_ERROR, MIN_SAVING, Measured, TuneTarget};
use crate::LabError;
use crate::measure::beats;

/// A choice and its figures.
pub(super) type Candidate = (Vec<usize>, Measured);

/// Measures a choice; `None` if no more choices may be measured.
type Measure<'o> = dyn FnMut(&[usize]) -> Result<Option<Measured>, LabError> + 'o;

/// A search among switches with these numbers of choices.
pub(super) struct Search<'s> {
    pub(super) sizes: &'s [usize],
    pub(super) target: TuneTarget,
    /// The measured choices, of earlier searches as well. The most accurate one and those of one switch are among them.
    pub(super) known: &'s mut BTreeMap<Vec<usize>, Measured>,
}

/// The most accurate choice and all that change one switch.
pub(super) fn singles(sizes: &[usize]) -> Vec<Vec<usize>> {
    let exact = vec![0; sizes.len()];
    let mut all = vec![exact.clone()];
    for (switch, size) in sizes.iter().enumerate() {
        all.extend((1..*size).map(|at| with(&exact, switch, at)));
    }
    all
}

fn with(choice: &[usize], switch: usize, at: usize) -> Vec<usize> {
    let mut choice = choice.to_vec();
    choice[switch] = at;
    choice
}

impl Search<'_> {
    /// The best choice that is found.
    pub(super) fn best(&mut self, measure: &mut Measure<'_>) -> Result<Candidate, LabError> {
        let exact = vec![0; self.sizes.len()];
        let found = self.descend((exact.clone(), self.known[&exact]), measure)?;
        // One switch alone, or what another goal has found, can be better than all steps from the most accurate choice.
        let best = self.best_known();
        let found = if self.target.prefers(&best.1, &found.1) { self.descend(best, measure)? } else { found };
        self.refine(found, measure)
    }

    /// The figures of a choice, or `None` if it is not known and no more may be measured.
    fn figures(&mut self, choice: &[usize], measure: &mut Measure<'_>) -> Result<Option<Measured>, LabError> {
        if let Some(known) = self.known.get(choice) {
            return Ok(Some(*known));
        }
        let measured = measure(choice)?;
        self.known.extend(measured.map(|measured| (choice.to_vec(), measured)));
        Ok(measured)
    }

    /// Takes steps that save time, until a budget is reached or none is left. Errors stay within the target's limit.
    fn descend(&mut self, from: Candidate, measure: &mut Measure<'_>) -> Result<Candidate, LabError> {
        let mut here = from;
        let mut tried = BTreeSet::new();
        let is_budget = matches!(self.target, TuneTarget::Budget(_));
        while !(is_budget && self.target.is_met(&here.1)) {
            let Some((switch, at)) = self.next_step(&here.0, &tried) else { break };
            tried.insert((switch, at));
            let choice = with(&here.0, switch, at);
            let Some(measured) = self.figures(&choice, measure)? else { break };
            let saves = measured.ms < here.1.ms * (1.0 - MIN_SAVING);
            if saves && (is_budget || self.target.is_met(&measured)) {
                here = (choice, measured);
            }
        }
        Ok(here)
    }

    /// The switch, and its choice, that alone saves most time for its error. A step whose error alone is beyond the
    /// limit is none: few errors cancel, as of a halving that widens a glow and an enlargement that narrows it, and the
    /// search misses those that do.
    fn next_step(&self, here: &[usize], tried: &BTreeSet<(usize, usize)>) -> Option<(usize, usize)> {
        let exact = vec![0; self.sizes.len()];
        let least_saving = MIN_SAVING * self.known[&exact].ms;
        let (mut best, mut largest_gain) = (None, 0.0);
        for (switch, size) in self.sizes.iter().enumerate() {
            let now = self.known[&with(&exact, switch, here[switch])];
            for at in (1..*size).filter(|at| !tried.contains(&(switch, *at))) {
                let alone = self.known[&with(&exact, switch, at)];
                let is_within = matches!(self.target, TuneTarget::Budget(_)) || self.target.is_met(&alone);
                let saving = now.ms - alone.ms;
                let gain = saving / (alone.point().1 - now.point().1).max(MIN_ERROR);
                if is_within && saving > least_saving && gain > largest_gain {
                    (best, largest_gain) = (Some((switch, at)), gain);
                }
            }
        }
        best
    }

    /// Makes each switch more accurate, where that costs no time or is within the budget.
    fn refine(&mut self, found: Candidate, measure: &mut Measure<'_>) -> Result<Candidate, LabError> {
        let mut best = found;
        // All these steps together may cost no more than the least saving of one step.
        let longest = best.1.ms / (1.0 - MIN_SAVING);
        for switch in 0..best.0.len() {
            for at in 0..best.0[switch] {
                let choice = with(&best.0, switch, at);
                let Some(measured) = self.figures(&choice, measure)? else { return Ok(best) };
                let is_free = measured.ms <= longest && measured.point().1 <= best.1.point().1;
                if self.target.is_met(&measured) && (is_free || self.target.gains(&measured, &best.1)) {
                    best = (choice, measured);
                    break;
                }
            }
        }
        Ok(best)
    }

    /// The best of the Pareto-optimal choices that are known; the first of equal ones.
    fn best_known(&self) -> Candidate {
        let is_beaten = |figures: &Measured| self.known.values().any(|other| beats(other.point(), figures.point()));
        let mut best: Option<(&Vec<usize>, &Measured)> = None;
        for (choice, figures) in self.known.iter().filter(|(_, figures)| !is_beaten(figures)) {
            if best.is_none_or(|(_, before)| self.target.prefers(figures, before)) {
                best = Some((choice, figures));
            }
        }
        let (choice, figures) = best.expect("the most accurate choice is known, and nothing beats all choices");
        (choice.clone(), *figures)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
mod tests {
    use super::*;

    /// The time and the error of each choice of three switches.
    const COSTS: [&[(f64, f64)]; 3] =
        [&[(4.0, 0.0), (2.0, 0.3), (1.0, 4.0)], &[(3.0, 0.0), (1.5, 0.1)], &[(1.0, 0.0), (0.9, 2.0)]];
    const SIZES: [usize; 3] = [3, 2, 2];

    /// Times and errors that add up.
    fn sums(choice: &[usize]) -> Measured {
        let parts = || COSTS.iter().zip(choice).map(|(costs, at)| costs[*at]);
        let (ms, p999) = (parts().map(|p| p.0).sum(), parts().map(|p| p.1).sum());
        Measured { ms, p999, max: 2.0 * p999, ..Measured::default() }
    }

    /// The first two switches together have ten times the sum of their errors.
    fn amplified(choice: &[usize]) -> Measured {
        let sum = sums(choice);
        let factor = if choice[0] > 0 && choice[1] > 0 { 10.0 } else { 1.0 };
        Measured { p999: factor * sum.p999, ..sum }
    }

    /// Two switches save the same work: together they save no more than one of them.
    fn overlapping(choice: &[usize]) -> Measured {
        let sum = sums(choice);
        let twice = if choice[0] > 0 && choice[1] > 0 { 1.5 } else { 0.0 };
        Measured { ms: sum.ms + twice, ..sum }
    }

    /// The best choice for a target with at most so many measurements after those of single switches, and the choices
    /// that were measured.
    fn found(target: TuneTarget, of: fn(&[usize]) -> Measured, most: usize) -> (Candidate, Vec<Vec<usize>>) {
        let mut known = singles(&SIZES).into_iter().map(|choice| (choice.clone(), of(&choice))).collect();
        let mut measured = Vec::new();
        let mut search = Search { sizes: &SIZES, target, known: &mut known };
        let best = search.best(&mut |choice| {
            assert!(!measured.iter().any(|known| known == choice), "{choice:?} is measured twice");
            if measured.len() == most {
                return Ok(None);
            }
            measured.push(choice.to_vec());
            Ok(Some(of(choice)))
        });
        (best.unwrap(), measured)
    }

    const TARGETS: [TuneTarget; 8] = [
        TuneTarget::Budget(8.0),
        TuneTarget::Budget(6.5),
        TuneTarget::Budget(4.6),
        TuneTarget::Budget(3.6),
        TuneTarget::Error(0.0),
        TuneTarget::Error(0.4),
        TuneTarget::Error(0.45),
        TuneTarget::Error(5.0),
    ];

    #[test]
    fn what_is_found_is_what_trying_everything_finds() {
        for of in [sums, amplified, overlapping] {
            for target in TARGETS {
                let (best, _) = found(target, of, 12);
                let mut known: BTreeMap<_, _> = (0..12)
                    .map(|i| vec![i / 4, i / 2 % 2, i % 2])
                    .map(|choice| (choice.clone(), of(&choice)))
                    .collect();
                let wanted = Search { sizes: &SIZES, target, known: &mut known }.best_known();
                assert_eq!(target.is_met(&best.1), target.is_met(&wanted.1), "{target}: {best:?}");
                if target.is_met(&wanted.1) {
                    assert_eq!(best.1.point(), wanted.1.point(), "{target}: {best:?}, not {wanted:?}");
                }
            }
        }
    }

    #[test]
    fn the_closest_is_found_where_the_goal_cannot_be_met() {
        let target = TuneTarget::Budget(1.0);
        let ((choice, figures), _) = found(target, sums, 12);
        assert!(!target.is_met(&figures));
        assert_eq!(choice, [2, 1, 1]);
    }

    #[test]
    fn equal_figures_lead_to_equal_choices_in_few_measurements() {
        for target in TARGETS {
            let (best, measured) = found(target, sums, 12);
            assert_eq!(found(target, sums, 12), (best, measured.clone()));
            assert!(measured.len() <= 4, "{target}: {measured:?}");
        }
    }

    /// With no measurement left, the best of what is known is found, and nothing that is beyond the limit.
    #[test]
    fn a_search_that_may_measure_no_more_gives_what_it_knows() {
        for target in [TuneTarget::Error(0.45), TuneTarget::Error(5.0)] {
            let (best, measured) = found(target, sums, 0);
            assert!(measured.is_empty() && target.is_met(&best.1), "{best:?}");
            assert_eq!(best.0, if target == TuneTarget::Error(5.0) { [2, 0, 0] } else { [1, 0, 0] });
        }
    }
}
