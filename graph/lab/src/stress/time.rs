//! Laws of sequences: histories stay finite, follow the images, and restart at a reset.

use afterimage_graph::check::Graph;
use afterimage_graph::image::Size;
use afterimage_graph::node::Invariants;

use super::case_runner::{CaseRunner, judge};
use super::images::Extreme;
use super::laws::{Tolerance, different, invariants};
use super::render::{Configuration, OutputPixels, RenderRequest, StressFrame};
use super::target::Overrides;

/// The name of the long sequence.
const LONG: &str = "thousand-frames";
const FRAMES: usize = 1000;
/// The factor by which it is shorter, with longer steps, where each frame takes long.
const FEWER: usize = 10;
/// The usual step of time.
const STEP: f32 = 1.0 / 60.0;
const SIZE: Size = Size { width: 17, height: 13, depth: 1 };
/// The tolerance of settled adaptation, in stops.
const SETTLED: Tolerance = Tolerance { relative: 2e-3, absolute: 4e-3 };
/// The tolerance of 32-bit rounding between two equal frames.
const STILL: Tolerance = Tolerance { relative: 1e-5, absolute: 1e-5 };

/// The names of late times, and their days: what is counted in floats has no frames left.
const LATE: [(&str, f64); 2] = [("after-days", 4.0), ("after-months", 100.0)];
/// The image of late times. What moves in a frame, as grain or hot air, is seen in it.
const LATE_IMAGE: &str = "edge";

/// A sequence with a name for `--case`.
struct Sequence {
    name: &'static str,
    inputs: fn() -> Vec<StressFrame>,
    /// The frames whose last one its last one must equal.
    expected: Option<ExpectedFrame>,
}

/// Frames whose last one the last frame must equal.
struct ExpectedFrame {
    inputs: fn() -> Vec<StressFrame>,
    tolerance: Tolerance,
    /// It is required of every graph, not only of those that follow the brightness.
    always: bool,
}

fn frame(name: &str) -> StressFrame {
    StressFrame { dt: STEP, reset: false, ..StressFrame::still(Extreme::named(name).expect("an image of that name")) }
}

fn first(name: &str) -> StressFrame {
    StressFrame { reset: true, ..frame(name) }
}

fn stepped(name: &str, dt: f32) -> StressFrame {
    StressFrame { dt, ..frame(name) }
}

const SEQUENCES: [Sequence; 7] = [
    Sequence {
        name: "time-zero",
        inputs: || vec![first("gray"), stepped("bright", 0.0)],
        expected: Some(ExpectedFrame {
            inputs: || vec![first("gray"), stepped("gray", 0.0)],
            tolerance: STILL,
            always: false,
        }),
    },
    Sequence {
        name: "time-backwards",
        inputs: || vec![first("gray"), stepped("bright", -1.0), stepped("bright", f32::NAN)],
        expected: Some(ExpectedFrame {
            inputs: || vec![first("gray"), stepped("gray", 0.0)],
            tolerance: STILL,
            always: false,
        }),
    },
    Sequence { name: "time-tiny", inputs: || vec![first("gray"), stepped("bright", 1e-6)], expected: None },
    Sequence {
        name: "time-huge",
        inputs: || vec![first("gray"), stepped("bright", 1e6)],
        expected: Some(ExpectedFrame {
            inputs: || vec![first("bright"), frame("bright")],
            tolerance: SETTLED,
            always: false,
        }),
    },
    Sequence {
        name: LONG,
        inputs: || [first("gray")].into_iter().chain(vec![frame("bright"); FRAMES]).collect(),
        expected: Some(ExpectedFrame { inputs: || vec![first("bright"); 2], tolerance: SETTLED, always: false }),
    },
    Sequence {
        name: "cut",
        inputs: || vec![first("edge"), frame("all-inf"), first("gray")],
        expected: Some(ExpectedFrame { inputs: || vec![first("gray"); 3], tolerance: Tolerance::NONE, always: true }),
    },
    Sequence {
        name: "bad-frame",
        inputs: || vec![first("gray"), frame("all-nan"), frame("nan"), frame("bright")],
        expected: Some(ExpectedFrame {
            inputs: || {
                let clean = |name| StressFrame { sanitized: true, ..frame(name) };
                vec![first("gray"), clean("all-nan"), clean("nan"), frame("bright")]
            },
            tolerance: Tolerance::NONE,
            always: true,
        }),
    },
];

/// The names of all sequences.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    SEQUENCES.iter().map(|sequence| sequence.name).chain(LATE.map(|(name, _)| name))
}

/// Two frames after days and months, which differ if those at the beginning do.
pub(crate) fn late(runner: &mut CaseRunner<'_>, graph: &Graph) {
    let mut configuration = runner.renderer.configure(|_, _| {}, false);
    let at = |time: f64| {
        let next = StressFrame { time: time + f64::from(STEP), ..frame(LATE_IMAGE) };
        [StressFrame { time, ..first(LATE_IMAGE) }, next]
    };
    for (name, days) in LATE.into_iter().filter(|(name, _)| runner.options.accepts(name)) {
        let time = 86_400.0 * days;
        let Some(early) = run(runner, &mut configuration, graph, name, &at(0.0)) else { continue };
        let Some(late) = run(runner, &mut configuration, graph, name, &at(time)) else { continue };
        let mut wrong: Vec<String> = late.iter().flatten().flat_map(|shown| judge(shown, true)).take(1).collect();
        wrong.extend(moved(&early, &late));
        runner.results.judged(name);
        runner.count(&Overrides::new(), SIZE, name, wrong);
    }
}

/// The fault of two late frames, if they have one.
fn moved(early: &[Vec<OutputPixels>], late: &[Vec<OutputPixels>]) -> Option<String> {
    let differ = |frames: &[Vec<OutputPixels>], output: usize| {
        different(&frames[1][output], &frames[0][output], Tolerance::NONE).is_some()
    };
    let still = (0..early[0].len()).find(|output| differ(early, *output) && !differ(late, *output));
    still.map(|output| format!("`{}` stands still", early[0][output].name))
}

/// Runs the sequences if the graph has histories.
pub(crate) fn sequences(runner: &mut CaseRunner<'_>, graph: &Graph) {
    let mut configuration = runner.renderer.configure(|_, _| {}, false);
    if !configuration.has_histories(runner.target, graph, SIZE) {
        return;
    }
    let invariants = invariants(graph);
    let is_slow = runner.options.quick && runner.is_heavy && runner.options.case.is_none();
    let is_chosen = |sequence: &&Sequence| {
        runner.options.accepts(sequence.name)
            && (!is_slow || sequence.expected.as_ref().is_some_and(|expected| expected.always))
    };
    let chosen: Vec<&Sequence> = SEQUENCES.iter().filter(is_chosen).collect();
    for sequence in chosen {
        let mut inputs = (sequence.inputs)();
        if sequence.name == LONG {
            if !is_worth_a_thousand(runner) {
                continue;
            }
            shorten(&mut inputs, runner.is_heavy);
        }
        let Some(frames) = run(runner, &mut configuration, graph, sequence.name, &inputs) else { continue };
        let mut wrong: Vec<String> = frames.iter().flatten().flat_map(|shown| judge(shown, true)).take(1).collect();
        if let Some(expected) =
            sequence.expected.as_ref().filter(|expected| expected.always || applies(runner, &invariants))
        {
            let expected_inputs = (expected.inputs)();
            let others = run(runner, &mut configuration, graph, sequence.name, &expected_inputs);
            let Some(others) = others else { continue };
            wrong.extend(last(&frames, &others, expected, runner.target.is_kind));
            runner.results.judged(sequence.name);
        }
        if sequence.name == LONG && applies(runner, &invariants) {
            wrong.extend(
                frames.iter().map(|frame| frame[0].pixels[0][0]).collect::<Vec<_>>().windows(2).find_map(rises),
            );
        }
        runner.count(&Overrides::new(), SIZE, sequence.name, wrong);
    }
}

/// A pipeline at its defaults, or a kind whose output is a value. Other kinds only have a history in front of them.
fn is_worth_a_thousand(runner: &CaseRunner<'_>) -> bool {
    runner.target.sweep && (runner.target.shows_value || !runner.target.is_kind)
}

fn shorten(inputs: &mut Vec<StressFrame>, is_heavy: bool) {
    if is_heavy {
        inputs.truncate(1 + FRAMES / FEWER);
        inputs.iter_mut().for_each(|frame| frame.dt *= FEWER as f32);
    }
}

/// True if the first output of the target is the exposure itself.
fn applies(runner: &CaseRunner<'_>, invariants: &Invariants) -> bool {
    invariants.is_exposure && invariants.settles && runner.target.shows_value
}

fn run(
    runner: &mut CaseRunner<'_>,
    configuration: &mut Configuration,
    graph: &Graph,
    name: &str,
    inputs: &[StressFrame],
) -> Option<Vec<Vec<OutputPixels>>> {
    let request = RenderRequest { target: runner.target, graph, size: SIZE, inputs, together: false };
    match runner.renderer.run(configuration, request) {
        Ok(ran) => Some(ran.frames),
        Err(why) => {
            runner.count(&Overrides::new(), SIZE, name, vec![why]);
            None
        }
    }
}

/// The fault of the last frame. Of a metering kind only the stops count: its other values follow the image at
/// once.
fn last(
    frames: &[Vec<OutputPixels>],
    expected: &[Vec<OutputPixels>],
    rule: &ExpectedFrame,
    is_kind: bool,
) -> Option<String> {
    let (frame, expected) = (frames.last()?, expected.last()?);
    let only_stops = |shown: &OutputPixels| match rule.always || !is_kind {
        true => shown.clone(),
        false => OutputPixels { pixels: vec![[shown.pixels[0][0], 0.0, 0.0, 0.0]], ..shown.clone() },
    };
    let pairs = frame.iter().zip(expected).map(|(a, b)| (only_stops(a), only_stops(b)));
    let mut wrong = pairs.filter_map(|(a, b)| different(&a, &b, rule.tolerance));
    wrong.next().map(|what| format!("after {} frames: {what}", frames.len()))
}

/// Under brighter frames the stops must not rise.
fn rises(stops: &[f32]) -> Option<String> {
    (stops[1] > stops[0] + 1e-4).then(|| format!("the exposure rises again from {} to {} stops", stops[0], stops[1]))
}

#[cfg(test)]
mod tests {
    use afterimage_graph::image::ColorState;

    use super::*;

    fn exposure(stops: f32, reading: f32) -> Vec<OutputPixels> {
        let (name, state, size) = ("exposure".into(), ColorState::Data, Size::new(1, 1));
        vec![OutputPixels { name, state, limit: None, size, pixels: vec![[stops, reading, 0.0, 1.0]] }]
    }

    #[test]
    fn late_frames_move_as_early_ones_do() {
        let frames = |stops: [f32; 2]| stops.map(|stops| exposure(stops, 0.0));
        let of = |early, late| moved(&frames(early), &frames(late));
        assert_eq!(of([1.0, 1.0], [1.0, 1.0]).or(of([1.0, 2.0], [7.0, 3.0])), None);
        assert_eq!(of([1.0, 2.0], [2.0, 2.0]).as_deref(), Some("`exposure` stands still"));
        assert_eq!(of([1.0, 1.0], [2.0, 2.0]), None, "it may change in more than a frame");
    }

    #[test]
    fn only_rising_stops_are_a_fault() {
        assert_eq!(rises(&[1.0, 1.0]).or(rises(&[1.0, 0.5])), None);
        assert!(rises(&[0.5, 0.6]).is_some_and(|what| what.contains("rises again from 0.5 to 0.6 stops")));
    }

    #[test]
    fn the_stops_of_a_metering_kind_must_settle_and_its_readings_need_not() {
        let frames = vec![exposure(0.0, 1.0), exposure(-2.0, 3.0)];
        let rule = |always| ExpectedFrame { inputs: Vec::new, tolerance: SETTLED, always };
        let found = |stops, reading, always| last(&frames, &[exposure(stops, reading)], &rule(always), true);
        assert_eq!(found(-2.001, 3.0, false), None);
        assert_eq!(found(-2.0, 7.0, false), None);
        assert!(found(-2.0, 7.0, true).is_some_and(|what| what.starts_with("after 2 frames: ")));
        assert!(found(-1.9, 3.0, false).is_some());
    }

    #[test]
    fn sequences_have_different_names_and_begin_with_a_reset() {
        for (index, sequence) in SEQUENCES.iter().enumerate() {
            assert!(SEQUENCES[..index].iter().all(|other| other.name != sequence.name));
            assert!((sequence.inputs)()[0].reset, "{}", sequence.name);
        }
    }
}
