//! The number of measurements that are made, and the most that may follow.

use crate::{LabError, Progress};

/// How often what was found for a goal is measured on all pictures at most.
pub(super) const MAX_CONFIRMATIONS: u64 = 4;

/// The most choices of several switches that the search for one goal measures.
pub(super) fn max_choices(sizes: &[usize]) -> u64 {
    4 + 2 * sizes.len() as u64
}

/// The number of choices of at most one switch.
pub(super) fn single_choices(sizes: &[usize]) -> u64 {
    1 + sizes.iter().map(|size| *size as u64 - 1).sum::<u64>()
}

/// Reports each measurement. The number that is expected never grows, and in the end it is the number of those that
/// were made.
pub(super) struct Steps<'p> {
    progress: &'p dyn Progress,
    goals: u64,
    done: u64,
    /// The most that may follow.
    left: u64,
}

impl<'p> Steps<'p> {
    pub(super) fn new(progress: &'p dyn Progress, goals: u64) -> Self {
        Self { progress, goals, done: 0, left: 0 }
    }

    /// Expects so many more. All are added before the first is made.
    pub(super) fn add(&mut self, steps: u64) {
        self.left += steps;
    }

    /// Expects the search for all goals among switches with these numbers of choices.
    pub(super) fn add_search(&mut self, sizes: &[usize]) {
        self.add(single_choices(sizes) + self.goals * (max_choices(sizes) + MAX_CONFIRMATIONS));
    }

    pub(super) fn done(&self) -> u64 {
        self.done
    }

    /// No longer expects what is left of `most` steps, the first of which followed after `before` others.
    pub(super) fn end_part(&mut self, before: u64, most: u64) {
        self.left -= most - (self.done - before);
    }

    pub(super) fn run<T>(&mut self, name: &str, step: impl FnOnce() -> Result<T, LabError>) -> Result<T, LabError> {
        self.progress.expect(self.done + self.left);
        self.progress.begin(name);
        let result = step()?;
        self.done += 1;
        self.left -= 1;
        self.progress.end();
        Ok(result)
    }

    /// All is done.
    pub(super) fn finish(&self) {
        self.progress.expect(self.done);
    }
}
