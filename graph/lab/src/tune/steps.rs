//! Progress of a search: the measurements made, and the most that may follow.

use crate::{LabError, Progress};

/// The most choices for one goal that are measured on all pictures.
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

    pub(super) fn finish(&self) {
        self.progress.expect(self.done);
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::*;

    /// The numbers of steps that were expected, each with the number that was done then.
    #[derive(Default)]
    struct Expected(RefCell<Vec<(u64, u64)>>);

    impl Progress for Expected {
        fn expect(&self, steps: u64) {
            let mut all = self.0.borrow_mut();
            let done = all.len() as u64;
            all.push((done, steps));
        }
    }

    #[test]
    fn the_expected_number_falls_to_the_number_of_those_that_were_made() {
        let expected = Expected::default();
        let sizes = [3, 2];
        let mut steps = Steps::new(&expected, 2);
        steps.add(1);
        steps.add_search(&sizes);
        let singles = single_choices(&sizes);
        let goal = max_choices(&sizes) + MAX_CONFIRMATIONS;
        assert_eq!((singles, max_choices(&sizes)), (4, 8), "the most accurate choice, two and one cheaper ones");
        let run = |steps: &mut Steps<'_>, count: usize| {
            for _ in 0..count {
                steps.run("", || Ok(())).expect("nothing is measured");
            }
        };
        run(&mut steps, 1);
        for (made, most) in [(4, singles), (2, goal), (12, goal)] {
            let before = steps.done();
            run(&mut steps, made);
            steps.end_part(before, most);
        }
        steps.finish();
        let expected = expected.0.into_inner();
        assert_eq!(expected.first(), Some(&(0, 1 + 4 + 2 * 12)));
        assert_eq!(expected.last(), Some(&(19, 19)));
        assert!(expected.is_sorted_by(|a, b| a.1 >= b.1), "{expected:?}");
        assert!(expected[..19].iter().all(|(done, steps)| done < steps), "{expected:?}");
    }

    #[test]
    fn a_step_that_fails_is_not_done() {
        let mut steps = Steps::new(&(), 1);
        steps.add(2);
        assert!(steps.run("", || Err::<(), _>(LabError::request("no image"))).is_err());
        assert_eq!(steps.done(), 0);
    }
}
