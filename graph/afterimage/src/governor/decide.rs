//! What the last frames decide.

use super::change::{TierChange, TierChangeReason};
use super::times::{MIN_FRAMES, NEWEST, NOW, SPREAD_FRAMES, STEADY_FRAMES};
use super::{COOL_DOWN, Governor, LASTING, MAX_MARGIN, MAX_SPIKE_WAIT, MAX_WAIT, MIN_MARGIN, MIN_SPIKE_WAIT};
use super::{SpikeTrial, TRIAL_FRAMES, Tier};

/// What the last frames take, in milliseconds.
#[derive(Clone, Copy, Debug)]
struct Estimate {
    /// The median of the last frames.
    now: f64,
    /// What 99 of 100 of these frames stay below, without spikes.
    high: f64,
    /// The same of more frames.
    steady: f64,
    /// How much the time changes within [`COOL_DOWN`], if it changes steadily.
    trend: f64,
}

/// Frames without a change before a tier is tried against what is known of it.
const PATIENT_FRAMES: usize = 180;
/// The share of frames that may be over the budget.
const MAX_SHARE_OVER: f64 = 0.01;
/// Fewer frames over the budget are chance.
const MIN_OVER: usize = 4;
/// Standard deviations that 99 of 100 frames stay below, and that all do but spikes.
const DEVIATIONS: f64 = 2.33;
const SPIKE_DEVIATIONS: f64 = 3.5;
/// A rise within this part of [`COOL_DOWN`] is soon.
const SOON: f64 = 1.0 / 8.0;
/// A tier whose time has risen by this factor has not failed: the load is another.
const RISEN: f64 = 1.1;
/// A tier that failed is taken at once if it is expected to take this part of the time then.
const CHEAPER: f64 = 0.9;
/// A tier is tried against what is known of it if the present one leaves this share of the budget.
const ROOM: f64 = 0.2;
/// A cost that was measured long ago may be wrong by this factor.
const MAX_DOUBTED: f64 = 1.25;

impl Governor {
    /// Judges the last frames.
    pub(super) fn decide(&mut self) -> Option<TierChange> {
        let estimate = self.estimate();
        if let Some((over, reason)) = self.over(&estimate) {
            return self.leave(over, reason, &estimate);
        }
        if self.is_trial {
            return None;
        }
        self.avoid_spikes(estimate.steady).or_else(|| self.improve(&estimate))
    }

    fn estimate(&self) -> Estimate {
        let (now, spread) = (self.times.median(NOW), DEVIATIONS * self.times.deviation());
        let steady = self.times.median(STEADY_FRAMES) + spread;
        Estimate { now, high: now + spread, steady, trend: self.times.trend(COOL_DOWN / self.dt) }
    }

    /// The time that is over the budget, if one is, and how.
    fn over(&self, estimate: &Estimate) -> Option<(f64, TierChangeReason)> {
        let frames = self.times.len();
        if self.is_trial && frames < STEADY_FRAMES {
            let least = self.times.least(TRIAL_FRAMES);
            return (least > self.budget).then_some((least, TierChangeReason::Over));
        }
        if estimate.now > self.budget && frames >= MIN_FRAMES {
            return Some((estimate.now, TierChangeReason::Over));
        }
        if frames < STEADY_FRAMES {
            return None;
        }
        let long = estimate.high - estimate.now + self.times.median(SPREAD_FRAMES / 2);
        if long > self.budget && is_often(self.times.over(self.budget), frames, 2.0) {
            return Some((long, TierChangeReason::Over));
        }
        let soon = estimate.high + SOON * estimate.trend;
        (estimate.trend > 0.0 && soon > self.budget).then_some((soon, TierChangeReason::Rising))
    }

    /// Leaves a tier that is over the budget for the best one that is not, or for the cheapest.
    fn leave(&mut self, over: f64, reason: TierChangeReason, estimate: &Estimate) -> Option<TierChange> {
        // Where the load has just stepped up, the newest frames have more of it.
        let newest = self.times.median(NEWEST).max(estimate.now);
        let high = estimate.high - estimate.now + newest + estimate.trend.max(0.0);
        let fitting =
            (0..self.tiers.len()).rev().find(|tier| self.is_way_out(*tier) && self.is_within(*tier, high, 0.0));
        let mut to = fitting.unwrap_or_else(|| self.cheapest());
        if self.cost(to) >= self.cost(self.tier) {
            // No tier is known to be cheaper. A worse one may be, if what was learned of it is wrong.
            to = self.tier.checked_sub(1)?;
            if self.times.len() < STEADY_FRAMES || self.clock < self.tiers[to].retry {
                return None;
            }
        }
        if self.clock - self.changed < LASTING && over < RISEN * self.first_ms {
            let clock = self.clock;
            let tier = &mut self.tiers[self.tier];
            (tier.failed, tier.retry) = (over, clock + tier.wait);
            tier.wait = (2.0 * tier.wait).min(MAX_WAIT);
            tier.margin = (tier.margin + MIN_MARGIN).min(MAX_MARGIN);
        }
        self.spikes.trial = None;
        Some(self.change(to, reason, over))
    }

    /// Tries a cheaper tier for spikes, and judges one that is tried.
    fn avoid_spikes(&mut self, steady: f64) -> Option<TierChange> {
        let (frames, over) = (self.times.len(), self.times.over(self.budget));
        let Some(SpikeTrial { from, share }) = self.spikes.trial else {
            let is_needed = |tier: usize| is_often(self.avoidable(tier), frames, 1.5);
            if self.clock < self.spikes.retry || !is_needed(self.tier) {
                return None;
            }
            let is_better = |tier: usize| self.is_way_out(tier) && self.cost(tier) < self.cost(self.tier);
            let to = (0..self.tiers.len()).rev().find(|tier| is_better(*tier) && !is_needed(*tier))?;
            self.spikes.trial = Some(SpikeTrial { from: self.tier, share: over as f64 / frames as f64 });
            return Some(self.change(to, TierChangeReason::Spikes, steady));
        };
        let expected = share * frames as f64;
        if over >= 3 && over as f64 >= 0.5 * expected {
            self.spikes.trial = None;
            self.spikes.follow_load = false;
            self.spikes.retry = self.clock + self.spikes.wait;
            self.spikes.wait = (2.0 * self.spikes.wait).min(MAX_SPIKE_WAIT);
            if self.is_within(from, steady, 0.0) {
                return Some(self.change(from, TierChangeReason::SpikesStay, steady));
            }
        } else if expected >= 6.0 {
            self.spikes.trial = None;
            self.spikes.follow_load = true;
            self.spikes.wait = MIN_SPIKE_WAIT;
        }
        None
    }

    /// Takes a better tier if the budget has room.
    fn improve(&mut self, estimate: &Estimate) -> Option<TierChange> {
        if self.times.len() < STEADY_FRAMES || self.spikes.trial.is_some() {
            return None;
        }
        let high = if estimate.trend < 0.0 { estimate.high } else { estimate.steady + estimate.trend };
        let better = self.tier + 1..self.tiers.len();
        if let Some(to) = better.clone().rev().find(|tier| self.is_known_to_fit(*tier, high)) {
            return Some(self.change(to, TierChangeReason::Room, high));
        }
        // What costs as much as a tier that is known to be over the budget is not tried.
        let mut least_over = f64::INFINITY;
        for to in better {
            if self.cost(to) >= least_over {
                continue;
            }
            if self.is_worth_a_trial(to, high) {
                if self.is_measured(to) {
                    self.tiers[to].doubt *= 2.0;
                }
                return Some(self.change(to, TierChangeReason::Trial, high));
            }
            if self.is_measured(to) {
                least_over = self.cost(to);
            }
        }
        None
    }

    /// Whether a tier has been tried here and would stay within the budget.
    fn is_known_to_fit(&self, tier: usize, high: f64) -> bool {
        let Tier { retry, failed, margin, .. } = self.tiers[tier];
        let may_retry = self.clock >= retry || self.expected(high, tier) < CHEAPER * failed;
        self.is_measured(tier) && may_retry && self.fits(tier, high, margin)
    }

    /// Whether a tier is worth a trial whose cost is not known here, or was measured long ago.
    fn is_worth_a_trial(&self, tier: usize, high: f64) -> bool {
        let Tier { measured, doubt, retry, .. } = self.tiers[tier];
        if self.clock < retry || high > self.budget {
            return false;
        }
        let has_room = high <= self.budget * (1.0 - ROOM) && self.times.len() >= PATIENT_FRAMES;
        if self.is_measured(tier) {
            has_room && self.clock - measured >= doubt && self.fits(tier, high / MAX_DOUBTED, 0.0)
        } else {
            self.fits(tier, high, MIN_MARGIN) || (has_room && self.fits(tier, high / self.costs.doubt(), 0.0))
        }
    }

    /// The time of a frame at another tier than the present one.
    fn expected(&self, ms: f64, tier: usize) -> f64 {
        self.costs.expected(ms, self.tier, tier)
    }

    fn is_within(&self, tier: usize, high: f64, margin: f64) -> bool {
        self.expected(high, tier) <= self.budget * (1.0 - margin)
    }

    /// Whether frames would stay within the budget at a tier, with their spikes if these follow the load.
    fn fits(&self, tier: usize, high: f64, margin: f64) -> bool {
        let spikes = if self.spikes.follow_load { self.avoidable(tier) } else { 0 };
        self.is_within(tier, high, margin) && spikes as f64 <= MAX_SHARE_OVER * self.times.len() as f64
    }

    /// Whether a tier may be taken because the present one is too slow: of better ones only what was measured.
    fn is_way_out(&self, tier: usize) -> bool {
        tier < self.tier || (tier > self.tier && self.is_measured(tier))
    }

    /// The cheapest way out, or the present tier.
    fn cheapest(&self) -> usize {
        let mut cheapest = self.tier;
        for tier in 0..self.tiers.len() {
            if self.is_way_out(tier) && self.cost(tier) < self.cost(cheapest) {
                cheapest = tier;
            }
        }
        cheapest
    }

    /// Spikes over the budget at a tier that the cheapest one would have kept, if they follow the load.
    fn avoidable(&self, tier: usize) -> usize {
        let cheapest = self.cheapest();
        let least = self.times.median(SPREAD_FRAMES) + SPIKE_DEVIATIONS * self.times.deviation();
        let is_over =
            |ms: f64| ms > least && self.expected(ms, tier) > self.budget && self.expected(ms, cheapest) <= self.budget;
        // The last frames may be a step of the load, which their median decides first.
        self.times.earlier().filter(|ms| is_over(*ms)).count()
    }
}

/// Whether so many of the frames are over the budget that it is no chance if one of a hundred may be. `deviations` of
/// chance are allowed.
fn is_often(over: usize, frames: usize, deviations: f64) -> bool {
    let expected = MAX_SHARE_OVER * frames as f64;
    over >= MIN_OVER && over as f64 > expected + deviations * expected.sqrt()
}
