//! The times of the last frames at a tier, and estimates that a few slow frames hardly change.

use std::collections::VecDeque;

/// Frames whose median is the present time: 6 of them are over the budget before it is.
pub(super) const NOW: usize = 11;
/// Frames that a tier needs before its median is judged.
pub(super) const MIN_FRAMES: usize = 5;
/// Frames that a tier needs before a better one is taken.
pub(super) const STEADY_FRAMES: usize = 30;
/// Frames whose spread counts.
pub(super) const SPREAD_FRAMES: usize = 120;
/// Frames that are kept.
const MAX_FRAMES: usize = 600;
/// A change of the time by this share, and by more than noise, is a step.
const STEP: f64 = 0.1;
/// Half of the differences between two normal numbers are at most so many standard deviations.
const MEDIAN_DIFFERENCE: f64 = 0.9539;
/// The standard deviation of the median of many normal numbers, times the root of their count.
const MEDIAN_DEVIATION: f64 = 1.25;

/// Milliseconds of the last frames, the newest at the front.
#[derive(Clone, Debug, Default)]
pub(super) struct Times(VecDeque<f64>);

impl Times {
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Adds a frame. Those before a step are dropped: they say nothing of the present load.
    pub(super) fn push(&mut self, ms: f64) {
        self.0.truncate(MAX_FRAMES - 1);
        self.0.push_front(ms);
        let (now, before) = (self.median(0, NOW), self.median(NOW, STEADY_FRAMES));
        if self.len() >= NOW + STEADY_FRAMES && (now - before).abs() > STEP * before + 2.0 * self.deviation() {
            self.0.truncate(MIN_FRAMES);
        }
    }

    /// The number of frames over a budget.
    pub(super) fn over(&self, budget: f64) -> usize {
        self.0.iter().filter(|ms| **ms > budget).count()
    }

    /// All frames but those whose median is the present time.
    pub(super) fn earlier(&self) -> impl Iterator<Item = f64> {
        self.0.iter().skip(NOW).copied()
    }

    /// The shortest of the last frames.
    pub(super) fn least(&self, count: usize) -> f64 {
        self.0.iter().take(count).copied().fold(f64::INFINITY, f64::min)
    }

    /// The median of at most [`SPREAD_FRAMES`] frames before the newest ones; zero of none.
    pub(super) fn median(&self, newest: usize, count: usize) -> f64 {
        median(self.0.iter().skip(newest).take(count).copied())
    }

    /// The standard deviation of the last frames, from the steps between neighbors: ramps and spikes hardly change it.
    pub(super) fn deviation(&self) -> f64 {
        let steps = self.0.iter().zip(self.0.iter().skip(1)).take(SPREAD_FRAMES);
        median(steps.map(|(after, before)| (after - before).abs())) / MEDIAN_DIFFERENCE
    }

    /// The rise or fall of the time in [`STEADY_FRAMES`]; zero if that may be chance.
    pub(super) fn trend(&self) -> f64 {
        if self.len() < 3 * STEADY_FRAMES {
            return 0.0;
        }
        let [newest, middle, oldest] = [0, 1, 2].map(|block| self.median(block * STEADY_FRAMES, STEADY_FRAMES));
        let (change, before) = (newest - middle, middle - oldest);
        let chance = 2.0 * MEDIAN_DEVIATION * self.deviation() * (2.0 / STEADY_FRAMES as f64).sqrt();
        if change * before > 0.0 && change.abs().min(before.abs()) > chance { change } else { 0.0 }
    }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted = [0.0; SPREAD_FRAMES];
    let mut count = 0;
    for (to, value) in sorted.iter_mut().zip(values) {
        *to = value;
        count += 1;
    }
    if count == 0 {
        return 0.0;
    }
    *sorted[..count].select_nth_unstable_by(count / 2, f64::total_cmp).1
}
