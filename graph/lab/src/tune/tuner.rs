//! The search for one goal after another, with all that it knows.

use std::collections::BTreeMap;

use super::measurer::{ClipMeasurer, Confirmed, worst};
use super::search::{Candidate, Measured, TuneTarget, best_of, search};
use super::space::singles;
use super::state::SearchState;
use super::steps::Steps;
use crate::LabError;

/// An error that the search relied on, beside what it is: 99.9th percentiles, in codes.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// The switches that are not at their most accurate.
    pub choice: String,
    pub predicted: f64,
    pub measured: f64,
}

/// A measured error may exceed the predicted one by this factor and this number of codes.
const MAX_EXCESS: f64 = 1.2;
const MIN_EXCESS_CODES: f64 = 0.05;
/// A measured time may exceed the predicted one by this factor.
const MAX_SLOWDOWN: f64 = 1.05;
/// After a choice that other pictures refuse, the search stays below this share of its error.
const LESS: f64 = 0.9;
/// The sum of what switches save alone can be more than there is: at least this share of the time is left.
const MIN_SHARE: f64 = 0.05;

/// A search with all that it knows.
pub(super) struct Tuner<'a> {
    pub(super) measurer: ClipMeasurer<'a>,
    pub(super) state: SearchState,
    /// The choices that this search has measured, or taken from the state.
    known: BTreeMap<Vec<usize>, Measured>,
    pub(super) steps: Steps<'a>,
    pub(super) predictions: Vec<Prediction>,
}

impl<'a> Tuner<'a> {
    pub(super) fn new(measurer: ClipMeasurer<'a>, state: SearchState, steps: Steps<'a>) -> Self {
        Self { measurer, state, known: BTreeMap::new(), steps, predictions: Vec::new() }
    }

    /// The best choice for a target, with measured figures. They are beyond the target if no choice meets it.
    pub(super) fn find(&mut self, target: TuneTarget) -> Result<(Vec<usize>, Confirmed), LabError> {
        let mut limit = target;
        let found = loop {
            let (choice, seen) = self.search(limit)?;
            let left = self.steps.take_confirmation();
            let confirmed = self.confirmed(&choice, &seen)?;
            limit = match (target, limit) {
                _ if target.is_met(&confirmed.measured) || left == 0 => break (choice, confirmed),
                (TuneTarget::Error(codes), TuneTarget::Error(now)) if left > 1 && limit.is_met(&seen) => {
                    // Less by what the other pictures exceed the goal by, and at least another choice.
                    let within = now * codes / confirmed.measured.claimed_p999();
                    TuneTarget::Error(within.min(LESS * seen.claimed_p999()))
                }
                (TuneTarget::Error(_), _) => TuneTarget::MostAccurate,
                _ => break (choice, confirmed),
            };
        };
        self.steps.end_goal();
        self.state.write()?;
        Ok(found)
    }

    /// The best choice for a target on the pictures that the search sees.
    fn search(&mut self, target: TuneTarget) -> Result<Candidate, LabError> {
        if target == TuneTarget::MostAccurate {
            let exact = self.measurer.space.most_accurate();
            let figures = self.figures(&exact)?;
            return Ok((exact, figures));
        }
        let sizes = self.measurer.space.sizes();
        loop {
            let (choice, found) = search(&sizes, target, &mut |choice| self.figures(choice))?;
            if !found.is_predicted {
                return Ok((choice, found));
            }
            if !self.steps.take_finalist() {
                let known: Vec<Candidate> = self.known.iter().map(|(choice, known)| (choice.clone(), *known)).collect();
                return Ok(best_of(&known, target));
            }
            let measured = self.measured(&choice, 1)?;
            let name = self.measurer.space.key(&choice);
            self.predictions.push(Prediction { choice: name, predicted: found.p999, measured: measured.p999 });
            let is_as_predicted =
                measured.p999 <= MAX_EXCESS * found.p999 + MIN_EXCESS_CODES && measured.ms <= MAX_SLOWDOWN * found.ms;
            if is_as_predicted && target.is_met(&measured) {
                return Ok((choice, measured));
            }
        }
    }

    /// The figures of a choice on all pictures, new or from the state.
    fn confirmed(&mut self, choice: &[usize], seen: &Measured) -> Result<Confirmed, LabError> {
        let name = self.measurer.space.key(choice);
        if let Some(known) = self.state.confirmed(&name) {
            return Ok(known);
        }
        let Self { measurer, steps, .. } = self;
        let confirmed = steps.run(&name, 1 + measurer.parts_left(), || measurer.confirmed(choice, seen))?;
        self.state.confirm(name, confirmed.clone())?;
        Ok(confirmed)
    }

    /// The figures of a choice: known, measured if it changes at most one switch, or predicted.
    fn figures(&mut self, choice: &[usize]) -> Result<Measured, LabError> {
        if let Some(known) = self.known.get(choice) {
            return Ok(*known);
        }
        let singles = singles(choice);
        if singles.len() < 2 {
            return self.measured(choice, 0);
        }
        for single in singles {
            self.figures(&single)?;
        }
        let name = self.measurer.space.key(choice);
        let errors = match self.state.predicted(&name) {
            Some(known) => known,
            None => {
                let errors = self.predicted_errors(choice)?;
                self.state.predict(name, errors);
                errors
            }
        };
        Ok(Measured { ms: predicted_ms(&self.known, choice), ..errors })
    }

    /// The measured figures of a choice, new or from the state. A search that continues from a state takes them only
    /// where the first one did, so that it goes the same way. `finalist` is the step's part of what is left, beside
    /// that of parts of predictions.
    fn measured(&mut self, choice: &[usize], finalist: u64) -> Result<Measured, LabError> {
        let name = self.measurer.space.key(choice);
        let measured = match self.state.measured(&name) {
            Some(known) => known,
            None => {
                let Self { measurer, steps, .. } = self;
                let measured = steps.run(&name, finalist + measurer.parts_left(), || measurer.measured(choice))?;
                self.state.insert(name, measured)?;
                measured
            }
        };
        self.known.insert(choice.to_vec(), measured);
        Ok(measured)
    }

    fn predicted_errors(&mut self, choice: &[usize]) -> Result<Measured, LabError> {
        let Self { measurer, steps, .. } = self;
        // A state has figures, and no images.
        for part in measurer.missing_parts(choice) {
            let name = measurer.space.key(&part);
            steps.run(&name, measurer.parts_left(), || measurer.measured_errors(&part))?;
        }
        Ok(Measured { is_predicted: true, ..worst(&measurer.predicted_errors(choice)) })
    }
}

/// The time of a choice of several switches: that of the known choice that differs in the fewest, and what each of
/// these saves or costs alone.
fn predicted_ms(known: &BTreeMap<Vec<usize>, Measured>, choice: &[usize]) -> f64 {
    let differing = |from: &[usize]| (0..choice.len()).filter(|at| from[*at] != choice[*at]).collect::<Vec<_>>();
    let (near, figures) =
        known.iter().min_by_key(|(near, _)| differing(near).len()).expect("its single switches are known");
    let alone = |switch: usize, at: usize| {
        let mut single = vec![0; choice.len()];
        single[switch] = at;
        known.get(&single).map_or(figures.ms, |single| single.ms)
    };
    let change: f64 =
        differing(near).into_iter().map(|switch| alone(switch, choice[switch]) - alone(switch, near[switch])).sum();
    (figures.ms + change).max(MIN_SHARE * figures.ms)
}
