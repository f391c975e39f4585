//! Step 7: where transient images lie, and what that saves.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use serde::Serialize;

use crate::placement::{self, Block};
use crate::{Alias, Fused, PlanBuilder, PlanRequest};
use afterimage_base::image::ImageDesc;
use afterimage_graph::node::{ImageId, Origin, Resource};

/// When an image is in use: from the first batch that mentions it to the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Lifetime {
    /// The first batch.
    pub first: usize,
    /// The last batch; past the end for what leaves the frame.
    pub last: usize,
}

/// What a device wants for an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Requirement {
    /// Bytes, with the driver's padding.
    pub bytes: u64,
    /// Alignment of its offset; a power of two.
    pub alignment: u64,
}

impl Requirement {
    /// A plausible requirement where no device is asked: whole blocks of 64 KiB.
    pub fn typical(desc: &ImageDesc) -> Self {
        const BLOCK: u64 = 1 << 16;
        Self { bytes: desc.bytes().next_multiple_of(BLOCK), alignment: BLOCK }
    }
}

/// A texture that images of equal description take turns in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Slot {
    /// Its description.
    pub desc: ImageDesc,
}

/// Where transient images lie, and what that saves.
///
/// Images that leave the frame, histories, constants and what the host gives have memory of their own and take no part. Two images share
/// memory only if no batch mentions both, so that the barrier between two batches separates them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Memory {
    /// What the device wants for each image that takes part.
    pub requirement_of: Vec<Option<Requirement>>,
    /// Textures of the pool; one for each image where images do not share.
    pub slots: Vec<Slot>,
    /// The slot of each image that takes part.
    pub slot_of: Vec<Option<u32>>,
    /// The place of each image that takes part in the one heap, in bytes.
    pub offset_of: Vec<Option<u64>>,
    /// Bytes of the heap; more than `placed` where the heap of an earlier plan is kept.
    pub heap: u64,
    /// Bytes if every image that the nodes describe had its own texture, those included that fusion has removed from the plan.
    pub unaliased: u64,
    /// Bytes if each image that this plan stores had its own texture.
    pub unshared: u64,
    /// Bytes of the pool if images of equal description take turns.
    pub pooled: u64,
    /// Bytes of the heap that this plan uses.
    pub placed: u64,
    /// The most bytes that live at once: no placement of this order needs less.
    pub lower_bound: u64,
    /// Bytes of outputs and of images that a later frame reads, which nothing shares.
    pub kept: u64,
}

impl Memory {
    /// Bytes of transient images under that way of sharing.
    pub fn bytes(&self, alias: Alias) -> u64 {
        match alias {
            Alias::None => self.unshared,
            Alias::Pool => self.pooled,
            Alias::Placed => self.placed,
        }
    }
}

/// What the device wants for each image that takes part in the sharing of memory.
pub(crate) fn requirements(draft: &PlanBuilder, setting: &PlanRequest<'_>) -> Vec<Option<Requirement>> {
    let mut asked = BTreeMap::new();
    let kept = kept(draft);
    let images = draft.recording.images.iter().enumerate();
    images
        .map(|(index, image)| {
            let shares = image.origin == Origin::Transient && !kept.contains_key(&ImageId(index as u32));
            shares.then(|| *asked.entry(image.desc).or_insert_with(|| (setting.requirement)(&image.desc)))
        })
        .collect()
}

/// Images that outlive the frame or leave it, and how many textures each needs.
fn kept(draft: &PlanBuilder) -> BTreeMap<ImageId, u64> {
    let mut kept: BTreeMap<ImageId, u64> = draft.outputs.iter().map(|output| (output.image, 1)).collect();
    for image in &draft.recording.images {
        if let Origin::Previous { of, frames } = image.origin {
            // The past of a node that is off is one image that nobody writes.
            let ring = if draft.recording.image(of).origin == Origin::Transient { u64::from(frames) + 1 } else { 1 };
            let textures = kept.entry(of).or_default();
            *textures = (*textures).max(ring);
        }
    }
    kept
}

/// When each image that a pass mentions lives.
pub(crate) fn lifetimes(draft: &PlanBuilder, batches: &[Range<usize>]) -> Vec<Option<Lifetime>> {
    let mut lifetimes: Vec<Option<Lifetime>> = vec![None; draft.recording.images.len()];
    for (batch, passes) in batches.iter().enumerate() {
        for pass in &draft.recording.passes[passes.clone()] {
            for resource in pass.reads().into_iter().chain(pass.writes()) {
                let Resource::Image(image) = resource else { continue };
                let lifetime = lifetimes[image.0 as usize].get_or_insert(Lifetime { first: batch, last: batch });
                lifetime.last = batch;
            }
        }
    }
    for image in kept(draft).into_keys() {
        if let Some(lifetime) = &mut lifetimes[image.0 as usize] {
            lifetime.last = batches.len();
        }
    }
    lifetimes
}

/// Places every image that takes part and that a pass mentions.
pub(crate) fn place(
    draft: &PlanBuilder,
    lifetimes: &[Option<Lifetime>],
    mut requirement_of: Vec<Option<Requirement>>,
    fused: &[Fused],
    setting: &PlanRequest<'_>,
) -> Memory {
    let unaliased = described_bytes(draft, &requirement_of, lifetimes, fused);
    for (requirement, lifetime) in requirement_of.iter_mut().zip(lifetimes) {
        *requirement = requirement.filter(|_| lifetime.is_some());
    }
    let (images, blocks) = blocks(&requirement_of, lifetimes);
    let lower_bound = placement::lower_bound(&blocks);
    let placement = placement::place(&blocks, lower_bound);
    let mut memory = Memory {
        offset_of: spread(requirement_of.len(), &images, &placement.offsets),
        heap: placement.end,
        placed: placement.end,
        lower_bound,
        unaliased,
        unshared: blocks.iter().map(|block| block.bytes).sum(),
        kept: kept_bytes(draft, setting),
        requirement_of,
        ..Memory::default()
    };
    pool(&mut memory, draft, lifetimes, &images, setting.options.alias);
    memory
}

/// Bytes of all transient images that a pass mentions, or mentioned before it was fused with another.
fn described_bytes(
    draft: &PlanBuilder,
    requirement_of: &[Option<Requirement>],
    lifetimes: &[Option<Lifetime>],
    fused: &[Fused],
) -> u64 {
    let removed: BTreeSet<&str> = fused.iter().map(|fused| fused.image.as_str()).collect();
    let images = draft.recording.images.iter().zip(lifetimes).zip(requirement_of);
    let described = images.filter(|((image, life), _)| life.is_some() || removed.contains(image.label.as_str()));
    described.filter_map(|(_, requirement)| requirement.map(|requirement| requirement.bytes)).sum()
}

/// The images that take part, and the room that each takes up.
pub(crate) fn blocks(
    requirement_of: &[Option<Requirement>],
    lifetimes: &[Option<Lifetime>],
) -> (Vec<usize>, Vec<Block>) {
    let both = requirement_of.iter().zip(lifetimes).enumerate();
    both.filter_map(|(image, (requirement, lifetime))| {
        let (Requirement { bytes, alignment }, Lifetime { first, last }) = ((*requirement)?, (*lifetime)?);
        Some((image, Block { bytes, alignment, first, last }))
    })
    .unzip()
}

/// Values of some images as a list over all images.
pub(crate) fn spread<T: Copy>(count: usize, images: &[usize], values: &[T]) -> Vec<Option<T>> {
    let mut all = vec![None; count];
    images.iter().zip(values).for_each(|(image, value)| all[*image] = Some(*value));
    all
}

fn kept_bytes(draft: &PlanBuilder, setting: &PlanRequest<'_>) -> u64 {
    let textures = kept(draft).into_iter();
    textures.map(|(image, count)| count * (setting.requirement)(&draft.recording.image(image).desc).bytes).sum()
}

/// The pool: images whose lifetimes do not overlap and whose descriptions are equal take turns.
///
/// Taking whichever texture is free in the order of first use needs as few textures as there can be, for intervals of time.
fn pool(memory: &mut Memory, draft: &PlanBuilder, lifetimes: &[Option<Lifetime>], images: &[usize], alias: Alias) {
    memory.slot_of = vec![None; lifetimes.len()];
    let mut free: BTreeMap<ImageDesc, BTreeSet<(usize, u32)>> = BTreeMap::new();
    let mut by_first_use: Vec<(Lifetime, usize)> =
        images.iter().filter_map(|image| lifetimes[*image].map(|lifetime| (lifetime, *image))).collect();
    by_first_use.sort_by_key(|(lifetime, image)| (lifetime.first, *image));
    let mut textures = 0;
    for (lifetime, image) in by_first_use {
        let desc = draft.recording.images[image].desc;
        let free = free.entry(desc).or_default();
        let turn = free.first().copied().filter(|(last, _)| *last < lifetime.first);
        let slot = turn.map_or(textures, |(_, slot)| slot);
        if let Some(turn) = turn {
            free.remove(&turn);
        } else {
            textures += 1;
            memory.pooled += memory.requirement_of[image].map_or(0, |requirement| requirement.bytes);
        }
        free.insert((lifetime.last, slot));
        let slot = if alias == Alias::None { memory.slots.len() as u32 } else { slot };
        if slot as usize == memory.slots.len() {
            memory.slots.push(Slot { desc });
        }
        memory.slot_of[image] = Some(slot);
    }
}
