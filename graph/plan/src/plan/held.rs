//! The passes of results that are held while their nodes do not run.

use std::collections::{BTreeMap, BTreeSet};

use afterimage_graph::node::{BufferId, BufferLife, Pass, Resource};

use super::Plan;
use super::turn::Turn;

impl Plan {
    /// For each pass the turns of the held results for which alone it runs; none if it runs in every frame, or fills a
    /// table.
    pub fn turns(&self) -> Vec<BTreeSet<Turn>> {
        let works: Vec<usize> = (0..self.passes.len()).filter(|pass| !self.fills_table(*pass)).collect();
        let passes: Vec<&Pass> = works.iter().map(|at| &self.passes[*at].pass).collect();
        let mut turns = vec![BTreeSet::new(); self.passes.len()];
        for (at, own) in works.into_iter().zip(made_for(&passes, &self.held_results(), &self.lasting())) {
            turns[at] = own;
        }
        turns
    }

    /// Whether each pass makes something from which a held result is made in the same frame.
    pub fn makes_held(&self) -> Vec<bool> {
        let mut needed: BTreeSet<Resource> = self.held_results().into_keys().collect();
        let mut makes = vec![false; self.passes.len()];
        for index in (0..self.passes.len()).rev() {
            let pass = &self.passes[index].pass;
            makes[index] = pass.writes().iter().any(|resource| needed.contains(resource));
            if makes[index] {
                needed.extend(pass.reads());
            }
        }
        makes
    }

    /// Frames after which the turns of passes come again, but at most 16: the time of a frame is a mean over so many.
    pub fn round(&self) -> u32 {
        let turns: BTreeSet<u32> = self.held_results().into_values().filter_map(Turn::every).collect();
        (1..16).find(|frames| turns.iter().all(|every| frames % every == 0)).unwrap_or(16)
    }

    /// The turn of each result that is held.
    pub fn held_results(&self) -> BTreeMap<Resource, Turn> {
        self.held.iter().flat_map(|held| held.results.iter().map(|resource| (*resource, held.turn))).collect()
    }

    /// What each frame must write: what leaves it, and what later frames read.
    fn lasting(&self) -> BTreeSet<Resource> {
        let outputs = self.outputs.iter().map(|output| output.image);
        let remembered = self.images.iter().filter_map(|image| image.origin.previous_of());
        let images = outputs.chain(remembered).map(Resource::Image);
        let buffers = self.buffers.iter().zip(0..).filter(|(buffer, _)| buffer.life == BufferLife::Persistent);
        images.chain(buffers.map(|(_, id)| Resource::Buffer(BufferId(id)))).collect()
    }
}

/// For each pass the held results for which alone it runs; none if every frame needs it.
pub(crate) fn made_for<T: Ord + Copy>(
    passes: &[&Pass],
    held: &BTreeMap<Resource, T>,
    lasting: &BTreeSet<Resource>,
) -> Vec<BTreeSet<T>> {
    // `None` is what every frame needs.
    let mut needed: BTreeMap<Resource, Option<BTreeSet<T>>> = BTreeMap::new();
    let mut all = vec![BTreeSet::new(); passes.len()];
    for (pass, found) in passes.iter().zip(&mut all).rev() {
        let mut own = Some(BTreeSet::new());
        for resource in pass.writes() {
            let wanted = match held.get(&resource) {
                Some(result) => Some(BTreeSet::from([*result])),
                None if lasting.contains(&resource) => None,
                None => needed.get(&resource).cloned().unwrap_or_else(|| Some(BTreeSet::new())),
            };
            own = own.zip(wanted).map(|(own, wanted)| &own | &wanted);
        }
        let own = own.filter(|own| !own.is_empty());
        for resource in pass.reads() {
            let known = needed.entry(resource).or_insert_with(|| Some(BTreeSet::new()));
            *known = known.take().zip(own.as_ref()).map(|(known, own)| &known | own);
        }
        *found = own.unwrap_or_default();
    }
    all
}
