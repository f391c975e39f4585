//! The governor against traces of load: `cargo test -p afterimage-gpu --test governor -- --nocapture` prints the table.

#![allow(clippy::print_stdout, reason = "it prints the table of its figures")]

use afterimage_gpu::{Governor, TierChange};

/// Costs of the tiers, cheapest first: those of `tsushima.ron` on one GPU.
const COSTS: [f64; 4] = [0.35, 0.55, 0.75, 1.0];
const BUDGET: f64 = 4.0;
const FRAMES: usize = 60 * 120;
const DT: f64 = 1.0 / 60.0;
/// Frames after a change of load that do not count.
const REACTION: usize = 20;

/// Numbers from 0 to 1 that follow from a seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.next()).sum::<f64>() - 6.0
    }
}

/// A trace: what one unit of cost takes in each frame, without its noise and with it.
struct Trace {
    name: &'static str,
    base: Vec<f64>,
    noise: f64,
    seed: u64,
}

fn traces(seed: u64) -> Vec<Trace> {
    let time = |frame: usize| frame as f64 * DT;
    let of = |name, noise, base: &mut dyn FnMut(usize) -> f64| Trace {
        name,
        base: (0..FRAMES).map(base).collect(),
        noise,
        seed: seed + 100,
    };
    let mut random = Random(seed);
    let steps: Vec<f64> = (0..FRAMES / 480 + 1).map(|_| 2.5 + 7.0 * random.next()).collect();
    let spikes: Vec<bool> = (0..FRAMES).map(|_| random.next() < 0.004).collect();
    vec![
        of("steps", 0.02, &mut |frame| steps[frame / 480]),
        of("ramps", 0.02, &mut |frame| 5.5 + 3.0 * (time(frame) / 15.0 * std::f64::consts::TAU).sin()),
        of("spikes", 0.02, &mut |frame| if spikes[frame] { 12.0 } else { 4.6 }),
        of("thermal", 0.02, &mut |frame| 3.7 + 2.2 * (1.0 - (-time(frame) / 30.0).exp())),
        of("noise", 0.10, &mut |_| 4.6),
        of("steps and noise", 0.06, &mut |frame| steps[(frame / 480 * 3 + 1) % steps.len()]),
    ]
}

/// What a choice of tiers comes to.
#[derive(Default)]
struct Outcome {
    counted: usize,
    over: usize,
    cost: f64,
    clairvoyant: f64,
    changes: Vec<(usize, TierChange)>,
}

impl Outcome {
    fn share_over(&self) -> f64 {
        self.over as f64 / self.counted.max(1) as f64
    }

    fn share_of_clairvoyant(&self) -> f64 {
        self.cost / self.clairvoyant
    }
}

/// Runs a trace; `choose` gets the time of a frame and returns the tier of the next one.
fn run(trace: &Trace, first: usize, mut choose: impl FnMut(f64) -> (usize, Option<TierChange>)) -> Outcome {
    let (mut outcome, mut random, mut tier, mut changed) = (Outcome::default(), Random(trace.seed), first, 0);
    // True costs differ from those that the governor begins with.
    let costs = COSTS.map(|cost| cost * (1.0 + 0.08 * (7.0 * cost).sin()));
    for (frame, base) in trace.base.iter().enumerate() {
        if frame > 0 && (base / trace.base[frame - 1] - 1.0).abs() > 0.05 {
            changed = frame;
        }
        let load = base * (1.0 + trace.noise * random.normal()).max(0.1);
        let ms = load * costs[tier];
        // The most expensive tier that stays within the budget in all but one of a hundred frames of this base.
        let reach = base * (1.0 + 2.33 * trace.noise);
        let best = costs.iter().rposition(|cost| reach * cost <= BUDGET);
        outcome.cost += costs[tier];
        outcome.clairvoyant += costs[best.unwrap_or(0)];
        if frame >= changed + REACTION && best.is_some() {
            outcome.counted += 1;
            outcome.over += usize::from(ms > BUDGET);
        }
        let (next, change) = choose(ms);
        tier = next;
        outcome.changes.extend(change.map(|change| (frame, change)));
    }
    outcome
}

#[test]
fn frames_stay_within_the_budget_at_nearly_the_best_tier() {
    println!("frames over the budget, and mean cost beside that of the best choice");
    println!("{:<22} {:>16} {:>16} {:>16}  changes", "", "always cheapest", "always best", "governor");
    for (seed, trace) in (1..=8).flat_map(|seed| traces(seed).into_iter().map(move |trace| (seed, trace))) {
        let cheapest = run(&trace, 0, |_| (0, None));
        let best = run(&trace, COSTS.len() - 1, |_| (COSTS.len() - 1, None));
        let mut governor = Governor::new(BUDGET, &COSTS);
        let governed = run(&trace, 0, |ms| {
            let change = governor.frame(ms, DT);
            (governor.tier(), change)
        });
        let cell = |outcome: &Outcome| {
            format!("{:.2} % / {:.2}", 100.0 * outcome.share_over(), outcome.share_of_clairvoyant())
        };
        let cells = [&cheapest, &best, &governed].map(cell);
        let name = format!("{}, seed {seed}", trace.name);
        println!("{name:<22} {:>16} {:>16} {:>16}  {}", cells[0], cells[1], cells[2], governed.changes.len());
        assert!(governed.share_over() <= 0.01, "{name}: {}", cells[2]);
        assert!(governed.share_of_clairvoyant() >= 0.9, "{name}: {}", cells[2]);
        let close = governed.changes.windows(2).find(|pair| (pair[1].0 - pair[0].0) as f64 * DT < 0.999);
        assert!(close.is_none(), "{name}: two changes within a second: {close:?}");
    }
}

#[test]
fn a_change_says_why() {
    let mut governor = Governor::new(BUDGET, &COSTS);
    let up = (0..200).find_map(|_| governor.frame(1.0, DT)).expect("the load is small");
    assert_eq!((up.from, up.to), (0, 3));
    assert_eq!(up.to_string(), "tier 0 to 3: 1.00 ms, within 4.00; 2.86 ms expected");
    let down = (0..200).find_map(|_| governor.frame(6.0, DT)).expect("it is too slow");
    assert!(down.to < 3 && down.to_string().contains("over 4.00"), "{down}");
}

#[test]
fn times_that_are_none_change_nothing() {
    let mut governor = Governor::new(BUDGET, &COSTS);
    for ms in [f64::NAN, f64::INFINITY, 0.0, -1.0].into_iter().cycle().take(400) {
        assert_eq!(governor.frame(ms, DT), None);
    }
    let mut one = Governor::new(BUDGET, &[1.0]);
    assert!((0..400).all(|frame| one.frame(if frame % 2 == 0 { 1.0 } else { 9.0 }, DT).is_none()));
}
