//! Loads over two minutes, from a seed.

use std::f64::consts::TAU;

/// Costs of the tiers, cheapest first: those of `tsushima.ron` on one GPU. They are also what a tier is worth.
pub(crate) const COSTS: [f64; TIERS] = [0.35, 0.55, 0.75, 1.0];
pub(crate) const TIERS: usize = 4;
pub(crate) const BUDGET: f64 = 4.0;
/// Seconds of a frame.
pub(crate) const DT: f64 = 1.0 / 60.0;
pub(crate) const FRAMES: usize = 60 * 120;
/// Frames between two steps of the load.
const STEP: usize = 480;

/// Numbers from 0 to 1 that follow from a seed.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.next()).sum::<f64>() - 6.0
    }
}

/// A load and what disturbs it. The time of a frame is the load times the cost of its tier, and what is outside of it.
#[derive(Clone)]
pub(crate) struct Trace {
    pub(crate) name: String,
    pub(crate) seed: u64,
    /// Milliseconds of one unit of cost in each frame.
    pub(crate) load: Vec<f64>,
    /// The standard deviation of the load, as a share.
    pub(crate) noise: f64,
    /// Milliseconds that are the same at each tier.
    pub(crate) outside: f64,
    pub(crate) spikes: Spikes,
    /// What the tiers cost, and what the governor begins with.
    pub(crate) costs: [f64; TIERS],
    pub(crate) given: [Option<f64>; TIERS],
}

#[derive(Clone, Copy)]
pub(crate) struct Spikes {
    /// The share of frames that are spikes.
    pub(crate) share: f64,
    /// What a spike multiplies the load with, and the milliseconds that it adds at each tier.
    pub(crate) factor: f64,
    pub(crate) ms: f64,
}

impl Trace {
    fn new(name: &str, seed: u64, noise: f64, load: impl Fn(usize) -> f64) -> Self {
        Self {
            name: name.to_owned(),
            seed: seed + 100,
            load: (0..FRAMES).map(load).collect(),
            noise,
            outside: 0.0,
            spikes: Spikes { share: 0.0, factor: 1.0, ms: 0.0 },
            // Another GPU than the one of the given costs.
            costs: COSTS.map(|cost| cost * (1.0 + 0.08 * (7.0 * cost).sin())),
            given: COSTS.map(Some),
        }
    }

    /// Milliseconds of a frame at each tier, with the noise and the spike that `random` gives it.
    pub(crate) fn times(&self, frame: usize, random: &mut Random) -> [f64; TIERS] {
        let noise = (1.0 + self.noise * random.normal()).max(0.1);
        let is_spike = random.next() < self.spikes.share;
        let (factor, ms) = if is_spike { (self.spikes.factor, self.spikes.ms) } else { (1.0, 0.0) };
        self.costs.map(|cost| self.outside + ms + self.load[frame] * noise * factor * cost)
    }

    /// The best tier with at most one frame of a hundred over the budget at this load, if spikes that no tier keeps do
    /// not count. `None` if each has more.
    pub(crate) fn best(&self, frame: usize) -> Option<usize> {
        let high = self.load[frame] * (1.0 + 2.33 * self.noise);
        let spike = |tier: usize| self.outside + self.spikes.ms + high * self.spikes.factor * self.costs[tier];
        let must_avoid = self.spikes.share > 0.01 && (0..TIERS).any(|tier| spike(tier) <= BUDGET);
        let fits =
            |tier: usize| self.outside + high * self.costs[tier] <= BUDGET && (!must_avoid || spike(tier) <= BUDGET);
        (0..TIERS).rev().find(|tier| fits(*tier))
    }
}

/// All traces of a seed.
pub(crate) fn traces(seed: u64) -> Vec<Trace> {
    let mut random = Random(seed);
    let steps: Vec<f64> = (0..FRAMES / STEP + 1).map(|_| 2.5 + 7.0 * random.next()).collect();
    let step = |frame: usize| steps[frame / STEP];
    let ramp = |frame: usize| 5.5 + 3.0 * (frame as f64 * DT / 15.0 * TAU).sin();
    let of = |name: &str, noise: f64, load: &dyn Fn(usize) -> f64| Trace::new(name, seed, noise, load);
    let mut traces = vec![
        of("steps", 0.02, &step),
        of("ramps", 0.02, &ramp),
        of("thermal drift", 0.02, &|frame| 3.7 + 2.2 * (1.0 - (-(frame as f64) * DT / 30.0).exp())),
        of("noise of 10 %", 0.1, &|_| 4.6),
        of("steps and noise of 6 %", 0.06, &|frame| steps[(frame / STEP * 3 + 1) % steps.len()]),
    ];
    for share in [0.004, 0.016, 0.03, 0.05] {
        let percent = 100.0 * share;
        let others = Spikes { share, factor: 1.0, ms: 6.0 };
        let ours = Spikes { share, factor: 1.45, ms: 0.0 };
        traces.push(Trace { spikes: others, ..of(&format!("{percent:.1} % spikes of others"), 0.02, &|_| 3.4) });
        traces.push(Trace { spikes: others, ..of(&format!("{percent:.1} % spikes of others and steps"), 0.02, &step) });
        traces.push(Trace { spikes: ours, ..of(&format!("{percent:.1} % spikes of ours"), 0.02, &|_| 3.4) });
    }
    let mut random = Random(seed + 7);
    let wrong = COSTS.map(|cost| Some(if random.next() < 0.5 { cost / 6.0 } else { 6.0 * cost }));
    let unsorted = [0.35, 0.8, 0.6, 1.0];
    traces.extend([
        Trace { given: wrong, ..of("costs wrong by 6 and steps", 0.02, &step) },
        Trace { given: wrong, ..of("costs wrong by 6 and ramps", 0.02, &ramp) },
        Trace { given: [None; TIERS], ..of("no costs and steps", 0.02, &step) },
        Trace { outside: 1.8, ..of("1.8 ms outside and steps", 0.02, &|frame| 0.5 * step(frame)) },
        Trace { outside: 1.8, ..of("1.8 ms outside and ramps", 0.02, &|frame| 0.5 * ramp(frame)) },
        Trace { costs: unsorted, given: unsorted.map(Some), ..of("a tier that is too dear and steps", 0.02, &step) },
    ]);
    let spikes = Spikes { share: 0.02, factor: 1.0, ms: 5.0 };
    traces.push(Trace { outside: 1.0, spikes, given: wrong, ..of("all at once", 0.05, &|frame| 0.7 * step(frame)) });
    traces
}
