//! The choice of a quality tier from measured GPU times.

use std::collections::VecDeque;
use std::fmt;

/// Chooses the most expensive tier whose frames stay within a budget.
///
/// It knows what each tier costs relative to the others and learns from every change. The load is the time of a frame
/// over the cost of its tier: what the scene, the resolution and the clock of the device make of one unit. A tier is
/// taken when the highest loads of the last half second would stay within the budget there, and left when the present
/// ones do not. There is at most one change a second.
///
/// It has no clock and no device: the host measures how long each frame took on the GPU. Times that come a few frames
/// late are good enough. The host applies what it returns, for example with [`Post::change`](crate::Post::change).
#[derive(Clone, Debug)]
pub struct Governor {
    budget: f64,
    costs: Vec<f64>,
    tier: usize,
    /// Loads of the last frames at this tier, the newest at the end.
    loads: VecDeque<f64>,
    /// Whether each of the last frames was over the budget.
    over: VecDeque<bool>,
    /// Seconds since the last change.
    since_change: f64,
    /// Seconds for which a more expensive tier is not tried: longer after one that did not last.
    patience: f64,
    /// The load before the last change, to learn from what comes after.
    before: Option<f64>,
}

/// A change of tier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TierChange {
    /// The tier before.
    pub from: usize,
    /// The tier from now on.
    pub to: usize,
    /// Milliseconds of frames at the tier before: the median of the last ones when it is left, the highest when a more
    /// expensive one is taken.
    pub ms: f64,
    /// Milliseconds that are expected at the new tier.
    pub expected_ms: f64,
    /// The budget in milliseconds.
    pub budget_ms: f64,
}

impl fmt::Display for TierChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { from, to, ms, expected_ms, budget_ms } = self;
        let why = if to < from { "over" } else { "within" };
        write!(f, "tier {from} to {to}: {ms:.2} ms, {why} {budget_ms:.2}; {expected_ms:.2} ms expected")
    }
}

/// Frames whose median is the present load.
const NOW: usize = 5;
/// Frames whose highest load counts: half a second.
const WINDOW: usize = 30;
/// Frames after a change whose times may belong to the tier before.
const LATE: usize = 3;
/// Of this many frames, [`MAX_OVER`] may be over the budget.
const OVER_WINDOW: usize = 120;
const MAX_OVER: usize = 2;
/// Seconds between two changes.
const COOL_DOWN: f64 = 1.0;
/// A more expensive tier must leave this share of the budget.
const MARGIN: f64 = 0.03;

impl Governor {
    /// A governor that begins with the cheapest tier. `costs` are what the tiers cost relative to each other, cheapest
    /// first, as `afterimage bench` measures them.
    ///
    /// # Panics
    /// There is no tier, a cost or the budget is not above zero, or the costs fall.
    pub fn new(budget_ms: f64, costs: &[f64]) -> Self {
        assert!(!costs.is_empty() && costs.iter().chain([&budget_ms]).all(|number| *number > 0.0), "there are costs");
        assert!(costs.is_sorted(), "the cheapest tier comes first");
        let (loads, over) = (VecDeque::with_capacity(WINDOW), VecDeque::with_capacity(OVER_WINDOW));
        let costs = costs.to_vec();
        Self { budget: budget_ms, costs, tier: 0, loads, over, since_change: COOL_DOWN, patience: 0.0, before: None }
    }

    /// The tier that frames should have.
    pub fn tier(&self) -> usize {
        self.tier
    }

    /// What the tiers cost relative to each other, as far as it is known.
    pub fn costs(&self) -> &[f64] {
        &self.costs
    }

    /// Sets the budget in milliseconds.
    pub fn set_budget(&mut self, budget_ms: f64) {
        self.budget = budget_ms;
        self.over.clear();
    }

    /// Takes the GPU time of a frame at the present tier, and the seconds since the frame before. Times that are not
    /// finite or not above zero are ignored.
    pub fn frame(&mut self, ms: f64, dt: f64) -> Option<TierChange> {
        self.since_change += dt.clamp(0.0, 1.0);
        self.patience = (self.patience - dt.clamp(0.0, 1.0)).max(0.0);
        if !ms.is_finite() || ms <= 0.0 {
            return None;
        }
        push(&mut self.loads, ms / self.costs[self.tier], WINDOW + LATE);
        push(&mut self.over, ms > self.budget, OVER_WINDOW);
        if self.loads.len() < LATE + NOW {
            return None;
        }
        self.learn();
        if self.since_change < COOL_DOWN {
            return None;
        }
        let (now, highest) = (self.now(), self.highest());
        let many_over = self.over.iter().filter(|over| **over).count() > MAX_OVER;
        if now * self.costs[self.tier] > self.budget || (many_over && highest * self.costs[self.tier] > self.budget) {
            return self.move_to(self.fitting(highest.max(now), 0.0).min(self.tier.saturating_sub(1)), now);
        }
        let better = self.fitting(highest, MARGIN);
        let is_ready = self.loads.len() == WINDOW + LATE && self.patience == 0.0;
        if better > self.tier && is_ready { self.move_to(better, highest) } else { None }
    }

    /// The most expensive tier that leaves a share of the budget at this load; the cheapest if none does.
    fn fitting(&self, load: f64, margin: f64) -> usize {
        self.costs.iter().rposition(|cost| load * cost <= self.budget * (1.0 - margin)).unwrap_or(0)
    }

    /// The median load of the last frames.
    fn now(&self) -> f64 {
        median(self.loads.iter().rev().take(NOW))
    }

    /// The load that all but one of the last frames stay below. One alone is a spike.
    fn highest(&self) -> f64 {
        let mut loads: Vec<f64> = self.loads.iter().skip(LATE).copied().collect();
        loads.sort_by(f64::total_cmp);
        loads[loads.len().saturating_sub(2)]
    }

    fn move_to(&mut self, to: usize, load: f64) -> Option<TierChange> {
        if to == self.tier {
            return None;
        }
        let (from, ms) = (self.tier, load * self.costs[self.tier]);
        if to < from {
            // It did not last: wait longer before it is tried again.
            let lasted = self.since_change;
            self.patience = if lasted < 4.0 { 8.0 - lasted } else { 1.0 };
        }
        self.before = Some(self.now());
        (self.tier, self.since_change) = (to, 0.0);
        self.loads.clear();
        self.over.clear();
        Some(TierChange { from, to, ms, expected_ms: load * self.costs[to], budget_ms: self.budget })
    }

    /// Corrects the cost of a new tier once, from the load before it and the load that its frames seem to have.
    fn learn(&mut self) {
        if self.loads.len() < LATE + 2 * NOW {
            return;
        }
        let Some(before) = self.before.take() else { return };
        let seen = median(self.loads.iter().skip(LATE));
        // The load may have changed itself, so a correction is a part of the difference.
        let correction = (seen / before).clamp(0.5, 2.0).powf(0.25);
        let below = if self.tier == 0 { 0.0 } else { self.costs[self.tier - 1] };
        let above = self.costs.get(self.tier + 1).copied().unwrap_or(f64::INFINITY);
        self.costs[self.tier] = (self.costs[self.tier] * correction).clamp(below, above);
    }
}

fn push<T>(queue: &mut VecDeque<T>, value: T, most: usize) {
    if queue.len() == most {
        queue.pop_front();
    }
    queue.push_back(value);
}

fn median<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    let mut values: Vec<f64> = values.copied().collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
