//! The times of the last frames, and estimates that a few slow frames hardly change.

use std::collections::VecDeque;

/// Frames whose median is the load after a step.
pub(super) const NEWEST: usize = 3;
/// Frames whose median is the present time: 6 of them are over the budget before it is.
pub(super) const NOW: usize = 11;
/// Frames that a tier needs before its median is judged.
pub(super) const MIN_FRAMES: usize = 5;
/// Frames that a tier needs before a better one is taken, and for its cost to be known well.
pub(super) const STEADY_FRAMES: usize = 30;
/// Frames whose spread counts.
pub(super) const SPREAD_FRAMES: usize = 120;
/// Frames that are kept.
const MAX_FRAMES: usize = 600;
/// A change of the time by this share, and by more than noise, is a step.
const STEP: f64 = 0.1;
/// Frames of a block whose median is compared with those of others for a trend.
const TREND_FRAMES: usize = 30;
/// Half of the differences between two normal numbers are at most so many standard deviations.
const MEDIAN_DIFFERENCE: f64 = 0.9539;
/// The standard deviation of the median of many normal numbers, times the root of their count.
const MEDIAN_DEVIATION: f64 = 1.25;

/// Milliseconds of the last frames, the newest at the end.
#[derive(Clone, Debug)]
pub(super) struct Times(VecDeque<f64>);

impl Times {
    pub(super) fn new() -> Self {
        Self(VecDeque::with_capacity(MAX_FRAMES))
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Adds a frame. Those before a step are dropped: they say nothing of the present load.
    pub(super) fn push(&mut self, ms: f64) {
        if self.len() == MAX_FRAMES {
            self.0.pop_front();
        }
        self.0.push_back(ms);
        if self.len() >= NOW + STEADY_FRAMES {
            let (now, before) = (self.median(NOW), self.median_before(NOW, STEADY_FRAMES));
            if (now - before).abs() > STEP * before + 2.0 * self.deviation() {
                self.0.drain(..self.len() - MIN_FRAMES);
            }
        }
    }

    /// The last frames.
    fn last(&self, count: usize) -> impl Iterator<Item = f64> {
        self.0.iter().skip(self.len().saturating_sub(count)).copied()
    }

    /// All but those whose median is the present time.
    pub(super) fn earlier(&self) -> impl Iterator<Item = f64> {
        self.0.iter().rev().skip(NOW).copied()
    }

    /// How many frames are over a budget.
    pub(super) fn over(&self, budget: f64) -> usize {
        self.0.iter().filter(|ms| **ms > budget).count()
    }

    /// The shortest of the last frames.
    pub(super) fn least(&self, count: usize) -> f64 {
        self.last(count).fold(f64::INFINITY, f64::min)
    }

    /// The median of the last frames.
    pub(super) fn median(&self, count: usize) -> f64 {
        median(self.last(count))
    }

    /// The median of frames before the last ones.
    fn median_before(&self, last: usize, count: usize) -> f64 {
        median(self.0.iter().rev().skip(last).take(count).copied())
    }

    /// The standard deviation of the last frames, from the steps between neighbors: ramps and spikes hardly change it.
    pub(super) fn deviation(&self) -> f64 {
        let later = self.last(SPREAD_FRAMES).skip(1);
        median(self.last(SPREAD_FRAMES).zip(later).map(|(before, after)| (after - before).abs())) / MEDIAN_DIFFERENCE
    }

    /// How much the time changes within some frames, if it has risen or fallen steadily, and otherwise zero.
    pub(super) fn trend(&self, frames: f64) -> f64 {
        if self.len() < 3 * TREND_FRAMES {
            return 0.0;
        }
        let [newest, middle, oldest] = [0, 1, 2].map(|block| self.median_before(block * TREND_FRAMES, TREND_FRAMES));
        let (change, change_before) = (newest - middle, middle - oldest);
        let chance = 2.0 * MEDIAN_DEVIATION * self.deviation() * (2.0 / TREND_FRAMES as f64).sqrt();
        let is_rising = change.min(change_before) > chance;
        let is_falling = change.max(change_before) < -chance;
        // The newest median is half a block old.
        if is_rising || is_falling { change * (frames / TREND_FRAMES as f64 + 0.5) } else { 0.0 }
    }
}

/// The median of at most [`SPREAD_FRAMES`] numbers; zero of none.
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
