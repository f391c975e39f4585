//! The same picture in every way of making it: dispatched and drawn, fused and not, in tiles and not.

use afterimage_graph::image::{ColorState, Size};
use afterimage_plan::{Alias, Caps, Options};

use super::images::Extreme;
use super::lab::{Bench, Ran, Shot};
use super::promises::Promises;
use super::run::{Stand, judge};
use super::settings::Change;
use super::subject::Sets;
use super::verdicts::{Tolerance, different};

/// A way of making pictures, by what it changes.
struct Way {
    name: &'static str,
    change: fn(&mut Caps, &mut Options),
}

const WAYS: [Way; 5] = [
    Way { name: "when drawn", change: |caps, _| caps.prefer_fragment = true },
    Way { name: "when not fused", change: |_, options| options.fuse = false },
    Way { name: "when made in tiles", change: |caps, _| caps.tiles = true },
    Way { name: "with subgroups", change: |_, options| options.subgroups = true },
    Way { name: "with memory of its own for each image", change: |_, options| options.alias = Alias::None },
];

/// Images with all magnitudes and edges in them.
const TELLING: [&str; 4] = ["nan", "edge", "ramp", "primaries"];
/// At one pixel every tap is the edge; odd sides have halves that do not fit.
const SIZES: [(u32, u32); 2] = [(37, 23), (1, 1)];

/// Intermediates are in 32 bits, so what is left are roundings of 32-bit numbers; an encoded picture may be one code off.
fn tolerance(state: ColorState) -> Tolerance {
    let code = 1.01 / 255.0;
    Tolerance { share: 2e-3, beside: if state == ColorState::Encoded { code } else { 1e-3 } }
}

/// Compares all ways at the defaults and at every choice and whole number: these change what is compiled.
pub(crate) fn compare(stand: &mut Stand<'_, '_>, changes: &[Change]) {
    let images: Vec<Extreme> =
        TELLING.iter().filter(|name| stand.choice.accepts(name)).filter_map(|n| Extreme::named(n)).collect();
    if images.is_empty() {
        return;
    }
    let exactly = |change: fn(&mut Caps, &mut Options)| {
        move |caps: &mut Caps, options: &mut Options| {
            *options = Options { exact: true, ..*options };
            caps.tiles = false;
            change(caps, options);
        }
    };
    let mut plain = stand.lab.bench(exactly(|_, _| {}), false);
    let mut others: Vec<(&'static str, Bench)> =
        WAYS.iter().map(|way| (way.name, stand.lab.bench(exactly(way.change), false))).collect();
    let sizes = match (stand.choice.size, stand.choice.quick) {
        (Some((width, height)), _) => vec![Size::new(width, height)],
        (None, quick) => SIZES.iter().take(if quick { 1 } else { 2 }).map(|(w, h)| Size::new(*w, *h)).collect(),
    };
    let only_defaults = stand.choice.quick || stand.is_heavy;
    let is_wanted = |change: &&Change| is_compiled(change) && (change.sets.is_empty() || !only_defaults);
    for change in changes.iter().filter(is_wanted) {
        for size in &sizes {
            one(stand, &mut plain, &mut others, &change.sets, *size, &images);
        }
    }
}

/// Whether a change may choose other shaders: names, whole numbers and flags do, fractions only change uniforms.
fn is_compiled(change: &Change) -> bool {
    change.is_single && change.sets.iter().all(|(_, value)| !value.contains('.'))
}

fn one(
    stand: &mut Stand<'_, '_>,
    plain: &mut Bench,
    others: &mut [(&'static str, Bench)],
    sets: &Sets,
    size: Size,
    images: &[Extreme],
) {
    let Ok(graph) = stand.subject.graph(stand.registry, sets) else { return };
    let shots: Vec<Shot> = images.iter().map(|image| Shot::still(*image)).collect();
    let subject = (stand.subject, &graph);
    // What fails in itself has been told by the stills.
    let Ok(wanted) = stand.lab.run(plain, subject, size, &shots, true) else { return };
    // In 32 bits nothing hides a number that a half float cannot hold: some devices round those to the largest one.
    let signed = Promises::of(&graph).negative;
    let mut wrong: Vec<Vec<String>> =
        wanted.frames.iter().map(|frame| frame.iter().flat_map(|shown| judge(shown, signed)).collect()).collect();
    for (name, bench) in others.iter_mut() {
        match stand.lab.run(bench, subject, size, &shots, true) {
            Ok(ran) => {
                images.iter().for_each(|_| stand.tally.judged(name));
                differences(&ran, &wanted).for_each(|(index, what)| wrong[index].push(format!("{name}: {what}")))
            }
            Err(why) => wrong[0].push(format!("{name}: {why}")),
        }
    }
    for (image, wrong) in images.iter().zip(wrong) {
        stand.count(sets, size, image.name, wrong);
    }
}

/// The first difference of each output of each frame.
fn differences<'r>(ran: &'r Ran, wanted: &'r Ran) -> impl Iterator<Item = (usize, String)> + 'r {
    ran.frames.iter().zip(&wanted.frames).enumerate().flat_map(|(index, (frame, wanted))| {
        let pairs = frame.iter().zip(wanted);
        pairs.filter_map(move |(a, b)| Some((index, different(a, b, tolerance(a.state).leaking(a))?)))
    })
}
