//! Drawing passes: attachments fit together, what is kept or read was drawn, and what is read was stored.

use std::collections::BTreeSet;

use super::walk::{Faults, Walk};
use afterimage_graph::node::{
    Arg, DepthAttachment, Drawing, Draws, Geometry, ImageId, IndirectDraws, Load, Resource, Subresource,
};

pub(super) fn check(walk: &Walk<'_>, faults: &mut Faults) {
    let mut drawn: BTreeSet<Subresource> = BTreeSet::new();
    // The images of which nothing is left.
    let mut dropped: BTreeSet<ImageId> = BTreeSet::new();
    for (number, planned) in walk.plan.passes.iter().enumerate() {
        let name = &walk.passes[number];
        for part in planned.pass.args().flat_map(|arg| parts(walk, arg)).filter(|part| !drawn.contains(part)) {
            faults.add(format!("pass `{name}` reads {}, which no pass has drawn", part_name(walk, part)));
        }
        for image in planned.pass.args().filter_map(Arg::read).filter_map(|read| read.image()) {
            check_stored(walk, name, image, &dropped, faults);
        }
        let Some(drawing) = planned.pass.drawing() else { continue };
        check_attachments(walk, name, drawing, faults);
        drawing.geometry().into_iter().for_each(|geometry| check_ranges(walk, name, geometry, faults));
        for kept in kept(drawing) {
            check_stored(walk, name, kept.image, &dropped, faults);
        }
        let targets = targets(drawing);
        if planned.stores.len() != targets.len() {
            faults.add(format!("pass `{name}` has {} attachments and stores {:?}", targets.len(), planned.stores));
        }
        for (target, stores) in targets.iter().zip(&planned.stores) {
            drawn.insert(*target);
            if *stores {
                dropped.remove(&target.image)
            } else {
                dropped.insert(target.image)
            };
        }
    }
    for output in walk.plan.outputs.iter().filter(|output| dropped.contains(&output.image)) {
        faults.add(format!(
            "`{}`, which is the output `{}`, is not stored",
            image_name(walk, output.image),
            output.name
        ));
    }
}

fn image_name<'w>(walk: &'w Walk<'_>, image: ImageId) -> &'w str {
    &walk.images[image.0 as usize]
}

fn part_name(walk: &Walk<'_>, part: Subresource) -> String {
    format!("level {} of layer {} of `{}`", part.level, part.layer, image_name(walk, part.image))
}

fn check_stored(walk: &Walk<'_>, pass: &str, image: ImageId, dropped: &BTreeSet<ImageId>, faults: &mut Faults) {
    if dropped.contains(&image) {
        faults.add(format!("pass `{pass}` reads `{}`, which was not stored", image_name(walk, image)));
    }
}

/// Colors, then depth.
fn targets(drawing: &Drawing) -> Vec<Subresource> {
    let colors = drawing.colors.iter().map(|color| color.target);
    colors.chain(drawing.depth.as_ref().map(|depth| depth.target)).collect()
}

fn kept(drawing: &Drawing) -> Vec<Subresource> {
    let colors = drawing.colors.iter().filter(|color| color.load == Load::Keep).map(|color| color.target);
    let depth = drawing.depth.iter().filter(|depth| depth.test.load == Load::Keep).map(|depth| depth.target);
    colors.chain(depth).collect()
}

/// Attachments have one size and one number of samples, and the depth alone has a format of depth.
fn check_attachments(walk: &Walk<'_>, pass: &str, drawing: &Drawing, faults: &mut Faults) {
    let mut shapes = BTreeSet::new();
    for target in targets(drawing) {
        let desc = walk.plan.image(target.image).desc;
        if target.level >= desc.levels || target.layer >= desc.layers || desc.volume {
            faults.add(format!("pass `{pass}` draws into {}, which is not there", part_name(walk, target)));
        }
        let side = |side: u32| (side >> target.level).max(1);
        shapes.insert((side(desc.size.width), side(desc.size.height), desc.samples));
        let is_depth = matches!(drawing.depth, Some(DepthAttachment { target: depth, .. }) if depth == target);
        if desc.format.is_depth() != is_depth {
            let what = if is_depth { "depth" } else { "color" };
            let format = desc.format.name();
            faults.add(format!("pass `{pass}` draws {what} into `{}` ({format})", image_name(walk, target.image)));
        }
    }
    if shapes.len() != 1 {
        faults.add(format!("pass `{pass}` draws into attachments of {} shapes: {shapes:?}", shapes.len()));
    }
}

/// The ranges that a buffer holds are in it.
fn check_ranges(walk: &Walk<'_>, pass: &str, geometry: &Geometry, faults: &mut Faults) {
    let Draws::Indirect(IndirectDraws { buffer, offset, ranges }) = geometry.draws else { return };
    let (stride, bytes) =
        (if geometry.indices.is_some() { 20 } else { 16 }, walk.plan.buffers[buffer.0 as usize].bytes);
    if offset % 4 != 0 || offset.saturating_add(stride * u64::from(ranges)) > bytes {
        let name = walk.name(Resource::Buffer(buffer));
        faults.add(format!("pass `{pass}` reads {ranges} ranges from byte {offset} of `{name}`, which has {bytes}"));
    }
}

/// The levels and layers that an argument reads of an image that is drawn in parts.
fn parts(walk: &Walk<'_>, arg: Arg) -> Vec<Subresource> {
    let of_image = |image: ImageId| {
        let desc = walk.plan.image(image).desc;
        let all = (0..desc.layers).flat_map(|layer| (0..desc.levels).map(move |level| (level, layer)));
        all.map(|(level, layer)| Subresource { image, level, layer }).collect::<Vec<_>>()
    };
    match arg {
        Arg::Texture(image) | Arg::Pixel(image) => {
            Some(of_image(image)).filter(|all| all.len() > 1).unwrap_or_default()
        }
        Arg::Level(part) if of_image(part.image).len() > 1 => vec![part],
        _ => Vec::new(),
    }
}
