//! The lanes above the heap: passes, barriers, bytes moved, and images with memory of their own.

use afterimage_base::svg::{Anchor, Canvas, Paint};
use afterimage_graph::node::{ImageId, Origin};

use super::picture::{ALIASING, BAND, BARRIER, GRAY, INK, LEFT, LINE, Picture};
use super::text::width_of;
use crate::plan::{AliasingBarrier, Batch, PlannedPass, Stage, Transition};
use crate::report::units::mebibytes;

const LANE: f64 = 15.0;
const MAX_NAME: usize = 34;

fn name_of(picture: &Picture<'_>, pass: usize) -> String {
    let pass = &picture.plan.passes[pass].pass;
    let name = format!("{} · {}", pass.nodes.join("+"), pass.label);
    let long = name.chars().count() > MAX_NAME;
    if long { name.chars().take(MAX_NAME - 1).chain(['…']).collect() } else { name }
}

/// The height of the slanted names of the passes.
pub(crate) fn height_of_names(picture: &Picture<'_>) -> f64 {
    let longest = (0..picture.plan.passes.len()).map(|pass| name_of(picture, pass).chars().count()).max();
    // 0.79 is the sine of the slant.
    width_of(longest.unwrap_or(0), 10.0) * 0.79 + 18.0
}

fn heading(canvas: &mut Canvas, y: f64, text: &str) {
    canvas.text((LEFT - 12.0, y), 10.0, Anchor::End, GRAY, text);
}

/// Every other batch has a tinted ground.
pub(crate) fn bands(picture: &Picture<'_>, canvas: &mut Canvas, y: std::ops::Range<f64>) {
    for batch in picture.plan.batches.iter().step_by(2) {
        let (left, right) = (picture.x(batch.passes.start), picture.x(batch.passes.end));
        canvas.bar([left, y.start, right - left, y.end - y.start], BAND, None, "");
    }
}

/// Passes as boxes with their names above and the numbers of the batches below; what is drawn and not dispatched has an
/// edge.
pub(crate) fn passes(picture: &Picture<'_>, canvas: &mut Canvas, y: f64) {
    heading(canvas, y + 11.0, "passes");
    for (at, PlannedPass { pass, stage, .. }) in picture.plan.passes.iter().enumerate() {
        let x = picture.x(at);
        let color = picture.color(pass.nodes.last().map_or("", String::as_str));
        let edge = (*stage != Stage::Compute).then_some(INK);
        let hint = format!("{}: {}, {:?}", pass.nodes.join(" + "), pass.label, stage);
        canvas.bar([x + 1.5, y, picture.column - 3.0, 15.0], color, edge, &hint);
        canvas.slanted_text((x + picture.column / 2.0 - 1.0, y - 7.0), 10.0, INK, &name_of(picture, at));
    }
    heading(canvas, y + 27.0, "batch");
    for (number, batch) in picture.plan.batches.iter().enumerate() {
        let middle = (picture.x(batch.passes.start) + picture.x(batch.passes.end)) / 2.0;
        canvas.text((middle, y + 27.0), 9.0, Anchor::Middle, GRAY, &number.to_string());
    }
}

/// At the beginning of each batch how many uses change and, in orange, how many images reuse memory of others.
pub(crate) fn barriers(picture: &Picture<'_>, canvas: &mut Canvas, y: f64) {
    heading(canvas, y + 14.0, "barriers");
    heading(canvas, y + 31.0, "aliasing");
    for batch in &picture.plan.batches {
        let Batch { passes, transitions, aliasing } = batch;
        let x = picture.x(passes.start) + 9.0;
        if !transitions.is_empty() {
            canvas.dot((x, y + 10.0), 7.0, BARRIER, None, &transitions_hint(picture, batch));
            number(canvas, x, y + 13.2, transitions.len());
        }
        if !aliasing.is_empty() {
            canvas.diamond((x, y + 27.0), 9.0, ALIASING, &aliasing_hint(picture, batch));
            number(canvas, x, y + 30.2, aliasing.len());
        }
    }
}

fn number(canvas: &mut Canvas, x: f64, y: f64, number: usize) {
    canvas.text((x, y), 9.0, Anchor::Middle, Paint::bold("#ffffff"), &number.to_string());
}

fn transitions_hint(picture: &Picture<'_>, batch: &Batch) -> String {
    let line = |t: &Transition| format!("{}: {:?} to {:?}", picture.names.of(t.resource), t.from, t.to);
    batch.transitions.iter().map(line).collect::<Vec<String>>().join("\n")
}

fn aliasing_hint(picture: &Picture<'_>, batch: &Batch) -> String {
    let line = |barrier: &AliasingBarrier| {
        let owners: Vec<&str> = barrier.owners.iter().map(|image| picture.names.image(*image)).collect();
        format!("{} follows {}", picture.names.image(barrier.image), owners.join(", "))
    };
    batch.aliasing.iter().map(line).collect::<Vec<String>>().join("\n")
}

/// Bytes that each pass moves, as columns.
pub(crate) fn moved(picture: &Picture<'_>, canvas: &mut Canvas, y: f64) {
    const HEIGHT: f64 = 44.0;
    let moved: Vec<u64> = (0..picture.plan.passes.len()).map(|pass| picture.plan.bytes_moved_by(pass)).collect();
    let most = moved.iter().copied().max().unwrap_or(0).max(1);
    heading(canvas, y + 12.0, "moved");
    heading(canvas, y + 25.0, &format!("up to {}", mebibytes(most)));
    for (at, bytes) in moved.iter().enumerate() {
        let height = (HEIGHT * *bytes as f64 / most as f64).max(0.8);
        let nodes = &picture.plan.passes[at].pass.nodes;
        let color = picture.color(nodes.last().map_or("", String::as_str));
        let bar = [picture.x(at) + 3.0, y + HEIGHT - height, picture.column - 6.0, height];
        canvas.bar(bar, color, None, &mebibytes(*bytes));
    }
    canvas.line((LEFT, y + HEIGHT + 0.5), (picture.right(), y + HEIGHT + 0.5), LINE, false);
}

/// Images that share no memory: of the host, of earlier frames, and constants.
fn with_own_memory(picture: &Picture<'_>) -> Vec<usize> {
    let plan = picture.plan;
    let own = |image: &usize| plan.images[*image].lifetime.is_some() && plan.images[*image].requirement.is_none();
    let mut images: Vec<usize> = (0..plan.images.len()).filter(own).collect();
    images.sort_by_key(|image| {
        let rank = match plan.images[*image].origin {
            Origin::Input(_) => 0,
            Origin::Previous { .. } => 1,
            Origin::Constant(_) | Origin::Retained => 2,
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
        let desc = picture.plan.images[image].desc;
        let text = format!("{name}  {} {}", desc.size, desc.format.name());
        heading(canvas, y + 9.5, origin(picture, image));
        canvas.bar([left + 1.5, y, right - left - 3.0, LANE - 3.0], picture.color(name), None, &text);
        // Nothing else is in the lane: what is too long for its bar stands next to it.
        let room = width_of(text.chars().count(), 9.0) + 8.0;
        let (x, anchor) = match () {
            () if room < right - left => (left + 6.0, Anchor::Start),
            () if right + room < picture.width() => (right + 3.0, Anchor::Start),
            () => (left - 4.0, Anchor::End),
        };
        canvas.text((x, y + 9.2), 9.0, anchor, INK, &text);
    }
}

/// The origin of an image, in a word or two.
fn origin(picture: &Picture<'_>, image: usize) -> &'static str {
    let is_output = picture.plan.outputs.iter().any(|output| output.image == ImageId(image as u32));
    match picture.plan.images[image].origin {
        Origin::Input(_) => "input",
        Origin::Constant(_) => "constant",
        Origin::Retained => "retained",
        Origin::Previous { .. } => "earlier frame",
        Origin::Transient if is_output => "output",
        Origin::Transient if picture.plan.images[image].requirement.is_none() => "history",
        Origin::Transient => "transient",
    }
}
