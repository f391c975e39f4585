//! Sequences: histories must stay finite, follow the images, and start again at a reset.

use afterimage_graph::check::Graph;
use afterimage_graph::image::Size;
use afterimage_graph::node::Invariants;

use super::case_runner::{CaseRunner, judge};
use super::images::Extreme;
use super::promises::promises;
use super::render::{OutputPixels, RenderRequest, Shot};
use super::subject::Overrides;
use super::verdicts::{Tolerance, different};

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

/// A sequence with a name for `--case`.
struct Sequence {
    name: &'static str,
    shots: fn() -> Vec<Shot>,
    /// The frames whose last one its last one must equal.
    expected: Option<ExpectedFrame>,
}

/// What the last frame must equal.
struct ExpectedFrame {
    shots: fn() -> Vec<Shot>,
    tolerance: Tolerance,
    /// Whether it is required of every graph, not only of those that follow the brightness.
    always: bool,
}

fn shot(name: &str) -> Shot {
    Shot { dt: STEP, reset: false, ..Shot::still(Extreme::named(name).expect("an image of that name")) }
}

fn first(name: &str) -> Shot {
    Shot { reset: true, ..shot(name) }
}

fn stepped(name: &str, dt: f32) -> Shot {
    Shot { dt, ..shot(name) }
}

const SEQUENCES: [Sequence; 7] = [
    Sequence {
        name: "time-zero",
        shots: || vec![first("gray"), stepped("bright", 0.0)],
        expected: Some(ExpectedFrame {
            shots: || vec![first("gray"), stepped("gray", 0.0)],
            tolerance: STILL,
            always: false,
        }),
    },
    Sequence {
        name: "time-backwards",
        shots: || vec![first("gray"), stepped("bright", -1.0), stepped("bright", f32::NAN)],
        expected: Some(ExpectedFrame {
            shots: || vec![first("gray"), stepped("gray", 0.0)],
            tolerance: STILL,
            always: false,
        }),
    },
    Sequence { name: "time-tiny", shots: || vec![first("gray"), stepped("bright", 1e-6)], expected: None },
    Sequence {
        name: "time-huge",
        shots: || vec![first("gray"), stepped("bright", 1e6)],
        expected: Some(ExpectedFrame {
            shots: || vec![first("bright"), shot("bright")],
            tolerance: SETTLED,
            always: false,
        }),
    },
    Sequence {
        name: LONG,
        shots: || [first("gray")].into_iter().chain(vec![shot("bright"); FRAMES]).collect(),
        expected: Some(ExpectedFrame { shots: || vec![first("bright"); 2], tolerance: SETTLED, always: false }),
    },
    Sequence {
        name: "cut",
        shots: || vec![first("edge"), shot("all-inf"), first("gray")],
        expected: Some(ExpectedFrame { shots: || vec![first("gray"); 3], tolerance: Tolerance::NONE, always: true }),
    },
    Sequence {
        name: "bad-frame",
        shots: || vec![first("gray"), shot("all-nan"), shot("nan"), shot("bright")],
        expected: Some(ExpectedFrame {
            shots: || {
                let clean = |name| Shot { sanitized: true, ..shot(name) };
                vec![first("gray"), clean("all-nan"), clean("nan"), shot("bright")]
            },
            tolerance: Tolerance::NONE,
            always: true,
        }),
    },
];

/// The names of all sequences.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    SEQUENCES.iter().map(|sequence| sequence.name)
}

/// Runs the sequences if the graph has histories.
pub(crate) fn sequences(runner: &mut CaseRunner<'_>, graph: &Graph) {
    let mut configuration = runner.renderer.configure(|_, _| {}, false);
    if !configuration.has_histories(runner.subject, graph, SIZE) {
        return;
    }
    let promises = promises(graph);
    let is_slow = runner.options.quick && runner.is_heavy && runner.options.case.is_none();
    let is_chosen = |sequence: &&Sequence| {
        runner.options.accepts(sequence.name)
            && (!is_slow || sequence.expected.as_ref().is_some_and(|expected| expected.always))
    };
    let chosen: Vec<&Sequence> = SEQUENCES.iter().filter(is_chosen).collect();
    for sequence in chosen {
        // A new configuration for each sequence: noise depends on the number of the frame.
        let mut shots = (sequence.shots)();
        if sequence.name == LONG {
            if !is_worth_a_thousand(runner) {
                continue;
            }
            shorten(&mut shots, runner.is_heavy);
        }
        let Some(frames) = run(runner, graph, sequence.name, &shots) else { continue };
        let mut wrong: Vec<String> = frames.iter().flatten().flat_map(|shown| judge(shown, true)).take(1).collect();
        if let Some(expected) =
            sequence.expected.as_ref().filter(|expected| expected.always || applies(runner, &promises))
        {
            let Some(others) = run(runner, graph, sequence.name, &(expected.shots)()) else { continue };
            wrong.extend(last(&frames, &others, expected, runner.subject.is_kind));
            runner.tally.judged(sequence.name);
        }
        if sequence.name == LONG && applies(runner, &promises) {
            wrong.extend(
                frames.iter().map(|frame| frame[0].pixels[0][0]).collect::<Vec<_>>().windows(2).find_map(rises),
            );
        }
        runner.count(&Overrides::new(), SIZE, sequence.name, wrong);
    }
}

/// A pipeline at its defaults, or a kind whose output is a value. Other kinds only have a history in front of them.
fn is_worth_a_thousand(runner: &CaseRunner<'_>) -> bool {
    runner.subject.sweep && (runner.subject.shows_value || !runner.subject.is_kind)
}

fn shorten(shots: &mut Vec<Shot>, is_heavy: bool) {
    if is_heavy {
        shots.truncate(1 + FRAMES / FEWER);
        shots.iter_mut().for_each(|shot| shot.dt *= FEWER as f32);
    }
}

/// Whether the first output of the subject is the exposure itself.
fn applies(runner: &CaseRunner<'_>, promises: &Invariants) -> bool {
    promises.is_exposure && promises.settles && runner.subject.shows_value
}

fn run(runner: &mut CaseRunner<'_>, graph: &Graph, name: &str, shots: &[Shot]) -> Option<Vec<Vec<OutputPixels>>> {
    let mut configuration = runner.renderer.configure(|_, _| {}, false);
    let request = RenderRequest { subject: runner.subject, graph, size: SIZE, shots, together: false };
    match runner.renderer.run(&mut configuration, request) {
        Ok(ran) => Some(ran.frames),
        Err(why) => {
            runner.count(&Overrides::new(), SIZE, name, vec![why]);
            None
        }
    }
}

/// What is wrong with the last frame. Of a metering kind only the stops count: its other values follow the image at
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
