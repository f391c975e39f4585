//! The governor against traces of load, beside choices that know the load and choices that do not look at it.
//!
//! `AFTERIMAGE_BLESS=1 cargo test -p afterimage --test governor` writes its table,
//! `graph/docs/measurements/governor.csv`.

mod traces;

use std::collections::VecDeque;
use std::fmt::Write;

use afterimage::host::{GovernedTier, Governor, TierChange, TierChangeReason, TierLimits};
use traces::{BUDGET, COSTS, DT, FRAMES, Random, TIERS, Trace, traces};

const NAMES: [&str; TIERS] = ["low", "medium", "high", "ultra"];
const SEEDS: u64 = 8;
/// Frames after a step of the load that do not count.
const REACTION: usize = 20;
/// Frames after which a time arrives.
const LATE: usize = 3;
/// Frames between two changes.
const COOL_DOWN: usize = 120;
const HEAD: &str = "trace,low: over %,low: quality,ultra: over %,ultra: quality,over %,over % of the worst seed,\
                    quality,quality of the worst seed,changes in 120 s,tiers left at once\n";

/// What a choice of tiers comes to.
#[derive(Default)]
struct Outcome {
    counted: usize,
    over: usize,
    worth: f64,
    changes: Vec<(usize, TierChange)>,
}

impl Outcome {
    fn percent_over(&self) -> f64 {
        100.0 * self.over as f64 / self.counted.max(1) as f64
    }
}

/// The mean and the worst of all seeds.
struct Figure {
    sum: f64,
    worst: f64,
}

impl Figure {
    fn of(values: &[f64], worst: fn(f64, f64) -> f64) -> Self {
        Self { sum: values.iter().sum(), worst: values.iter().copied().reduce(worst).expect("there are seeds") }
    }

    fn mean(&self) -> f64 {
        self.sum / SEEDS as f64
    }
}

/// Runs a trace; `choose` gets each time that arrives, with its tier, and returns the tier of the next frame.
fn run(trace: &Trace, mut choose: impl FnMut(Option<(usize, f64)>) -> (usize, Option<TierChange>)) -> Outcome {
    let (mut outcome, mut random, mut stepped) = (Outcome::default(), Random(trace.seed), 0);
    let mut sent = VecDeque::new();
    let (mut tier, _) = choose(None);
    for frame in 0..FRAMES {
        if frame > 0 && (trace.load[frame] / trace.load[frame - 1] - 1.0).abs() > 0.05 {
            stepped = frame;
        }
        let times = trace.times(frame, &mut random);
        outcome.worth += COSTS[tier];
        // A frame that no tier keeps does not count.
        let is_kept = times.iter().any(|ms| *ms <= BUDGET);
        if is_kept && trace.best(frame).is_some() && frame >= stepped + REACTION {
            outcome.counted += 1;
            outcome.over += usize::from(times[tier] > BUDGET);
        }
        sent.push_back((tier, times[tier]));
        let arrived = if sent.len() > LATE { sent.pop_front() } else { None };
        let (next, change) = choose(arrived);
        outcome.changes.extend(change.map(|change| (frame, change)));
        tier = next;
    }
    outcome
}

fn governed(trace: &Trace) -> Outcome {
    let mut tiers = Vec::new();
    for (name, cost) in NAMES.iter().zip(trace.given) {
        tiers.push(GovernedTier { name: (*name).to_owned(), cost, jod: None });
    }
    let mut governor = Governor::new(BUDGET, &tiers);
    run(trace, |arrived| {
        let change = arrived.and_then(|(tier, ms)| governor.frame(tier, ms, DT));
        (governor.tier(), change)
    })
}

/// What the best choice is worth that knows the whole trace, changes at most once in two seconds, and never takes a
/// tier that does not fit: the sums from the last frame to the first.
fn clairvoyant(trace: &Trace) -> f64 {
    // sums[frame][tier]: what the tier is worth in all frames before.
    let mut sums = vec![[0.0; TIERS]; FRAMES + 1];
    for frame in 0..FRAMES {
        let best = trace.best(frame).unwrap_or(0);
        for tier in 0..TIERS {
            let fits = tier <= best && trace.costs[tier] <= trace.costs[best];
            sums[frame + 1][tier] = sums[frame][tier] + if fits { COSTS[tier] } else { -100.0 };
        }
    }
    // rest[frame][tier]: what the rest is worth if the frame has this tier and may have another.
    let mut rest = vec![[0.0; TIERS]; FRAMES + 1];
    for frame in (0..FRAMES).rev() {
        let after = (frame + COOL_DOWN).min(FRAMES);
        for tier in 0..TIERS {
            let mut best = sums[frame + 1][tier] - sums[frame][tier] + rest[frame + 1][tier];
            for to in 0..TIERS {
                best = f64::max(best, sums[after][to] - sums[frame][to] + rest[after][to]);
            }
            rest[frame][tier] = best;
        }
    }
    rest[0].iter().copied().fold(f64::MIN, f64::max)
}

/// How often a tier was left within two seconds.
fn left_at_once(name: &str, changes: &[(usize, TierChange)]) -> usize {
    let mut count = 0;
    for pair in changes.windows(2) {
        let [(first, before), (second, after)] = pair else { continue };
        if second - first < COOL_DOWN - 1 {
            count += 1;
            let is_failed_trial = before.reason != TierChangeReason::Over && after.reason == TierChangeReason::Over;
            assert!(is_failed_trial, "{name}: two changes within two seconds: {before}; {after}");
        }
    }
    count
}

/// The row of a trace.
fn row(index: usize) -> String {
    let (mut over, mut quality, mut changes, mut left) = (Vec::new(), Vec::new(), 0, 0);
    let mut fixed = [(); 2].map(|()| (Vec::new(), Vec::new()));
    let mut name = String::new();
    for seed in 1..=SEEDS {
        let trace = &traces(seed)[index];
        let best = clairvoyant(trace);
        for (tier, (over, quality)) in [0, TIERS - 1].into_iter().zip(&mut fixed) {
            let outcome = run(trace, |_| (tier, None));
            over.push(outcome.percent_over());
            quality.push(outcome.worth / best);
        }
        let outcome = governed(trace);
        over.push(outcome.percent_over());
        quality.push(outcome.worth / best);
        changes = changes.max(outcome.changes.len());
        left = left.max(left_at_once(&trace.name, &outcome.changes));
        name = trace.name.clone();
    }
    let (over, quality) = (Figure::of(&over, f64::max), Figure::of(&quality, f64::min));
    assert!(over.mean() <= 1.0, "{name}: {:.2} % of the frames over the budget", over.mean());
    assert!(quality.mean() >= 0.9, "{name}: {:.3} of the best choice", quality.mean());
    let mut row = name;
    for (over, quality) in &fixed {
        let (over, quality) = (Figure::of(over, f64::max), Figure::of(quality, f64::min));
        write!(row, ",{:.2},{:.2}", over.mean(), quality.mean()).expect("it is a string");
    }
    let (mean, worst) = (over.mean(), over.worst);
    writeln!(row, ",{mean:.2},{worst:.2},{:.3},{:.3},{changes},{left}", quality.mean(), quality.worst)
        .expect("it is a string");
    row
}

#[test]
fn frames_stay_within_the_budget_at_nearly_the_best_tier() {
    let mut table = HEAD.to_owned();
    for index in 0..traces(1).len() {
        table += &row(index);
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/measurements/governor.csv");
    if std::env::var_os("AFTERIMAGE_BLESS").is_some() {
        std::fs::write(path, &table).expect("the table can be written");
    }
    let known = std::fs::read_to_string(path).expect("there is a table");
    assert_eq!(known, table, "the table is stale: if this is meant, set AFTERIMAGE_BLESS=1");
}

fn governor(costs: &[Option<f64>]) -> Governor {
    let tier = |(name, cost): (&&str, &Option<f64>)| GovernedTier { name: (*name).to_owned(), cost: *cost, jod: None };
    Governor::new(BUDGET, &NAMES.iter().zip(costs).map(tier).collect::<Vec<_>>())
}

/// The first change within ten seconds of frames of this time at each tier.
fn first_change(governor: &mut Governor, ms: impl Fn(usize) -> f64) -> Option<TierChange> {
    (0..600).find_map(|_| governor.frame(governor.tier(), ms(governor.tier()), DT))
}

#[test]
fn a_change_says_why() {
    let mut governor = governor(&COSTS.map(Some));
    let up = first_change(&mut governor, |_| 1.0).expect("the load is small");
    assert_eq!(up.to_string(), "low to medium: 1.00 ms, within 4.00; a trial, 1.57 ms are a guess");
    let down = first_change(&mut governor, |_| 6.0).expect("it is too slow");
    assert_eq!((down.from.as_str(), down.to.as_str()), ("medium", "low"));
    assert!(down.ms > BUDGET && down.to_string().contains("6.00 ms, over 4.00"), "{down}");
}

#[test]
fn each_number_over_the_budget_is_over_the_budget() {
    for trace in traces(1) {
        for (_, change) in governed(&trace).changes {
            match change.reason {
                TierChangeReason::Over => assert!(change.ms > BUDGET, "{change}"),
                TierChangeReason::Room => assert!(change.expected_ms <= BUDGET, "{change}"),
                TierChangeReason::Trial | TierChangeReason::Spikes => assert!(change.ms <= BUDGET, "{change}"),
            }
        }
    }
}

#[test]
fn seconds_that_are_no_number_pass_as_none() {
    let mut governor = governor(&COSTS.map(Some));
    for dt in [f64::NAN, f64::NEG_INFINITY, -1.0] {
        governor.frame(0, 1.0, dt);
    }
    assert!(first_change(&mut governor, |_| 0.1).is_some());
}

#[test]
fn any_costs_are_taken() {
    for costs in [[Some(0.0); TIERS], [None; TIERS], [Some(f64::INFINITY); TIERS], [Some(-1.0); TIERS]] {
        let mut governor = governor(&costs);
        for frame in 0..2000 {
            governor.frame(governor.tier(), if frame < 1000 { 1.0 } else { 9.0 }, DT);
        }
    }
    let mut none = Governor::new(f64::NAN, &[GovernedTier { name: "low".to_owned(), cost: None, jod: None }]);
    assert_eq!(first_change(&mut none, |_| 1.0), None);
}

#[test]
fn times_that_are_none_change_nothing() {
    let mut governor = governor(&COSTS.map(Some));
    for ms in [f64::NAN, f64::INFINITY, 0.0, -1.0].into_iter().cycle().take(400) {
        assert_eq!(governor.frame(0, ms, DT), None);
        assert_eq!(governor.frame(3, 1.0, DT), None, "a frame of another tier");
    }
}

#[test]
fn a_tier_that_is_refused_is_left() {
    let mut governor = governor(&COSTS.map(Some));
    first_change(&mut governor, |_| 1.0).expect("the load is small");
    governor.refuse();
    assert_eq!(governor.name(), "low");
    let next = first_change(&mut governor, |_| 1.0).expect("another one is tried");
    assert_eq!(next.to, "high");
}

/// A governor whose tiers claim this quality.
fn with_floor(min_jod: f64, claims: [Option<f64>; TIERS]) -> Governor {
    let named = NAMES.iter().zip(COSTS).zip(claims);
    let tiers = named.map(|((name, cost), jod)| GovernedTier { name: (*name).to_owned(), cost: Some(cost), jod });
    Governor::new(TierLimits::new(BUDGET).min_jod(min_jod), &tiers.collect::<Vec<_>>())
}

const CLAIMS: [Option<f64>; TIERS] = [Some(8.25), Some(9.0), None, Some(9.9)];

#[test]
fn no_tier_below_the_floor_is_chosen_whatever_frames_take() {
    for trace in traces(1) {
        let mut governor = with_floor(9.0, CLAIMS);
        let outcome = run(&trace, |arrived| {
            let change = arrived.and_then(|(tier, ms)| governor.frame(tier, ms, DT));
            assert!(["medium", "ultra"].contains(&governor.name()), "{}: {}", trace.name, governor.name());
            (governor.tier(), change)
        });
        let told = outcome.changes.iter().all(|(_, change)| change.jod >= Some(9.0) && change.min_jod == Some(9.0));
        assert!(told, "{}", trace.name);
    }
    let mut governor = with_floor(9.0, CLAIMS);
    let up = first_change(&mut governor, |_| 1.0).expect("the load is small");
    assert_eq!(
        up.to_string(),
        "medium to ultra: 1.00 ms, within 4.00; a trial, 1.82 ms are a guess; 9.90 JOD, at least 9.00"
    );
}

#[test]
fn a_floor_that_costs_the_budget_is_told() {
    let mut governor = with_floor(9.0, CLAIMS);
    assert_eq!(governor.shortfall(), None);
    assert_eq!(first_change(&mut governor, |_| 6.0), None, "the cheapest that may be chosen");
    let shortfall = governor.shortfall().expect("it is too dear").to_string();
    assert_eq!(shortfall, "medium, of 9.00 JOD, takes 6.00 ms, over 4.00, and no cheaper tier claims 9.00 JOD");
    assert!(first_change(&mut governor, |_| 1.0).is_some());
    assert_eq!(governor.shortfall(), None);
    let mut free = self::governor(&COSTS.map(Some));
    assert_eq!(first_change(&mut free, |_| 6.0), None);
    let shortfall = free.shortfall().expect("it is too dear").to_string();
    assert_eq!(shortfall, "low, without a claim, takes 6.00 ms, over 4.00, and no tier is cheaper");
    free.set_budget(8.0);
    assert_eq!(free.shortfall(), None);
}

#[test]
fn the_best_claim_stays_where_none_reaches_the_floor() {
    let none = [None; TIERS];
    let nan = [Some(9.0), Some(f64::NAN), Some(8.0), None];
    let equal = [Some(9.0), Some(9.5), Some(9.5), None];
    let cases = [
        (9.95, CLAIMS, "ultra"),
        (f64::NAN, CLAIMS, "ultra"),
        (11.0, CLAIMS, "ultra"),
        (f64::INFINITY, CLAIMS, "ultra"),
        (f64::NEG_INFINITY, none, "ultra"),
        (9.2, nan, "low"),
        (9.9, equal, "high"),
    ];
    for (floor, claims, best) in cases {
        let mut governor = with_floor(floor, claims);
        assert_eq!(governor.names().collect::<Vec<_>>(), [best], "{floor}");
        assert!(governor.shortfall().is_some_and(|shortfall| shortfall.is_of_quality()), "{floor}");
        for ms in [9.0, 0.1] {
            assert_eq!(first_change(&mut governor, |_| ms), None, "{floor}");
        }
    }
    let mut governor = with_floor(9.95, CLAIMS);
    let none = "no tier claims 9.95 JOD: ultra, of 9.90 JOD, stays, and the budget of 4.00 ms is not held";
    assert_eq!(governor.shortfall().expect("no tier reaches it").to_string(), none);
    first_change(&mut governor, |_| 9.0);
    let over = format!("{none}; frames take 9.00 ms");
    assert_eq!(governor.shortfall().expect("no tier reaches it").to_string(), over);
}

#[test]
fn each_claim_reaches_the_lowest_floor_and_no_difference_the_highest() {
    for floor in [0.0, f64::NEG_INFINITY] {
        let governor = with_floor(floor, CLAIMS);
        assert_eq!(governor.names().collect::<Vec<_>>(), ["low", "medium", "ultra"], "a tier without a claim is none");
        assert_eq!((governor.name(), governor.shortfall()), ("low", None));
    }
    let governor = with_floor(10.0, [Some(9.99), Some(10.0), None, Some(10.0)]);
    assert_eq!(governor.names().collect::<Vec<_>>(), ["medium", "ultra"]);
    let negative = with_floor(0.0, [Some(-0.5), Some(0.0), Some(1.0), None]);
    assert_eq!(negative.names().collect::<Vec<_>>(), ["medium", "high"]);
}
