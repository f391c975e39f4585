//! Memory: no two live images share any, every image has its place, and every aliasing barrier is stated.

use std::collections::BTreeSet;
use std::ops::Range;

use super::walk::{Faults, Walk};
use crate::options::Alias;
use crate::plan::{Lifetime, PlannedImage};
use afterimage_graph::node::{ImageId, Origin};

pub(super) fn check(walk: &Walk<'_>, faults: &mut Faults) {
    let leaving = leaving(walk);
    check_lifetimes(walk, &leaving, faults);
    check_places(walk, &leaving, faults);
    let heap = replay(walk, &extents(walk, Alias::Placed), "the heap", faults);
    let pool = replay(walk, &extents(walk, Alias::Pool), "the pool", faults);
    match walk.plan.options.alias {
        Alias::Placed => check_aliasing(walk, &heap, faults),
        Alias::Pool => check_aliasing(walk, &pool, faults),
        Alias::None => {
            check_aliasing(walk, &vec![BTreeSet::new(); walk.images.len()], faults);
            for (image, before) in pool.iter().enumerate().filter(|(_, before)| !before.is_empty()) {
                let others: Vec<&str> = before.iter().map(|other| walk.images[*other].as_str()).collect();
                faults.add(format!("`{}` shares a texture with `{}`", walk.images[image], others.join("`, `")));
            }
        }
    }
}

/// The images that leave the frame: outputs, and the present of each history.
fn leaving(walk: &Walk<'_>) -> BTreeSet<ImageId> {
    let outputs = walk.plan.outputs.iter().map(|output| output.image);
    outputs.chain(walk.plan.images.iter().filter_map(|other| other.origin.previous_of())).collect()
}

fn check_lifetimes(walk: &Walk<'_>, leaving: &BTreeSet<ImageId>, faults: &mut Faults) {
    for (image, (planned, span)) in walk.plan.images.iter().zip(&walk.spans).enumerate() {
        let stated = planned.lifetime;
        let leaves = leaving.contains(&ImageId(image as u32));
        let end = |last: usize| if leaves { walk.plan.batches.len() } else { last };
        let found = span.map(|(first, last)| Lifetime { first, last: end(last) });
        if stated != found {
            faults.add(format!("`{}` lives {found:?}, but the plan says {stated:?}", walk.images[image]));
        }
    }
}

fn check_places(walk: &Walk<'_>, leaving: &BTreeSet<ImageId>, faults: &mut Faults) {
    let heap = walk.places.heap;
    for (image, planned) in walk.plan.images.iter().enumerate() {
        let leaves = leaving.contains(&ImageId(image as u32));
        let shares = planned.origin == Origin::Transient && walk.spans[image].is_some() && !leaves;
        let (offset, slot, wants) = (walk.places.offsets[image], planned.slot, planned.requirement);
        let name = &walk.images[image];
        if [offset.is_some(), slot.is_some(), wants.is_some()] != [shares; 3] {
            let has = if shares { "is a transient without" } else { "is not a transient of this frame, but has" };
            faults.add(format!("`{name}` {has} a place in the shared memory"));
        }
        let (Some(offset), Some(slot), Some(wants)) = (offset, slot, wants) else { continue };
        if offset % wants.alignment != 0 {
            faults.add(format!("`{name}` lies at {offset}, which is not a multiple of {}", wants.alignment));
        }
        if offset + wants.bytes > heap {
            faults.add(format!("`{name}` ends at {}, beyond the heap of {heap}", offset + wants.bytes));
        }
        if walk.plan.memory.slots.get(slot as usize).is_none_or(|texture| texture.desc != planned.desc) {
            faults.add(format!("`{name}` is in slot {slot}, whose texture has another description"));
        }
    }
}

/// The memory of each image: bytes of the heap, or a texture of the pool.
fn extents(walk: &Walk<'_>, alias: Alias) -> Vec<Option<Range<u64>>> {
    let extent = |(image, start): (&PlannedImage, &Option<u64>)| match alias {
        Alias::Placed => Some((*start)?..(*start)? + image.requirement?.bytes),
        _ => image.slot.map(|slot| u64::from(slot)..u64::from(slot) + 1),
    };
    walk.plan.images.iter().zip(&walk.places.offsets).map(extent).collect()
}

/// Gives every image its memory at the first batch of its life, and returns for each the images that used it before.
/// Memory is cut at every end of every image; each piece must be unused when an image gets it.
fn replay(walk: &Walk<'_>, extents: &[Option<Range<u64>>], place: &str, faults: &mut Faults) -> Vec<BTreeSet<usize>> {
    let mut cuts: Vec<u64> = extents.iter().flatten().flat_map(|extent| [extent.start, extent.end]).collect();
    cuts.sort_unstable();
    cuts.dedup();
    let mut pieces: Vec<Vec<usize>> = vec![Vec::new(); cuts.len()];
    let mut found = vec![BTreeSet::new(); extents.len()];
    let mut inputs: Vec<(usize, usize)> =
        walk.spans.iter().enumerate().filter_map(|(i, s)| Some(((*s)?.0, i))).collect();
    inputs.sort_unstable();
    let last_of = |image: usize| walk.spans[image].map_or(0, |(_, last)| last);
    for (first, image) in inputs {
        let Some(extent) = &extents[image] else { continue };
        let range = cuts.partition_point(|cut| *cut < extent.start)..cuts.partition_point(|cut| *cut < extent.end);
        for piece in &mut pieces[range] {
            found[image].extend(piece.iter().copied());
            piece.retain(|other| last_of(*other) >= first);
            piece.push(image);
        }
        for other in &found[image] {
            let last = last_of(*other);
            if last >= first {
                let (name, other) = (&walk.images[image], &walk.images[*other]);
                faults.add(format!(
                    "`{name}` begins in batch {first} in {place} where `{other}` lives until batch {last}"
                ));
            }
        }
    }
    found
}

/// Every image whose memory others have used has an aliasing barrier before its first batch, which names them.
fn check_aliasing(walk: &Walk<'_>, found: &[BTreeSet<usize>], faults: &mut Faults) {
    let mut stated = vec![None; found.len()];
    for (batch, barriers) in walk.places.aliasing.iter().enumerate() {
        for barrier in barriers {
            let owners: BTreeSet<usize> = barrier.owners.iter().map(|owner| owner.0 as usize).collect();
            stated[barrier.image.0 as usize] = Some((batch, owners));
        }
    }
    for (image, (found, stated)) in found.iter().zip(&stated).enumerate() {
        let first = walk.spans[image].map_or(0, |(first, _)| first);
        let names = |images: &BTreeSet<usize>| {
            images.iter().map(|image| format!("`{}`", walk.images[*image])).collect::<Vec<String>>().join(", ")
        };
        match stated {
            Some((batch, owners)) if *batch != first || owners != found => faults.add(format!(
                "`{}` takes over the memory of {} in batch {first}, but the plan says of {} in batch {batch}",
                walk.images[image],
                names(found),
                names(owners)
            )),
            None if !found.is_empty() => faults.add(format!(
                "`{}` takes over the memory of {} in batch {first} and nothing separates them",
                walk.images[image],
                names(found)
            )),
            _ => {}
        }
    }
}
