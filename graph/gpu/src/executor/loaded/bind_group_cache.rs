//! The bind groups for the last choices of host images.

use std::hash::{Hash, Hasher};
use std::ops::Deref;

use rustc_hash::FxHasher;
use wgpu::TextureView;

use crate::executor::loaded::bind_groups::BindGroups;

/// Entries that are kept: the images of a few swap chains.
const MAX_ENTRIES: usize = 16;

/// Bind groups by host images, the last used at the end.
#[derive(Default)]
pub(crate) struct BindGroupCache {
    entries: Vec<BindGroups>,
    /// The hash of each entry's views: a host with new views in every frame would otherwise compare them with those of
    /// all entries, which are not in the processor's caches.
    keys: Vec<u64>,
}

impl BindGroupCache {
    /// The index of the entry with these views: those of all inputs, then of all outputs.
    pub(crate) fn find<'v>(
        &self,
        views: impl Iterator<Item = &'v TextureView>,
        is_same: impl Fn(&BindGroups) -> bool,
    ) -> Option<usize> {
        let key = key(views);
        (0..self.entries.len()).find(|at| self.keys[*at] == key && is_same(&self.entries[*at]))
    }

    /// Moves an entry to the end.
    pub(crate) fn use_again(&mut self, at: usize) {
        self.entries[at..].rotate_left(1);
        self.keys[at..].rotate_left(1);
    }

    /// If the cache is full, removes the least recently used entry and returns it.
    pub(crate) fn remove_oldest_if_full(&mut self) -> Option<BindGroups> {
        (self.entries.len() == MAX_ENTRIES).then(|| {
            self.keys.remove(0);
            self.entries.remove(0)
        })
    }

    /// Adds an entry at the end, after [`Self::remove_oldest_if_full`].
    pub(crate) fn add(&mut self, groups: BindGroups) {
        self.keys.push(key(groups.views.iter()));
        self.entries.push(groups);
    }

    pub(crate) fn retain(&mut self, is_kept: impl Fn(&BindGroups) -> bool) {
        self.entries.retain(is_kept);
        self.keys = self.entries.iter().map(|groups| key(groups.views.iter())).collect();
    }
}

impl Deref for BindGroupCache {
    type Target = [BindGroups];
    fn deref(&self) -> &[BindGroups] {
        &self.entries
    }
}

fn key<'v>(views: impl Iterator<Item = &'v TextureView>) -> u64 {
    let mut hasher = FxHasher::default();
    views.for_each(|view| view.hash(&mut hasher));
    hasher.finish()
}
