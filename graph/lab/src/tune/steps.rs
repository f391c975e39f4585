//! How far a search is: the measurements that are done, and at most how many are left.

use crate::{LabError, Progress};

/// Finalists of a goal that are measured at most; then the best of all that are measured is taken.
const MAX_FINALISTS: u64 = 8;
/// How often what was found for a goal is measured on all pictures at most.
const MAX_CONFIRMATIONS: u64 = 4;

/// Tells a bar of each measurement. The number that it expects never grows, and in the end it is the number of those
/// that were made.
pub(super) struct Steps<'p> {
    progress: &'p dyn Progress,
    done: u64,
    /// Goals that are not reached yet, with the present one.
    goals: u64,
    /// Finalists of the present goal that may be measured.
    finalists: u64,
    /// Choices for the present goal that may be measured on all pictures.
    confirmations: u64,
    /// Steps after the search.
    last: u64,
}

impl<'p> Steps<'p> {
    /// A search for so many goals, and what follows it.
    pub(super) fn new(progress: &'p dyn Progress, goals: u64, last: u64) -> Self {
        Self { progress, done: 0, goals, finalists: MAX_FINALISTS, confirmations: MAX_CONFIRMATIONS, last }
    }

    /// A step. `left` is the most that may follow, with this one, beside those that are counted here.
    pub(super) fn run<T>(
        &mut self,
        name: &str,
        left: u64,
        step: impl FnOnce() -> Result<T, LabError>,
    ) -> Result<T, LabError> {
        let of_goals = match self.goals {
            0 => 0,
            goals => self.finalists + self.confirmations + (goals - 1) * (MAX_FINALISTS + MAX_CONFIRMATIONS),
        };
        self.progress.expect(self.done + left + of_goals + self.last);
        self.progress.begin(name);
        let result = step()?;
        self.done += 1;
        self.progress.end();
        Ok(result)
    }

    /// Whether the present goal may have one finalist more, which is counted.
    pub(super) fn take_finalist(&mut self) -> bool {
        let may = self.finalists > 0;
        self.finalists = self.finalists.saturating_sub(1);
        may
    }

    /// A choice for the present goal is measured on all pictures, which is counted. How many more may be.
    pub(super) fn take_confirmation(&mut self) -> u64 {
        self.confirmations -= 1;
        self.confirmations
    }

    /// The present goal is reached, or out of reach.
    pub(super) fn end_goal(&mut self) {
        self.goals -= 1;
        self.finalists = MAX_FINALISTS;
        self.confirmations = MAX_CONFIRMATIONS;
    }

    /// So many steps of [`Self::run_last`] are left.
    pub(super) fn expect_last(&mut self, steps: u64) {
        self.last = steps;
    }

    /// A step after the search, or beside it; `left` is as in [`Self::run`].
    pub(super) fn run_last<T>(
        &mut self,
        name: &str,
        left: u64,
        step: impl FnOnce() -> Result<T, LabError>,
    ) -> Result<T, LabError> {
        let result = self.run(name, left, step)?;
        self.last -= 1;
        Ok(result)
    }

    /// All is done.
    pub(super) fn finish(&self) {
        self.progress.expect(self.done);
    }
}
