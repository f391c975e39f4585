//! The choice of a quality tier from measured GPU times.

mod change;
mod costs;
mod decide;
mod times;

pub use change::{TierChange, TierChangeReason};
use costs::Costs;
use times::{MIN_FRAMES, NEWEST, NOW, STEADY_FRAMES, Times};

/// A tier that a [`Governor`] may choose.
#[derive(Clone, Debug, PartialEq)]
pub struct GovernedTier {
    /// Its name in the pipeline file.
    pub name: String,
    /// What it costs relative to the others, as `afterimage bench` measures it on any device. `None`, or a number that
    /// is not above zero, if nobody knows.
    pub cost: Option<f64>,
}

/// Chooses the best tier whose frames stay within a budget.
///
/// It learns what the tiers take on this device. The time of a frame is taken to be what no tier changes plus the load
/// times the cost of the tier, and both are fitted to the changes so far; the given costs count little. A tier that was
/// not tried is tried when the budget has room for it, and left after a few frames that are over the budget. One that
/// did not last is tried again after a wait that doubles each time.
///
/// Medians and the spread between neighbors judge a tier, so a few slow frames are spikes and no load. If more than one
/// frame of a hundred is over the budget for its spikes, a cheaper tier is tried. Where they stay, no tier can avoid
/// them: the better one returns.
///
/// Two changes are at least two seconds apart, but a tier that was tried may be left at once.
///
/// It has no clock and no device: the host measures each frame on the GPU, the pipeline alone or with all else that the
/// budget is for. Times may come late, because each comes with the tier of its frame.
/// [`Post::govern`](crate::Post::govern) does all of this for a pipeline.
#[derive(Clone, Debug)]
pub struct Governor {
    /// Milliseconds.
    budget: f64,
    tiers: Vec<Tier>,
    costs: Costs,
    tier: usize,
    /// The tier before the last change.
    before: usize,
    /// Milliseconds of the last frames at this tier.
    times: Times,
    /// Frames at this tier whose times do not count yet.
    settling: usize,
    /// Milliseconds of the first frames at this tier.
    first_ms: f64,
    /// Whether its cost has been learned from enough frames.
    has_learned: bool,
    /// Seconds in which frames came, and those of one frame.
    clock: f64,
    dt: f64,
    /// When the first frame of this tier came.
    changed: f64,
    /// Whether this tier may be left at once.
    is_trial: bool,
    spikes: Spikes,
}

#[derive(Clone, Debug)]
struct Tier {
    name: String,
    /// When it was last measured.
    measured: f64,
    /// It is not taken before, unless it is expected to take less than when it failed.
    retry: f64,
    /// Milliseconds when it failed.
    failed: f64,
    /// Seconds to wait when it fails the next time.
    wait: f64,
    /// Seconds after which a measured cost is doubted.
    doubt: f64,
    /// The share of the budget that it must leave to be taken.
    margin: f64,
}

/// What is known of frames that are slow now and then.
#[derive(Clone, Copy, Debug)]
struct Spikes {
    /// A cheaper tier that is tried because of them.
    trial: Option<SpikeTrial>,
    /// Whether a cheaper tier has avoided them.
    follow_load: bool,
    /// No cheaper tier is tried because of them before.
    retry: f64,
    /// Seconds to wait when that fails the next time.
    wait: f64,
}

#[derive(Clone, Copy, Debug)]
struct SpikeTrial {
    from: usize,
    /// The share of frames that were over the budget.
    share: f64,
}

/// A frame counts so much in the mean of their seconds, and lasts at least so long.
const DT_SHARE: f64 = 0.05;
const MIN_DT: f64 = 1e-3;
/// The first frames of a plan wait for memory and compiled code.
const SETTLING_FRAMES: usize = 2;
/// A tier that is tried is left after so many frames in a row over the budget.
const TRIAL_FRAMES: usize = 3;
/// Seconds between two changes.
const COOL_DOWN: f64 = 2.0;
/// Seconds at a tier after which it has lasted.
const LASTING: f64 = 8.0;
/// The share of the budget that a better tier must leave, at first and after it has failed often.
const MIN_MARGIN: f64 = 0.02;
const MAX_MARGIN: f64 = 0.06;
/// Seconds before a tier that failed is taken again, the first time and at most.
const MIN_WAIT: f64 = 4.0;
const MAX_WAIT: f64 = 128.0;
/// Seconds for which a measured cost is believed, the first time.
const MIN_DOUBT: f64 = 60.0;
/// Seconds before a cheaper tier is tried again for spikes that it did not avoid, the first time and at most.
const MIN_SPIKE_WAIT: f64 = 60.0;
const MAX_SPIKE_WAIT: f64 = 960.0;

impl Governor {
    /// A governor that begins with the first of the tiers, which are in order from the worst picture to the best.
    /// Their costs may have any order: a tier that costs more than a better one is not kept. A budget that is not above
    /// zero keeps the cheapest tier.
    ///
    /// # Panics
    /// There is no tier.
    pub fn new(budget_ms: f64, tiers: &[GovernedTier]) -> Self {
        assert!(!tiers.is_empty(), "a governor has tiers to choose from");
        let tier = |tier: &GovernedTier| Tier {
            name: tier.name.clone(),
            measured: 0.0,
            retry: 0.0,
            failed: f64::INFINITY,
            wait: MIN_WAIT,
            doubt: MIN_DOUBT,
            margin: MIN_MARGIN,
        };
        Self {
            budget: budget_ms,
            tiers: tiers.iter().map(tier).collect(),
            costs: Costs::new(tiers.iter().map(|tier| tier.cost)),
            tier: 0,
            before: 0,
            times: Times::new(),
            settling: SETTLING_FRAMES,
            first_ms: f64::INFINITY,
            has_learned: true,
            clock: 0.0,
            dt: 1.0 / 60.0,
            changed: -COOL_DOWN,
            is_trial: false,
            spikes: Spikes { trial: None, follow_load: false, retry: 0.0, wait: MIN_SPIKE_WAIT },
        }
    }

    /// The index of the tier that frames should have.
    pub fn tier(&self) -> usize {
        self.tier
    }

    /// The name of that tier.
    pub fn name(&self) -> &str {
        &self.tiers[self.tier].name
    }

    /// The names of all tiers, from the worst picture to the best.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.tiers.iter().map(|tier| tier.name.as_str())
    }

    /// What a tier costs relative to the others, as far as it is known.
    pub fn cost(&self, tier: usize) -> f64 {
        self.costs.cost(tier)
    }

    /// Whether a tier has been tried here.
    pub fn is_measured(&self, tier: usize) -> bool {
        self.costs.is_measured(tier)
    }

    /// Milliseconds of each frame that no tier changes, as far as they are known.
    pub fn outside_ms(&self) -> f64 {
        self.costs.outside_ms()
    }

    /// The budget in milliseconds.
    pub fn budget_ms(&self) -> f64 {
        self.budget
    }

    /// Sets the budget in milliseconds.
    pub fn set_budget(&mut self, budget_ms: f64) {
        self.budget = budget_ms;
    }

    /// Takes the GPU time of a frame in milliseconds, the tier that it was rendered with, and the seconds since the
    /// frame before. A time that is not finite or not above zero, and that of another tier than the
    /// [present](Self::tier) one, only lets the seconds pass. Returns the change that the next frame should have.
    pub fn frame(&mut self, tier: usize, ms: f64, dt: f64) -> Option<TierChange> {
        let dt = if dt.is_nan() { 0.0 } else { dt.clamp(0.0, 1.0) };
        self.clock += dt;
        self.dt += DT_SHARE * (dt.max(MIN_DT) - self.dt);
        if tier != self.tier || !ms.is_finite() || ms <= 0.0 {
            return None;
        }
        if self.settling > 0 {
            if self.settling == SETTLING_FRAMES && !self.has_learned {
                self.changed = self.clock;
            }
            self.settling -= 1;
            return None;
        }
        self.times.push(ms);
        if self.times.len() < TRIAL_FRAMES {
            return None;
        }
        self.learn();
        let since = self.clock - self.changed;
        if since >= LASTING {
            let tier = &mut self.tiers[self.tier];
            (tier.wait, tier.margin) = (MIN_WAIT, MIN_MARGIN);
        }
        self.is_trial &= since < COOL_DOWN;
        if since < COOL_DOWN && !self.is_trial { None } else { self.decide() }
    }

    /// States that the present tier cannot be rendered. Returns to the one before, and does not try this one for a
    /// while.
    pub fn refuse(&mut self) {
        self.tiers[self.tier].retry = self.clock + MAX_WAIT;
        self.tiers[self.tier].failed = 0.0;
        (self.before, self.tier) = (self.tier, self.before);
        (self.has_learned, self.is_trial, self.spikes.trial) = (true, false, None);
        self.settling = SETTLING_FRAMES;
    }

    fn change(&mut self, to: usize, reason: TierChangeReason, ms: f64) -> TierChange {
        let from = self.tier;
        let change = TierChange {
            from: self.tiers[from].name.clone(),
            to: self.tiers[to].name.clone(),
            reason,
            ms,
            expected_ms: self.costs.expected(ms, from, to),
            budget_ms: self.budget,
            frames_over: self.times.over(self.budget),
            frames: self.times.len(),
        };
        let before = match reason {
            TierChangeReason::Over | TierChangeReason::Rising => self.times.median(NEWEST).max(self.times.median(NOW)),
            _ => self.times.median(STEADY_FRAMES),
        };
        self.costs.begin(from, to, before);
        if self.has_learned {
            self.tiers[from].measured = self.clock;
        }
        self.has_learned = false;
        self.is_trial = to > from;
        (self.before, self.tier) = (from, to);
        (self.changed, self.settling) = (self.clock, SETTLING_FRAMES);
        self.times.clear();
        change
    }

    /// Learns the cost of a new tier from its first frames, and again from more.
    fn learn(&mut self) {
        let frames = self.times.len();
        if self.has_learned || ![TRIAL_FRAMES, MIN_FRAMES, STEADY_FRAMES].contains(&frames) {
            return;
        }
        self.first_ms = self.times.median(STEADY_FRAMES);
        self.costs.learn(self.first_ms);
        self.tiers[self.tier].measured = self.clock;
        self.has_learned = frames == STEADY_FRAMES;
    }
}
