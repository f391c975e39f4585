//! The choice of a quality tier from measured GPU times.

mod change;
mod limits;
mod times;

pub use change::{TierChange, TierChangeReason};
pub use limits::{Shortfall, TierLimits};
use times::{MIN_FRAMES, NOW, SPREAD_FRAMES, STEADY_FRAMES, Times};

/// A tier that a [`Governor`] may choose.
#[derive(Clone, Debug, PartialEq)]
pub struct GovernedTier {
    /// Its name in the pipeline file.
    pub name: String,
    /// Its cost relative to the others, as `afterimage bench` measures it on any device. `None`, or a number that is
    /// not above zero, if nobody knows.
    pub cost: Option<f64>,
    /// Its claim in JOD for the display of the limits, if it has one.
    pub jod: Option<f64>,
}

/// Chooses the best tier whose frames stay within a budget, among those whose claims reach the
/// [floor](TierLimits::min_jod), if there is one. Where these are all too dear, the [shortfall](Self::shortfall) says
/// so.
///
/// Medians and the spread between neighbors judge a tier, so a few slow frames are spikes and no load. The first frames
/// after a change show what the new tier costs relative to the one before. A tier that was not tried is tried when the
/// budget has room for it, and left after a few frames over the budget. One that did not last is taken again after a
/// wait, which doubles each time, or when it is expected to take clearly less.
///
/// If more than one frame of a hundred is over the budget for its spikes, a cheaper tier is tried. Where they stay, no
/// tier can avoid them: the better one returns.
///
/// Two changes are at least two seconds apart, but a tier that was tried may be left at once.
///
/// It has no clock and no device: the host measures each frame on the GPU, the pipeline alone or with all else that the
/// budget is for. Times may arrive with latency, because each comes with the tier of its frame.
/// [`Post::govern`](crate::Post::govern) does all of this for a pipeline.
#[derive(Clone, Debug)]
pub struct Governor {
    limits: TierLimits,
    /// Those that may be chosen.
    tiers: Vec<Tier>,
    tier: usize,
    /// The tier before the last change, and its time then. It is the present one if the change has been learned from.
    before: usize,
    before_ms: f64,
    times: Times,
    /// Frames at this tier whose times do not count yet.
    settling: usize,
    /// Seconds in which frames came.
    clock: f64,
    /// The time of the first frame of this tier.
    changed: f64,
    /// `true` while this tier may be left at once.
    is_trial: bool,
    spikes: Spikes,
    /// Milliseconds over the budget with which the tier stays, because there is no cheaper one.
    over: Option<f64>,
}

#[derive(Clone, Debug)]
struct Tier {
    name: String,
    jod: Option<f64>,
    /// Relative costs, as changes to worse and to better tiers have shown them. A part of each frame is the same at all
    /// tiers, so under the high load at which a tier is left, they differ by another factor than under a low one.
    costs: [f64; 2],
    is_measured: bool,
    /// The time before which it is not taken, unless it is expected to take less than when it failed.
    retry: f64,
    /// Milliseconds when it failed.
    failed: f64,
    /// Seconds to wait when it fails the next time.
    wait: f64,
}

/// Knowledge of frames that are slow now and then.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Spikes {
    Unknown,
    /// A cheaper tier than this is tried because of them. They had this share of the frames.
    Tried(usize, f64),
    /// A cheaper tier has avoided them.
    Avoidable,
    /// A cheaper tier has not avoided them. None is tried before this time.
    Stay(f64),
}

/// The factor between a tier of unknown cost and the next worse one.
const GUESSED_STEP: f64 = 1.35;
/// The first frames of a plan wait for memory and compiled code.
const SETTLING_FRAMES: usize = 2;
/// Frames in a row over the budget after which a trial has failed.
const TRIAL_FRAMES: usize = 3;
/// Frames without a change before a tier is tried whatever it is guessed to cost.
const PATIENT_FRAMES: usize = 180;
/// Seconds between two changes.
const COOL_DOWN: f64 = 2.0;
/// Seconds at a tier after which it has lasted.
const LASTING: f64 = 8.0;
/// The share of the budget that a better tier must leave, and the present one for a trial of unknown cost.
const MARGIN: f64 = 0.04;
const ROOM: f64 = 0.2;
/// Seconds before a tier that failed is taken again, the first time and at most.
const MIN_WAIT: f64 = 4.0;
const MAX_WAIT: f64 = 128.0;
/// Seconds before a cheaper tier is tried again for spikes that it has not avoided.
const SPIKES_WAIT: f64 = 60.0;
/// Standard deviations that 99 of 100 frames stay below.
const DEVIATIONS: f64 = 2.33;
/// The share of frames that may be over the budget. Fewer than [`MIN_OVER`] are chance.
const MAX_SHARE_OVER: f64 = 0.01;
const MIN_OVER: usize = 4;
/// [Trends](Times::trend) until frames are soon over the budget, and within [`COOL_DOWN`].
const SOON: f64 = 0.5;
const TRENDS: f64 = 4.5;
/// A tier that failed is taken at once if it is expected to take this part of the time then.
const CHEAPER: f64 = 0.9;

impl Governor {
    /// A governor of milliseconds, or of other [limits](TierLimits), for these tiers, in order from the worst picture
    /// to the best. It begins with the first that reaches the floor, which should be the cheapest one.
    ///
    /// # Panics
    /// There is no tier.
    pub fn new(limits: impl Into<TierLimits>, tiers: &[GovernedTier]) -> Self {
        assert!(!tiers.is_empty(), "a governor has tiers to choose from");
        let limits = limits.into();
        let mut cost = 1.0 / GUESSED_STEP;
        let of = |tier: &GovernedTier| {
            cost = tier.cost.filter(|cost| cost.is_finite() && *cost > 0.0).unwrap_or(GUESSED_STEP * cost);
            let (name, jod, costs) = (tier.name.clone(), tier.jod, [cost; 2]);
            Tier { name, jod, costs, is_measured: false, retry: 0.0, failed: f64::INFINITY, wait: MIN_WAIT }
        };
        let tiers = reaching(tiers, limits.min_jod).into_iter().map(of).collect();
        Self {
            limits,
            tiers,
            tier: 0,
            before: 0,
            before_ms: 0.0,
            times: Times::default(),
            settling: SETTLING_FRAMES,
            clock: 0.0,
            changed: -COOL_DOWN,
            is_trial: false,
            spikes: Spikes::Unknown,
            over: None,
        }
    }

    /// The index among [`names`](Self::names) of the tier that frames should have.
    pub fn tier(&self) -> usize {
        self.tier
    }

    /// The name of that tier.
    pub fn name(&self) -> &str {
        &self.tiers[self.tier].name
    }

    /// The names of the tiers that may be chosen, from the worst picture to the best.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.tiers.iter().map(|tier| tier.name.as_str())
    }

    /// The cost of a tier relative to the others, as far as it is known.
    pub fn cost(&self, tier: usize) -> f64 {
        self.tiers[tier].costs[0]
    }

    /// The limits.
    pub fn limits(&self) -> &TierLimits {
        &self.limits
    }

    /// Sets the budget in milliseconds.
    pub fn set_budget(&mut self, budget_ms: f64) {
        (self.limits.ms, self.over) = (budget_ms, None);
    }

    /// The reason why the limits are not held at present: no tier reaches the floor, or frames are over the budget at
    /// the cheapest that does. `None` if they are held.
    pub fn shortfall(&self) -> Option<Shortfall> {
        let Tier { name, jod, .. } = &self.tiers[self.tier];
        let TierLimits { ms: budget_ms, min_jod, .. } = self.limits;
        let shortfall = Shortfall { tier: name.clone(), jod: *jod, min_jod, ms: self.over, budget_ms };
        (shortfall.ms.is_some() || shortfall.is_of_quality()).then_some(shortfall)
    }

    /// Takes the GPU time of a frame in milliseconds, the tier that it was rendered with, and the seconds since the
    /// frame before. A time that is not finite or not above zero, and that of another tier than the
    /// [present](Self::tier) one, only lets the seconds pass. Returns the change that the next frame should have.
    pub fn frame(&mut self, tier: usize, ms: f64, dt: f64) -> Option<TierChange> {
        self.clock += if dt.is_nan() { 0.0 } else { dt.clamp(0.0, 1.0) };
        if tier != self.tier || !ms.is_finite() || ms <= 0.0 {
            return None;
        }
        if self.settling > 0 {
            if self.settling == SETTLING_FRAMES && self.before != self.tier {
                self.changed = self.clock;
            }
            self.settling -= 1;
            return None;
        }
        self.times.push(ms);
        self.learn();
        let since = self.clock - self.changed;
        if since >= LASTING {
            self.tiers[self.tier].wait = MIN_WAIT;
        }
        self.is_trial &= since < COOL_DOWN;
        let may_change = self.is_trial || since >= COOL_DOWN;
        if may_change && self.times.len() >= TRIAL_FRAMES { self.decide() } else { None }
    }

    /// States that the present tier cannot be rendered. Returns to the one before, and does not try this one for a
    /// while.
    pub fn refuse(&mut self) {
        let refused = &mut self.tiers[self.tier];
        (refused.retry, refused.failed) = (self.clock + MAX_WAIT, 0.0);
        self.tier = self.before;
        (self.is_trial, self.spikes, self.settling) = (false, Spikes::Unknown, SETTLING_FRAMES);
        self.times.clear();
    }

    /// Learns the cost of a new tier from its first frames, and again from more.
    fn learn(&mut self) {
        let frames = self.times.len();
        if self.before == self.tier || ![TRIAL_FRAMES, MIN_FRAMES, STEADY_FRAMES].contains(&frames) {
            return;
        }
        let direction = usize::from(self.tier > self.before);
        let ratio = self.times.median(0, STEADY_FRAMES) / self.before_ms;
        let factor = ratio * self.tiers[self.before].costs[direction] / self.tiers[self.tier].costs[direction];
        if self.tiers[self.tier].is_measured {
            self.tiers[self.tier].costs[direction] *= factor;
        } else {
            // Better tiers that were not tried are guessed relative to this one.
            for tier in self.tiers[self.tier..].iter_mut().filter(|tier| !tier.is_measured) {
                tier.costs = tier.costs.map(|cost| factor * cost);
            }
        }
        if frames == STEADY_FRAMES {
            for tier in [self.tier, self.before] {
                self.tiers[tier].is_measured = true;
            }
            self.before = self.tier;
        }
    }

    /// Judges the last frames.
    fn decide(&mut self) -> Option<TierChange> {
        let frames = self.times.len();
        let (now, spread, trend) = (self.times.median(0, NOW), DEVIATIONS * self.times.deviation(), self.times.trend());
        if self.is_trial && frames < STEADY_FRAMES {
            let least = self.times.least(TRIAL_FRAMES);
            return if least > self.limits.ms { self.leave(least) } else { None };
        }
        let rise = TRENDS * trend.max(0.0);
        if frames >= MIN_FRAMES && now > self.limits.ms {
            // Where the load has just stepped up, the newest frames have more of it.
            return self.leave(self.times.median(0, TRIAL_FRAMES).max(now) + spread + rise);
        }
        if frames < STEADY_FRAMES {
            return None;
        }
        if trend > 0.0 && now + spread + SOON * trend > self.limits.ms {
            return self.leave(now + spread + rise);
        }
        let long = self.times.median(0, SPREAD_FRAMES / 2) + spread;
        if long > self.limits.ms && self.is_often(self.times.over(self.limits.ms), 2.0) {
            return self.leave(long);
        }
        self.over = None;
        let steady = self.times.median(0, STEADY_FRAMES) + spread;
        if self.is_trial || steady + rise > self.limits.ms {
            return None;
        }
        self.avoid_spikes(steady).or_else(|| self.improve(steady + rise))
    }

    /// Leaves a tier that is over the budget for the best one that is not, or for the cheapest.
    fn leave(&mut self, high: f64) -> Option<TierChange> {
        let is_cheaper = |tier: &usize| self.cost(*tier) < self.cost(self.tier);
        let ways: Vec<usize> = (0..self.tiers.len())
            .filter(|tier| *tier < self.tier || self.tiers[*tier].is_measured)
            .filter(is_cheaper)
            .collect();
        let fitting = ways.iter().copied().rfind(|tier| self.expected(high, *tier) <= self.limits.ms);
        let cheapest = ways.into_iter().min_by(|a, b| self.cost(*a).total_cmp(&self.cost(*b)));
        // If no tier is known to be cheaper, a worse one may be whose cost is wrong.
        let Some(to) = fitting.or(cheapest).or(self.tier.checked_sub(1)) else {
            self.over = Some(high);
            return None;
        };
        if self.clock - self.changed < LASTING {
            let tier = &mut self.tiers[self.tier];
            (tier.failed, tier.retry) = (high, self.clock + tier.wait);
            tier.wait = (2.0 * tier.wait).min(MAX_WAIT);
        }
        if let Spikes::Tried(..) = self.spikes {
            self.spikes = Spikes::Unknown;
        }
        Some(self.change(to, TierChangeReason::Over, high))
    }

    /// Tries a cheaper tier for spikes, and judges one that is tried.
    fn avoid_spikes(&mut self, steady: f64) -> Option<TierChange> {
        let (over, frames) = (self.times.over(self.limits.ms), self.times.len() as f64);
        match self.spikes {
            Spikes::Tried(from, share) if over >= 3 && over as f64 >= 0.5 * share * frames => {
                self.spikes = Spikes::Stay(self.clock + SPIKES_WAIT);
                let returns = self.expected(steady, from) <= self.limits.ms;
                returns.then(|| self.change(from, TierChangeReason::Room, steady))
            }
            Spikes::Tried(_, share) => {
                if share * frames >= 6.0 {
                    self.spikes = Spikes::Avoidable;
                }
                None
            }
            Spikes::Stay(until) if self.clock < until => None,
            Spikes::Unknown | Spikes::Avoidable | Spikes::Stay(_) => {
                let is_hit = |tier: usize| self.is_often(self.avoidable(tier), 1.5);
                let to = (0..self.tier).rev().find(|tier| !is_hit(*tier)).filter(|_| is_hit(self.tier))?;
                self.spikes = Spikes::Tried(self.tier, over as f64 / frames);
                Some(self.change(to, TierChangeReason::Spikes, steady))
            }
        }
    }

    /// Takes a better tier if the budget has room.
    fn improve(&mut self, high: f64) -> Option<TierChange> {
        if let Spikes::Tried(..) = self.spikes {
            return None;
        }
        let limit = self.limits.ms * (1.0 - MARGIN);
        let spikes = MAX_SHARE_OVER * self.times.len() as f64;
        let is_known_to_fit = |tier: &usize| {
            let (Tier { is_measured, retry, failed, .. }, ms) = (&self.tiers[*tier], self.expected(high, *tier));
            let keeps_spikes = self.spikes != Spikes::Avoidable || self.avoidable(*tier) as f64 <= spikes;
            *is_measured && keeps_spikes && ms <= limit && (self.clock >= *retry || ms < CHEAPER * failed)
        };
        if let Some(to) = (self.tier + 1..self.tiers.len()).rev().find(is_known_to_fit) {
            return Some(self.change(to, TierChangeReason::Room, high));
        }
        let mut untried = (self.tier + 1..self.tiers.len()).take_while(|tier| !self.tiers[*tier].is_measured);
        let to = untried.find(|tier| self.clock >= self.tiers[*tier].retry)?;
        let is_patient = self.times.len() >= PATIENT_FRAMES && high <= self.limits.ms * (1.0 - ROOM);
        let is_worth = is_patient || self.expected(high, to) <= limit;
        is_worth.then(|| self.change(to, TierChangeReason::Trial, high))
    }

    /// The time of a frame at another tier than the present one.
    fn expected(&self, ms: f64, tier: usize) -> f64 {
        let direction = usize::from(tier > self.tier);
        ms * self.tiers[tier].costs[direction] / self.tiers[self.tier].costs[direction]
    }

    /// The number of spikes over the budget at a tier that the cheapest one would have kept.
    fn avoidable(&self, tier: usize) -> usize {
        let cheapest = (0..self.tiers.len()).map(|tier| self.cost(tier)).fold(f64::INFINITY, f64::min);
        let share = cheapest / self.cost(self.tier);
        let is_over = |ms: &f64| self.expected(*ms, tier) > self.limits.ms && *ms * share <= self.limits.ms;
        // The last frames may be a step of the load, which their median decides first.
        self.times.earlier().filter(is_over).count()
    }

    /// `true` if so many of the frames are over the budget that it is no chance if one of a hundred may be.
    /// `deviations` of chance are allowed.
    fn is_often(&self, over: usize, deviations: f64) -> bool {
        let expected = MAX_SHARE_OVER * self.times.len() as f64;
        over >= MIN_OVER && over as f64 > expected + deviations * expected.sqrt()
    }

    fn change(&mut self, to: usize, reason: TierChangeReason, ms: f64) -> TierChange {
        let from = self.tier;
        let [from_name, to_name] = [from, to].map(|tier| self.tiers[tier].name.clone());
        let (expected_ms, jod) = (self.expected(ms, to), self.tiers[to].jod);
        let TierLimits { ms: budget_ms, min_jod, .. } = self.limits;
        self.before_ms = match reason {
            TierChangeReason::Over => self.times.median(0, TRIAL_FRAMES).max(self.times.median(0, NOW)),
            _ => self.times.median(0, STEADY_FRAMES),
        };
        (self.before, self.tier, self.is_trial) = (from, to, to > from);
        (self.changed, self.settling, self.over) = (self.clock, SETTLING_FRAMES, None);
        self.times.clear();
        TierChange { from: from_name, to: to_name, reason, ms, expected_ms, budget_ms, jod, min_jod }
    }
}

/// The tiers that claim at least so many JOD. If none does, the best claim alone; of equal ones, the last.
fn reaching(tiers: &[GovernedTier], min_jod: Option<f64>) -> Vec<&GovernedTier> {
    let Some(least) = min_jod else { return tiers.iter().collect() };
    let reaching: Vec<&GovernedTier> = tiers.iter().filter(|tier| tier.jod.is_some_and(|jod| jod >= least)).collect();
    if !reaching.is_empty() {
        return reaching;
    }
    let claim = |tier: &GovernedTier| tier.jod.filter(|jod| !jod.is_nan()).unwrap_or(f64::NEG_INFINITY);
    tiers.iter().max_by(|a, b| claim(a).total_cmp(&claim(b))).into_iter().collect()
}
