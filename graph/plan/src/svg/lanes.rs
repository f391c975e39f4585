//! What stands above the memory: passes, barriers, bytes moved, and images with memory of their own.

use super::canvas::{Anchor, Canvas, Paint, width_of};
use super::{BAND, BARRIER, GREY, HAND_OVER, INK, LEFT, LINE, Picture};
use crate::print::mebibytes;
use crate::{BatchBarriers, Stage};
use afterimage_graph::node::{ImageId, Origin};

const LANE: f64 = 15.0;
const LONGEST_NAME: usize = 34;

fn name_of(picture: &Picture<'_>, pass: usize) -> String {
    let pass = &picture.plan.recording.passes[pass];
    let name = format!("{} · {}", pass.nodes.join("+"), pass.label);
    let long = name.chars().count() > LONGEST_NAME;
    if long { name.chars().take(LONGEST_NAME - 1).chain(['…']).collect() } else { name }
}

/// The room that the slanted names of the passes need.
pub(crate) fn height_of_names(picture: &Picture<'_>) -> f64 {
    let longest = (0..picture.plan.recording.passes.len()).map(|pass| name_of(picture, pass).chars().count()).max();
    // 0.79 is the sine of the slant.
    width_of(longest.unwrap_or(0), 10.0) * 0.79 + 18.0
}

fn heading(canvas: &mut Canvas, y: f64, text: &str) {
    canvas.text(LEFT - 12.0, y, 10.0, Anchor::End, Paint::plain(GREY), text);
}

/// Every other batch has a tinted ground.
pub(crate) fn bands(picture: &Picture<'_>, canvas: &mut Canvas, y: std::ops::Range<f64>) {
    for (number, batch) in picture.plan.batches.iter().enumerate() {
        let (left, right) = (picture.x(batch.start), picture.x(batch.end));
        if number % 2 == 0 {
            canvas.bar([left, y.start, right - left, y.end - y.start], BAND, None, "");
        }
    }
}

/// Passes as boxes with their names above and the numbers of the batches below; what is drawn and not dispatched has an edge.
pub(crate) fn passes(picture: &Picture<'_>, canvas: &mut Canvas, y: f64) {
    heading(canvas, y + 11.0, "passes");
    for (at, pass) in picture.plan.recording.passes.iter().enumerate() {
        let x = picture.x(at);
        let color = picture.color(pass.nodes.last().map_or("", String::as_str));
        let edge = (picture.plan.stages[at] == Stage::Fragment).then_some(INK);
        let hint = format!("{}: {}, {:?}", pass.nodes.join(" + "), pass.label, picture.plan.stages[at]);
        canvas.bar([x + 1.5, y, picture.column - 3.0, 15.0], color, edge, &hint);
        canvas.slanted(x + picture.column / 2.0 - 1.0, y - 7.0, 10.0, INK, &name_of(picture, at));
    }
    heading(canvas, y + 27.0, "batch");
    for (number, batch) in picture.plan.batches.iter().enumerate() {
        let middle = (picture.x(batch.start) + picture.x(batch.end)) / 2.0;
        canvas.text(middle, y + 27.0, 9.0, Anchor::Middle, Paint::plain(GREY), &number.to_string());
    }
}

/// At the beginning of each batch how many uses change and, in orange, how many images take over memory.
pub(crate) fn barriers(picture: &Picture<'_>, canvas: &mut Canvas, y: f64) {
    heading(canvas, y + 14.0, "barriers");
    heading(canvas, y + 31.0, "hand-overs");
    for (batch, barriers) in picture.plan.batches.iter().zip(&picture.plan.barriers) {
        let x = picture.x(batch.start) + 9.0;
        let BatchBarriers { transitions, aliasing } = barriers;
        if !transitions.is_empty() {
            canvas.disc(x, y + 10.0, 7.0, BARRIER, &transitions_hint(picture, barriers));
            number(canvas, x, y + 13.2, transitions.len());
        }
        if !aliasing.is_empty() {
            canvas.diamond(x, y + 27.0, 9.0, HAND_OVER, &hand_overs_hint(picture, barriers));
            number(canvas, x, y + 30.2, aliasing.len());
        }
    }
}

fn number(canvas: &mut Canvas, x: f64, y: f64, number: usize) {
    canvas.text(x, y, 9.0, Anchor::Middle, Paint::bold("#ffffff"), &number.to_string());
}

fn transitions_hint(picture: &Picture<'_>, barriers: &BatchBarriers) -> String {
    let line =
        |t: &crate::Transition| format!("{}: {} to {}", picture.names.of(t.resource), t.from.name(), t.to.name());
    barriers.transitions.iter().map(line).collect::<Vec<String>>().join("\n")
}

fn hand_overs_hint(picture: &Picture<'_>, barriers: &BatchBarriers) -> String {
    let name = |image: &ImageId| picture.names.images[image.0 as usize].clone();
    let line = |hand_over: &crate::AliasingBarrier| {
        let residents: Vec<String> = hand_over.residents.iter().map(name).collect();
        format!("{} follows {}", name(&hand_over.image), residents.join(", "))
    };
    barriers.aliasing.iter().map(line).collect::<Vec<String>>().join("\n")
}

/// Bytes that each pass moves, as columns.
pub(crate) fn moved(picture: &Picture<'_>, canvas: &mut Canvas, y: f64) {
    const HEIGHT: f64 = 44.0;
    let moved: Vec<u64> =
        (0..picture.plan.recording.passes.len()).map(|pass| picture.plan.bytes_moved_by(pass)).collect();
    let most = moved.iter().copied().max().unwrap_or(0).max(1);
    heading(canvas, y + 12.0, "moved");
    heading(canvas, y + 25.0, &format!("up to {}", mebibytes(most)));
    for (at, bytes) in moved.iter().enumerate() {
        let height = (HEIGHT * *bytes as f64 / most as f64).max(0.8);
        let nodes = &picture.plan.recording.passes[at].nodes;
        let color = picture.color(nodes.last().map_or("", String::as_str));
        let bar = [picture.x(at) + 3.0, y + HEIGHT - height, picture.column - 6.0, height];
        canvas.bar(bar, color, None, &mebibytes(*bytes));
    }
    canvas.line((LEFT, y + HEIGHT + 0.5), (picture.right(), y + HEIGHT + 0.5), LINE, false);
}

/// Images that take no part in the sharing of memory: of the host, of earlier frames, and constants.
fn with_own_memory(picture: &Picture<'_>) -> Vec<usize> {
    let plan = picture.plan;
    let own = |image: &usize| plan.lifetimes[*image].is_some() && plan.memory.requirement_of[*image].is_none();
    let mut images: Vec<usize> = (0..plan.recording.images.len()).filter(own).collect();
    images.sort_by_key(|image| {
        let rank = match plan.recording.images[*image].origin {
            Origin::Input(_) => 0,
            Origin::Previous { .. } => 1,
            Origin::Constant(_) => 2,
            Origin::Transient => 3,
        };
        (rank, *image)
    });
    images
}

pub(crate) fn height_of_kept(picture: &Picture<'_>) -> f64 {
    LANE * with_own_memory(picture).len() as f64
}

/// One lane for each image with memory of its own.
pub(crate) fn kept(picture: &Picture<'_>, canvas: &mut Canvas, y: f64) {
    for (lane, image) in with_own_memory(picture).into_iter().enumerate() {
        let Some((left, right)) = picture.life(image) else { continue };
        let y = y + LANE * lane as f64;
        let name = &picture.names.images[image];
        let desc = picture.plan.recording.images[image].desc;
        let text = format!("{name}  {} {}", desc.size, desc.format.name());
        heading(canvas, y + 9.5, picture.plan.origin_text(ImageId(image as u32)));
        canvas.bar([left + 1.5, y, right - left - 3.0, LANE - 3.0], picture.color(name), None, &text);
        // Nothing else is in the lane: what is too long for its bar stands beside it.
        let room = width_of(text.chars().count(), 9.0) + 8.0;
        let (x, anchor) = match () {
            () if room < right - left => (left + 6.0, Anchor::Start),
            () if right + room < picture.width() => (right + 3.0, Anchor::Start),
            () => (left - 4.0, Anchor::End),
        };
        canvas.text(x, y + 9.2, 9.0, anchor, Paint::plain(INK), &text);
    }
}
