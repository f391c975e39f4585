//! The memory of transient images: bars at their offsets, and how many bytes live in each batch.

use afterimage_base::svg::{Anchor, Canvas, Paint};

use super::picture::{BOUND, GRAY, INK, LEFT, LINE, Picture};
use super::text::fitting;
use crate::options::Alias;
use crate::plan::PlannedImage;
use crate::report::units::mebibytes;

/// The height of the heap on paper.
pub(crate) const HEIGHT: f64 = 420.0;
/// The height of the profile of live bytes.
pub(crate) const ALIVE_HEIGHT: f64 = 84.0;

/// Images as bars: as long as they live, as high as their bytes, at their places in the heap.
pub(crate) fn memory(picture: &Picture<'_>, canvas: &mut Canvas, y: f64) {
    let places = places(picture);
    let top = places.iter().flatten().map(|(offset, bytes)| offset + bytes).max().unwrap_or(0);
    let scale = HEIGHT / top.max(1) as f64;
    let title = match picture.plan.options.alias {
        Alias::Placed => "the heap: transient images at their offsets",
        Alias::Pool => "the pool: images with equal descriptions share a texture",
        Alias::None => "transient images, each with its own memory",
    };
    canvas.text((LEFT, y - 10.0), 11.0, Anchor::Start, Paint::bold(INK), title);
    axis(picture, canvas, y, top, scale);
    for (image, place) in places.iter().enumerate() {
        let (Some((offset, bytes)), Some((left, right))) = (place, picture.life(image)) else { continue };
        let height = (*bytes as f64 * scale).max(1.5);
        let lower = y + HEIGHT - *offset as f64 * scale;
        bar(picture, canvas, image, [left + 1.0, lower - height, right - left - 2.0, height]);
    }
    bound(picture, canvas, y + HEIGHT - picture.plan.memory.lower_bound as f64 * scale, "lower bound");
}

/// Offset and bytes of each image: in the heap, or in textures laid one upon the other.
fn places(picture: &Picture<'_>) -> Vec<Option<(u64, u64)>> {
    let images = || picture.plan.images.iter();
    let bytes = |image: &PlannedImage| Some(image.requirement?.bytes);
    if picture.plan.options.alias == Alias::Placed {
        return images().map(|image| Some((image.offset?, bytes(image)?))).collect();
    }
    let mut slots = vec![0; picture.plan.memory.slots.len()];
    for (slot, bytes) in images().filter_map(|image| Some((image.slot?, bytes(image)?))) {
        slots[slot as usize] = bytes;
    }
    let mut end = 0;
    for slot in &mut slots {
        let start = end;
        end += *slot;
        *slot = start;
    }
    images().map(|image| Some((slots[image.slot? as usize], bytes(image)?))).collect()
}

fn bar(picture: &Picture<'_>, canvas: &mut Canvas, image: usize, place: [f64; 4]) {
    let [x, y, width, height] = place;
    let name = &picture.names.images[image];
    let desc = picture.plan.images[image].desc;
    let text = format!("{} {}", desc.size, desc.format.name());
    let edge = if height > 4.0 { Some("#ffffff") } else { None };
    canvas.bar(place, picture.color(name), edge, &format!("{name}\n{text}\n{}", mebibytes(desc.bytes())));
    let (middle, size) = (y + height / 2.0, height.clamp(7.0, 10.0));
    if height >= 28.0 {
        canvas.text((x + 5.0, middle - 2.0), 10.0, Anchor::Start, Paint::bold(INK), &fitting(name, width - 8.0, 10.0));
        canvas.text((x + 5.0, middle + 10.0), 8.5, Anchor::Start, INK, &fitting(&text, width - 8.0, 8.5));
    } else if height >= 8.0 {
        canvas.text((x + 5.0, middle + size * 0.36), size, Anchor::Start, INK, &fitting(name, width - 8.0, size));
    }
}

/// Lines at round numbers of MiB.
fn axis(picture: &Picture<'_>, canvas: &mut Canvas, y: f64, top: u64, scale: f64) {
    let step = round_step(top);
    let ticks = (0..).map(|tick| tick * step).take_while(|bytes| *bytes <= top);
    for bytes in ticks {
        let y = y + HEIGHT - bytes as f64 * scale;
        canvas.line((LEFT, y), (picture.right(), y), LINE, false);
        canvas.text((LEFT - 12.0, y + 3.5), 10.0, Anchor::End, GRAY, &mebibytes(bytes));
    }
}

/// The step between lines: a power of two of KiB that leaves four to eight lines.
fn round_step(top: u64) -> u64 {
    (top / 6).next_power_of_two().max(1024)
}

fn bound(picture: &Picture<'_>, canvas: &mut Canvas, y: f64, text: &str) {
    canvas.line((LEFT, y), (picture.right() + 8.0, y), BOUND, true);
    canvas.text((picture.right() + 12.0, y + 3.5), 10.0, Anchor::Start, BOUND, text);
}

/// Bytes that live in each batch.
pub(crate) fn alive(picture: &Picture<'_>, canvas: &mut Canvas, y: f64) {
    let plan = picture.plan;
    let mut alive = vec![0_u64; plan.batches.len()];
    for image in &plan.images {
        if let (Some(wants), Some(lifetime)) = (image.requirement, image.lifetime) {
            alive[lifetime.first..=lifetime.last].iter_mut().for_each(|bytes| *bytes += wants.bytes);
        }
    }
    let most = plan.memory.lower_bound.max(1);
    let base = y + ALIVE_HEIGHT;
    let mut points = vec![(picture.right(), base), (LEFT, base)];
    for (batch, bytes) in plan.batches.iter().zip(&alive) {
        let top = base - ALIVE_HEIGHT * *bytes as f64 / most as f64;
        points.extend([(picture.x(batch.passes.start), top), (picture.x(batch.passes.end), top)]);
    }
    canvas.text((LEFT, y - 10.0), 11.0, Anchor::Start, Paint::bold(INK), "bytes alive");
    canvas.area(&points, "#d9e2ec", "#829ab1");
    canvas.text((LEFT - 12.0, y + 4.0), 10.0, Anchor::End, GRAY, &mebibytes(plan.memory.lower_bound));
    canvas.text((LEFT - 12.0, base + 3.5), 10.0, Anchor::End, GRAY, &mebibytes(0));
    bound(picture, canvas, y, &mebibytes(plan.memory.lower_bound));
}
