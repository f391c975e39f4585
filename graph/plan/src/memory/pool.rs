//! The pool: images with equal descriptions whose lifetimes do not overlap share a texture.

use std::collections::{BTreeMap, BTreeSet};

use crate::options::Alias;
use crate::plan::{Lifetime, PlannedImage, Slot};
use afterimage_base::image::ImageDesc;

/// Gives each image that shares memory a slot; returns the slots and the bytes of the pool.
///
/// Taking whichever texture is free in the order of first use needs as few textures as there can be, for intervals of
/// time.
pub(super) fn assign_slots(images: &mut [PlannedImage], alias: Alias) -> (Vec<Slot>, u64) {
    let mut pool = Pool::default();
    let mut slots: Vec<Slot> = Vec::new();
    for (lifetime, at) in by_first_use(images) {
        let image = &mut images[at];
        let pooled = pool.take(image, lifetime);
        let slot = if alias == Alias::None { slots.len() as u32 } else { pooled };
        if slot as usize == slots.len() {
            slots.push(Slot { desc: image.desc });
        }
        image.slot = Some(slot);
    }
    (slots, pool.bytes)
}

fn by_first_use(images: &[PlannedImage]) -> Vec<(Lifetime, usize)> {
    let shared = images.iter().enumerate().filter(|(_, image)| image.requirement.is_some());
    let mut uses: Vec<(Lifetime, usize)> = shared.filter_map(|(at, image)| Some((image.lifetime?, at))).collect();
    uses.sort_by_key(|(lifetime, at)| (lifetime.first, *at));
    uses
}

/// The textures of the pool.
#[derive(Default)]
struct Pool {
    /// For each description the last batch that uses each texture.
    last_uses: BTreeMap<ImageDesc, BTreeSet<(usize, u32)>>,
    textures: u32,
    bytes: u64,
}

impl Pool {
    /// A texture that no image uses any more when this one begins, or a new one.
    fn take(&mut self, image: &PlannedImage, lifetime: Lifetime) -> u32 {
        let last_uses = self.last_uses.entry(image.desc).or_default();
        let free = last_uses.first().copied().filter(|(last, _)| *last < lifetime.first);
        let slot = free.map_or(self.textures, |(_, slot)| slot);
        match free {
            Some(free) => {
                last_uses.remove(&free);
            }
            None => {
                self.textures += 1;
                self.bytes += image.requirement.map_or(0, |requirement| requirement.bytes);
            }
        }
        last_uses.insert((lifetime.last, slot));
        slot
    }
}
