//! Step 7: where transient images lie.

use serde::Serialize;

use super::{Draft, Setting};
use crate::image::ImageDesc;
use crate::node::{ImageId, Origin, Recording, Resource};

/// When an image is in use: from the first pass that mentions it to the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Lifetime {
    /// The first pass.
    pub first: usize,
    /// The last pass; past the end for what leaves the frame.
    pub last: usize,
}

/// What a device wants for an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Memory {
    /// Textures of the pool.
    pub slots: Vec<Slot>,
    /// The slot of each image, if it is a transient that runs.
    pub slot_of: Vec<Option<u32>>,
    /// Bytes if each image had its own texture.
    pub unaliased: u64,
    /// Bytes of the pool.
    pub pooled: u64,
}

pub(crate) fn lifetimes(draft: &Draft) -> Vec<Option<Lifetime>> {
    let passes = &draft.recording.passes;
    let mut lifetimes: Vec<Option<Lifetime>> = vec![None; draft.recording.images.len()];
    for (index, pass) in passes.iter().enumerate() {
        for resource in pass.reads().into_iter().chain(pass.writes()) {
            let Resource::Image(image) = resource else { continue };
            let lifetime = &mut lifetimes[image.0 as usize];
            let first = lifetime.map_or(index, |l| l.first);
            *lifetime = Some(Lifetime { first, last: index });
        }
    }
    for (index, lifetime) in lifetimes.iter_mut().enumerate() {
        if draft.is_kept(ImageId(index as u32)) && let Some(lifetime) = lifetime {
            lifetime.last = passes.len();
        }
    }
    lifetimes
}

/// The pool: images whose lifetimes do not overlap and whose descriptions are equal take turns.
pub(crate) fn place(
    recording: &Recording,
    lifetimes: &[Option<Lifetime>],
    _waves: &[std::ops::Range<usize>],
    setting: &Setting<'_>,
) -> Memory {
    let mut memory = Memory { slot_of: vec![None; recording.images.len()], ..Memory::default() };
    let mut free_after: Vec<usize> = Vec::new();
    let mut transients: Vec<(Lifetime, usize)> = lifetimes
        .iter()
        .enumerate()
        .filter(|(index, _)| recording.images[*index].origin == Origin::Transient)
        .filter_map(|(index, lifetime)| lifetime.map(|lifetime| (lifetime, index)))
        .collect();
    transients.sort_by_key(|(lifetime, index)| (lifetime.first, *index));
    let pools = setting.options.alias != super::Alias::None;
    for (lifetime, index) in transients {
        let desc = recording.images[index].desc;
        let bytes = (setting.requirement)(&desc).bytes;
        memory.unaliased += bytes;
        let fits = |slot: &usize| pools && memory.slots[*slot].desc == desc && free_after[*slot] < lifetime.first;
        let slot = (0..memory.slots.len()).find(fits).unwrap_or_else(|| {
            memory.slots.push(Slot { desc });
            free_after.push(0);
            memory.pooled += bytes;
            memory.slots.len() - 1
        });
        free_after[slot] = lifetime.last;
        memory.slot_of[index] = Some(slot as u32);
    }
    memory
}
