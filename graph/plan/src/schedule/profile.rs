//! Bytes that live at each place of an order.

/// Numbers in a row: adds to ranges and finds the most of a prefix, each in logarithmic time (a segment tree).
pub(super) struct Profile {
    leaves: usize,
    /// The most of each node's range, without what its ancestors add.
    most: Vec<i64>,
    /// The amount that each node adds to its whole range.
    plus: Vec<i64>,
}

/// Marks a place without a pass; far from overflow when bytes are added.
const NONE: i64 = i64::MIN / 4;

impl Profile {
    /// From the differences of neighbors.
    pub(super) fn new(steps: &[i64]) -> Self {
        let leaves = steps.len().next_power_of_two();
        let mut most = vec![NONE; 2 * leaves];
        let mut sum = 0;
        for (at, step) in steps.iter().enumerate() {
            sum += step;
            most[leaves + at] = sum;
        }
        for node in (1..leaves).rev() {
            most[node] = most[2 * node].max(most[2 * node + 1]);
        }
        Self { leaves, plus: vec![0; most.len()], most }
    }

    pub(super) fn add(&mut self, range: std::ops::Range<usize>, value: i64) {
        if !range.is_empty() && value != 0 {
            self.add_under(1, 0..self.leaves, &range, value);
        }
    }

    fn add_under(&mut self, node: usize, span: std::ops::Range<usize>, range: &std::ops::Range<usize>, value: i64) {
        if range.end <= span.start || span.end <= range.start {
            return;
        }
        if range.start <= span.start && span.end <= range.end {
            self.most[node] += value;
            self.plus[node] += value;
            return;
        }
        let middle = span.start.midpoint(span.end);
        self.add_under(2 * node, span.start..middle, range, value);
        self.add_under(2 * node + 1, middle..span.end, range, value);
        self.most[node] = self.most[2 * node].max(self.most[2 * node + 1]) + self.plus[node];
    }

    pub(super) fn remove(&mut self, at: usize) {
        self.add(at..at + 1, NONE);
    }

    /// The most of all places before `end`; far below zero if there are none.
    pub(super) fn most_before(&self, end: usize) -> i64 {
        self.most_under(1, 0..self.leaves, end)
    }

    fn most_under(&self, node: usize, span: std::ops::Range<usize>, end: usize) -> i64 {
        if end <= span.start {
            return NONE;
        }
        if span.end <= end {
            return self.most[node];
        }
        let middle = span.start.midpoint(span.end);
        let (left, right) =
            (self.most_under(2 * node, span.start..middle, end), self.most_under(2 * node + 1, middle..span.end, end));
        left.max(right) + self.plus[node]
    }
}

#[cfg(test)]
mod tests {
    use afterimage_generators::Rng;

    use super::*;

    /// Against a list of numbers that is walked through.
    #[test]
    fn a_profile_is_a_list_of_numbers() {
        let mut rng = Rng::new(3);
        for count in [1, 2, 3, 5, 8, 13, 32, 33] {
            let steps: Vec<i64> = (0..count).map(|_| rng.below(100) as i64 - 40).collect();
            let sum = |sum: &mut i64, step: &i64| {
                *sum += step;
                Some(*sum)
            };
            let mut numbers: Vec<Option<i64>> = steps.iter().scan(0, sum).map(Some).collect();
            let mut profile = Profile::new(&steps);
            for _ in 0..60 {
                let (start, end) = (rng.below(count), rng.below(count + 1));
                let value = rng.below(50) as i64 - 20;
                if rng.per_cent(10) && numbers[start].is_some() {
                    profile.remove(start);
                    numbers[start] = None;
                } else {
                    profile.add(start..end, value);
                    let changed = numbers.iter_mut().take(end).skip(start).flatten();
                    changed.for_each(|number| *number += value);
                }
                for before in 0..=count {
                    let expected = numbers[..before].iter().flatten().max().copied();
                    let found = Some(profile.most_before(before)).filter(|most| *most > i64::MIN / 8);
                    assert_eq!(found, expected, "the most of the first {before} of {numbers:?}");
                }
            }
        }
    }
}
