//! Frames after frames: what is remembered must be finite, follow, and forget.

use afterimage_graph::check::Graph;
use afterimage_graph::image::Size;

use super::images::Extreme;
use super::lab::{Shot, Shown};
use super::promises::Promises;
use super::run::{Stand, judge};
use super::subject::Sets;
use super::verdicts::{Tolerance, different};

/// The name of the long sequence.
const LONG: &str = "thousand-frames";
/// Its length.
const FRAMES: usize = 1000;
/// How much shorter it is, with longer steps, where each frame takes long.
const FEWER: usize = 10;
/// A usual step of time.
const STEP: f32 = 1.0 / 60.0;
const SIZE: Size = Size { width: 17, height: 13, depth: 1 };
/// Adaptation in stops has settled when it is as near as this.
const SETTLED: Tolerance = Tolerance { share: 2e-3, beside: 4e-3 };
/// Rounding of 32-bit numbers between two frames that ought to be equal.
const STILL: Tolerance = Tolerance { share: 1e-5, beside: 1e-5 };

/// A sequence with a name for `--case`.
struct Sequence {
    name: &'static str,
    shots: fn() -> Vec<Shot>,
    /// The frames whose last one it must end like.
    wanted: Option<Wanted>,
}

/// What the last frame must look like.
struct Wanted {
    shots: fn() -> Vec<Shot>,
    tolerance: Tolerance,
    /// Whether it holds for every graph, not only for those that follow.
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
        shots: || vec![first("grey"), stepped("bright", 0.0)],
        wanted: Some(Wanted { shots: || vec![first("grey"), stepped("grey", 0.0)], tolerance: STILL, always: false }),
    },
    Sequence {
        name: "time-backwards",
        shots: || vec![first("grey"), stepped("bright", -1.0), stepped("bright", f32::NAN)],
        wanted: Some(Wanted { shots: || vec![first("grey"), stepped("grey", 0.0)], tolerance: STILL, always: false }),
    },
    Sequence { name: "time-tiny", shots: || vec![first("grey"), stepped("bright", 1e-6)], wanted: None },
    Sequence {
        name: "time-huge",
        shots: || vec![first("grey"), stepped("bright", 1e6)],
        wanted: Some(Wanted { shots: || vec![first("bright"), shot("bright")], tolerance: SETTLED, always: false }),
    },
    Sequence {
        name: LONG,
        shots: || [first("grey")].into_iter().chain(vec![shot("bright"); FRAMES]).collect(),
        wanted: Some(Wanted { shots: || vec![first("bright"); 2], tolerance: SETTLED, always: false }),
    },
    Sequence {
        name: "cut",
        shots: || vec![first("edge"), shot("all-inf"), first("grey")],
        wanted: Some(Wanted { shots: || vec![first("grey"); 3], tolerance: Tolerance::NONE, always: true }),
    },
    Sequence {
        name: "poisoned-frame",
        shots: || vec![first("grey"), shot("all-nan"), shot("nan"), shot("bright")],
        wanted: Some(Wanted {
            shots: || {
                let clean = |name| Shot { guarded: true, ..shot(name) };
                vec![first("grey"), clean("all-nan"), clean("nan"), shot("bright")]
            },
            tolerance: Tolerance::NONE,
            always: true,
        }),
    },
];

/// Whether a case of this name is a sequence.
pub(crate) fn is_sequence(name: &str) -> bool {
    SEQUENCES.iter().any(|sequence| sequence.name == name)
}

/// The names of all sequences.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    SEQUENCES.iter().map(|sequence| sequence.name)
}

/// Runs the sequences if the graph remembers anything.
pub(crate) fn sequences(stand: &mut Stand<'_, '_>, graph: &Graph) {
    let bench = stand.lab.bench(|_, _| {}, false);
    if !bench.remembers(stand.subject, graph, SIZE) {
        return;
    }
    let promises = Promises::of(graph);
    let is_slow = stand.choice.quick && stand.is_heavy && stand.choice.case.is_none();
    let is_wanted = |sequence: &&Sequence| {
        stand.choice.accepts(sequence.name)
            && (!is_slow || sequence.wanted.as_ref().is_some_and(|wanted| wanted.always))
    };
    let wanted: Vec<&Sequence> = SEQUENCES.iter().filter(is_wanted).collect();
    for sequence in wanted {
        // A new bench each time: noise goes by the number of the frame.
        let mut shots = (sequence.shots)();
        if sequence.name == LONG {
            if !is_worth_a_thousand(stand) {
                continue;
            }
            shorten(&mut shots, stand.is_heavy);
        }
        let Some(frames) = run(stand, graph, sequence.name, &shots) else { continue };
        let mut wrong: Vec<String> = frames.iter().flatten().flat_map(|shown| judge(shown, false)).take(1).collect();
        if let Some(wanted) = sequence.wanted.as_ref().filter(|wanted| wanted.always || applies(stand, &promises)) {
            let Some(others) = run(stand, graph, sequence.name, &(wanted.shots)()) else { continue };
            wrong.extend(last(&frames, &others, wanted, stand.subject.is_kind));
            stand.tally.judged(sequence.name);
        }
        if sequence.name == LONG && applies(stand, &promises) {
            wrong.extend(
                frames.iter().map(|frame| frame[0].pixels[0][0]).collect::<Vec<_>>().windows(2).find_map(turns),
            );
        }
        stand.count(&Sets::new(), SIZE, sequence.name, wrong);
    }
}

/// A pipeline at its defaults, or what remembers itself: others only have something that remembers before them.
fn is_worth_a_thousand(stand: &Stand<'_, '_>) -> bool {
    stand.subject.sweep && (stand.subject.shows_value || !stand.subject.is_kind)
}

fn shorten(shots: &mut Vec<Shot>, is_heavy: bool) {
    if is_heavy {
        shots.truncate(1 + FRAMES / FEWER);
        shots.iter_mut().for_each(|shot| shot.dt *= FEWER as f32);
    }
}

/// Whether the first output of the subject is the exposure itself.
fn applies(stand: &Stand<'_, '_>, promises: &Promises) -> bool {
    promises.follows && stand.subject.shows_value
}

fn run(stand: &mut Stand<'_, '_>, graph: &Graph, name: &str, shots: &[Shot]) -> Option<Vec<Vec<Shown>>> {
    let mut bench = stand.lab.bench(|_, _| {}, false);
    match stand.lab.run(&mut bench, (stand.subject, graph), SIZE, shots, false) {
        Ok(ran) => Some(ran.frames),
        Err(why) => {
            stand.count(&Sets::new(), SIZE, name, vec![why]);
            None
        }
    }
}

/// What is wrong with the last frame. Of a metering kind only the stops count: its other numbers follow the picture at once.
fn last(frames: &[Vec<Shown>], wanted: &[Vec<Shown>], rule: &Wanted, is_kind: bool) -> Option<String> {
    let (frame, wanted) = (frames.last()?, wanted.last()?);
    let only_stops = |shown: &Shown| match rule.always || !is_kind {
        true => shown.clone(),
        false => Shown { pixels: vec![[shown.pixels[0][0], 0.0, 0.0, 0.0]], ..shown.clone() },
    };
    let pairs = frame.iter().zip(wanted).map(|(a, b)| (only_stops(a), only_stops(b)));
    let mut wrong = pairs.filter_map(|(a, b)| different(&a, &b, rule.tolerance));
    wrong.next().map(|what| format!("after {} frames: {what}", frames.len()))
}

/// Brighter frames only ever bring the stops down.
fn turns(stops: &[f32]) -> Option<String> {
    (stops[1] > stops[0] + 1e-4).then(|| format!("the exposure turns back from {} to {} stops", stops[0], stops[1]))
}
