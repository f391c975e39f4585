//! The last choices of images that the host has made, with their bind groups.

use std::hash::{Hash, Hasher};
use std::ops::Deref;

use rustc_hash::FxHasher;
use wgpu::TextureView;

use super::host_set::HostSet;

/// How many choices of host images are remembered: the images of a few swap chains.
const MOST: usize = 16;

/// The sets, of which the one that was used last is at the end.
#[derive(Default)]
pub(super) struct HostSets {
    sets: Vec<HostSet>,
    /// A number for the views of each set: a host with new views in every frame would compare them with all sets, in
    /// memory that no other frame uses.
    keys: Vec<u64>,
}

impl HostSets {
    /// The place of the set with these views: those of all inputs, then of all outputs.
    pub(super) fn find<'v>(
        &self,
        views: impl Iterator<Item = &'v TextureView>,
        is_same: impl Fn(&HostSet) -> bool,
    ) -> Option<usize> {
        let key = key(views);
        (0..self.sets.len()).find(|at| self.keys[*at] == key && is_same(&self.sets[*at]))
    }

    /// Moves a known set to the end: it is used again.
    pub(super) fn use_again(&mut self, at: usize) {
        self.sets[at..].rotate_left(1);
        self.keys[at..].rotate_left(1);
    }

    /// If no more sets can be remembered, removes the one that was used longest ago, and returns it.
    pub(super) fn remove_oldest_if_full(&mut self) -> Option<HostSet> {
        (self.sets.len() == MOST).then(|| {
            self.keys.remove(0);
            self.sets.remove(0)
        })
    }

    /// Adds a set as the one that was used last, after [`Self::remove_oldest_if_full`].
    pub(super) fn add(&mut self, set: HostSet) {
        self.keys.push(key(set.views.iter()));
        self.sets.push(set);
    }

    /// Forgets all sets but these.
    pub(super) fn retain(&mut self, is_kept: impl Fn(&HostSet) -> bool) {
        self.sets.retain(is_kept);
        self.keys = self.sets.iter().map(|set| key(set.views.iter())).collect();
    }
}

impl Deref for HostSets {
    type Target = [HostSet];
    fn deref(&self) -> &[HostSet] {
        &self.sets
    }
}

fn key<'v>(views: impl Iterator<Item = &'v TextureView>) -> u64 {
    let mut hasher = FxHasher::default();
    views.for_each(|view| view.hash(&mut hasher));
    hasher.finish()
}
