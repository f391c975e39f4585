//! The frames in which passes run: cached results, and passes that run after a change.

use std::collections::{BTreeMap, BTreeSet};

use afterimage_graph::node::{Pass, Resource};

use super::{Plan, Refresh};

impl Plan {
    /// The cached results and the frames that compute them.
    pub fn cached_results(&self) -> BTreeMap<Resource, Refresh> {
        let nodes = self.savings.cached.iter();
        nodes.flat_map(|cached| cached.results.iter().map(|result| (*result, cached.refresh))).collect()
    }

    /// True if each frame runs all passes but those that run after a change of their uniforms.
    pub fn runs_all_passes(&self) -> bool {
        let is_seldom = |refresh: &Refresh| matches!(refresh, Refresh::Every { .. } | Refresh::Once);
        !self.passes.iter().any(|planned| planned.refresh.iter().any(is_seldom))
    }

    /// For each pass, whether a cached result is computed from what it writes in the same frame.
    pub fn feeds_cached(&self) -> Vec<bool> {
        let mut needed: BTreeSet<Resource> = self.cached_results().into_keys().collect();
        let mut feeds = vec![false; self.passes.len()];
        for (feeds, pass) in feeds.iter_mut().zip(&self.passes).rev() {
            *feeds = pass.pass.writes().iter().any(|resource| needed.contains(resource));
            if *feeds {
                needed.extend(pass.pass.reads());
            }
        }
        feeds
    }

    /// For each pass, whether it must run again if the `dirty` ones write something else: it reads what one of them
    /// writes, or writes to the same.
    pub fn dependents(&self, mut dirty: Vec<bool>) -> Vec<bool> {
        loop {
            let count = dirty.iter().filter(|dirty| **dirty).count();
            let writers = self.work().zip(&dirty).filter(|(_, dirty)| **dirty);
            let written: BTreeSet<Resource> = writers.flat_map(|(pass, _)| pass.writes()).collect();
            for (dirty, pass) in dirty.iter_mut().zip(self.work()) {
                *dirty |= pass.reads().iter().chain(&pass.writes()).any(|used| written.contains(used));
            }
            if dirty.iter().filter(|dirty| **dirty).count() == count {
                return dirty;
            }
        }
    }

    /// True if a pass runs after a change of its uniforms: it evaluates a baked LUT.
    pub fn runs_on_change(&self, pass: usize) -> bool {
        self.passes[pass].refresh.contains(&Refresh::OnChange)
    }

    /// Frames after which the same passes run again, but at most 16: the time of a frame is a mean over so many.
    pub fn refresh_cycle(&self) -> u32 {
        let cached: BTreeSet<u32> = self.cached_results().into_values().filter_map(Refresh::every).collect();
        (1..16).find(|frames| cached.iter().all(|every| frames % every == 0)).unwrap_or(16)
    }

    /// The share of frames in which a pass runs. Baked LUTs are evaluated in none.
    pub(super) fn share_of_frames(&self, pass: usize) -> f64 {
        let share = |refresh: &Refresh| match *refresh {
            Refresh::EachFrame => 1.0,
            Refresh::Every { every, .. } => 1.0 / f64::from(every),
            Refresh::OnChange | Refresh::Once => 0.0,
        };
        self.passes[pass].refresh.iter().map(share).sum::<f64>().min(1.0)
    }
}

/// For each pass the results for which alone it runs. `each_frame` stands for all that every frame must write: the
/// `persistent` resources, and what is not cached and nothing reads.
pub(crate) fn passes_only_for<T: Ord + Copy>(
    passes: &[&Pass],
    cached: &BTreeMap<Resource, T>,
    persistent: &BTreeSet<Resource>,
    each_frame: T,
) -> Vec<BTreeSet<T>> {
    let mut needed: BTreeMap<Resource, BTreeSet<T>> = BTreeMap::new();
    let mut all = vec![BTreeSet::new(); passes.len()];
    for (pass, results) in passes.iter().zip(&mut all).rev() {
        for resource in pass.writes() {
            match cached.get(&resource) {
                Some(result) => _ = results.insert(*result),
                None if persistent.contains(&resource) => _ = results.insert(each_frame),
                None => results.extend(needed.get(&resource).into_iter().flatten()),
            }
        }
        if results.is_empty() || results.contains(&each_frame) {
            *results = BTreeSet::from([each_frame]);
        }
        for resource in pass.reads() {
            needed.entry(resource).or_default().extend(results.iter());
        }
    }
    all
}
