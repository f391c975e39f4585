//! The passes of results that are held while their nodes do not run, and of values of the frame before.

use std::collections::{BTreeMap, BTreeSet};

use afterimage_graph::node::{BufferId, BufferLife, Pass, Resource};

use super::Plan;
use super::turn::{LatePasses, Turn};

impl Plan {
    /// For each pass the turns of the held results for which alone it runs; none if it runs in every frame, or fills a
    /// table.
    pub fn turns(&self) -> Vec<BTreeSet<Turn>> {
        let held = self.held_results();
        let lasting = self.lasting();
        // `None` is what every frame needs.
        let mut needed: BTreeMap<Resource, Option<BTreeSet<Turn>>> = BTreeMap::new();
        let mut turns = vec![BTreeSet::new(); self.passes.len()];
        for index in (0..self.passes.len()).rev() {
            let pass = &self.passes[index].pass;
            if self.fills_table(index) {
                continue;
            }
            let mut own = Some(BTreeSet::new());
            for resource in pass.writes() {
                let wanted = match held.get(&resource) {
                    Some(turn) => Some(BTreeSet::from([*turn])),
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
            turns[index] = own.unwrap_or_default();
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
        let turns: BTreeSet<u32> = self.held_results().values().map(|turn| turn.every).collect();
        (1..16).find(|frames| turns.iter().all(|every| frames % every == 0)).unwrap_or(16)
    }

    /// The passes of the [late](Self::late) values.
    pub fn late_passes(&self) -> LatePasses {
        let late: BTreeSet<&str> = self.late.iter().map(String::as_str).collect();
        let is_own = |pass: &Pass| matches!(pass.nodes.as_slice(), [node] if late.contains(node.as_str()));
        let mut passes = LatePasses::default();
        let mut needed: BTreeSet<Resource> = self.work().filter(|pass| is_own(pass)).flat_map(Pass::reads).collect();
        for index in (0..self.passes.len()).rev() {
            let pass = &self.passes[index].pass;
            if is_own(pass) {
                passes.own.push(index);
            } else if pass.writes().iter().any(|resource| needed.contains(resource)) {
                passes.before.push(index);
                needed.extend(pass.reads());
            }
        }
        passes.before.reverse();
        passes.own.reverse();
        passes
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
