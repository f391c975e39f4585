//! The search for one goal after another: on some pictures first, then confirmed on all.

use std::collections::BTreeMap;

use super::measurer::{ChoiceMeasurer, Confirmed};
use super::search::{Candidate, Search, singles};
use super::state::SearchState;
use super::steps::{MAX_CONFIRMATIONS, Steps, max_choices, single_choices};
use super::target::{Measured, TuneTarget};
use crate::LabError;
use crate::measure::wires::{Traded, sentence};

/// After a choice that other pictures refuse, the search stays below this share of its error.
const LESS: f64 = 0.9;

/// A search with all that it knows.
pub(super) struct Tuner<'a> {
    pub(super) measurer: ChoiceMeasurer<'a>,
    pub(super) state: SearchState,
    /// The choices that this search has measured, or taken from the state.
    known: BTreeMap<Vec<usize>, Measured>,
    pub(super) steps: Steps<'a>,
}

impl<'a> Tuner<'a> {
    pub(super) fn new(measurer: ChoiceMeasurer<'a>, state: SearchState, steps: Steps<'a>) -> Self {
        Self { measurer, state, known: BTreeMap::new(), steps }
    }

    /// Measures every switch alone, if a goal needs a search.
    pub(super) fn measure_singles(&mut self, targets: impl Iterator<Item = TuneTarget>) -> Result<(), LabError> {
        let (sizes, before) = (self.measurer.space.sizes(), self.steps.done());
        if targets.into_iter().any(|target| target != TuneTarget::MostAccurate) {
            for choice in singles(&sizes) {
                self.measured(&choice)?;
            }
        } else {
            self.measured(&self.measurer.space.most_accurate())?;
        }
        self.steps.end_part(before, single_choices(&sizes));
        Ok(())
    }

    /// The cost of each format of a wire alone, in words; nothing if no switch was measured alone.
    pub(super) fn wires(&self) -> Vec<String> {
        let space = &self.measurer.space;
        let traded = |measured: &Measured| Traded { codes: measured.p999, bytes: measured.bytes_moved };
        let alone = singles(&space.sizes()).into_iter().skip(1);
        let Some(exact) = self.known.get(&space.most_accurate()) else { return Vec::new() };
        let figures = alone.filter_map(|choice| Some((space.key(&choice), self.known.get(&choice)?)));
        figures.filter_map(|(change, found)| sentence(&change, traded(exact), traded(found))).collect()
    }

    /// The best choice for a target, with measured figures. They are beyond the target if no choice meets it.
    pub(super) fn find(&mut self, target: TuneTarget) -> Result<(Vec<usize>, Confirmed), LabError> {
        let before = self.steps.done();
        let mut left = max_choices(&self.measurer.space.sizes());
        let most = left + MAX_CONFIRMATIONS;
        let (mut limit, mut confirmations) = (target, 0);
        let found = loop {
            let (choice, seen) = self.search(limit, &mut left)?;
            let confirmed = self.confirmed(&choice, &seen)?;
            confirmations += 1;
            limit = match (target, limit) {
                _ if target.is_met(&confirmed.measured) || confirmations == MAX_CONFIRMATIONS => {
                    break (choice, confirmed);
                }
                (TuneTarget::Error(codes), TuneTarget::Error(now))
                    if confirmations + 1 < MAX_CONFIRMATIONS && limit.is_met(&seen) =>
                {
                    // Less by what the other pictures exceed the goal by, and at least another choice.
                    let within = now * codes / confirmed.measured.claimed_p999();
                    TuneTarget::Error(within.min(LESS * seen.claimed_p999()))
                }
                (TuneTarget::Error(_), TuneTarget::Error(_)) => TuneTarget::MostAccurate,
                _ => break (choice, confirmed),
            };
        };
        self.steps.end_part(before, most);
        Ok(found)
    }

    /// The best choice for a target on the pictures that the search sees; at most `left` choices are measured.
    fn search(&mut self, target: TuneTarget, left: &mut u64) -> Result<Candidate, LabError> {
        if target == TuneTarget::MostAccurate {
            let exact = self.measurer.space.most_accurate();
            let figures = self.measured(&exact)?;
            return Ok((exact, figures));
        }
        let sizes = self.measurer.space.sizes();
        let mut known = self.known.clone();
        let mut search = Search { sizes: &sizes, target, known: &mut known };
        search.best(&mut |choice| {
            if *left == 0 {
                return Ok(None);
            }
            *left -= 1;
            self.measured(choice).map(Some)
        })
    }

    /// The figures of a choice on all pictures, new or from the state.
    fn confirmed(&mut self, choice: &[usize], seen: &Measured) -> Result<Confirmed, LabError> {
        let name = self.measurer.space.key(choice);
        if let Some(known) = self.state.confirmed(&name) {
            return Ok(known);
        }
        let Self { measurer, steps, .. } = self;
        let confirmed = steps.run(&name, || measurer.confirmed(choice, seen))?;
        self.state.confirm(name, confirmed.clone())?;
        Ok(confirmed)
    }

    /// The figures of a choice, new or from the state. A search that continues from a state takes them only where the
    /// first one did, so that it goes the same way.
    fn measured(&mut self, choice: &[usize]) -> Result<Measured, LabError> {
        if let Some(known) = self.known.get(choice) {
            return Ok(*known);
        }
        let name = self.measurer.space.key(choice);
        let measured = match self.state.measured(&name) {
            Some(known) => known,
            None => {
                let Self { measurer, steps, .. } = self;
                let measured = steps.run(&name, || measurer.measured(choice))?;
                self.state.insert(name, measured)?;
                measured
            }
        };
        self.known.insert(choice.to_vec(), measured);
        Ok(measured)
    }
}
