//! Which passes of a plan run in a frame.

use afterimage_graph::node::{BufferId, Resource};
use afterimage_plan::{Plan, Turn};

use super::tables::Tables;

/// Which passes of a plan run in a frame.
pub(crate) struct Turns {
    /// The turns of all held results.
    turns: Vec<Turn>,
    /// Whether the frame has each of them.
    has_turn: Vec<bool>,
    /// For each pass the turns in which alone it runs, by their places; none if it runs in every frame.
    of_passes: Vec<Vec<usize>>,
    /// For each buffer the turns in which alone it is made anew, by their places; none if it is in every frame.
    of_buffers: Vec<Vec<usize>>,
    /// The passes whose numbers held results depend on: new numbers need new results.
    pub(crate) made: Tables,
}

impl Turns {
    /// Those of a plan with these uniforms.
    pub(crate) fn new(plan: &Plan, uniforms: &[u8]) -> Self {
        let held = plan.held_results();
        let mut turns: Vec<Turn> = held.values().copied().collect();
        turns.sort_unstable();
        turns.dedup();
        let place = |turn: &Turn| turns.binary_search(turn).expect("all turns are those of held results");
        let of_passes: Vec<Vec<usize>> = plan.turns().iter().map(|own| own.iter().map(place).collect()).collect();
        let buffers = (0..plan.buffers.len()).map(|buffer| Resource::Buffer(BufferId(buffer as u32)));
        let of_buffers = buffers.map(|buffer| {
            let writes = plan.passes.iter().zip(&of_passes).filter(|(pass, _)| pass.pass.writes().contains(&buffer));
            let writes: Vec<&[usize]> = writes.map(|(_, turns)| turns.as_slice()).collect();
            let is_in_turns = writes.iter().all(|turns| !turns.is_empty());
            if is_in_turns { writes.concat() } else { Vec::new() }
        });
        let of_buffers = of_buffers.collect();
        let makes_held = plan.makes_held();
        let made = Tables::new(plan, uniforms, |pass| makes_held[pass]);
        Self { has_turn: vec![true; turns.len()], turns, of_passes, of_buffers, made }
    }

    /// Begins a frame of that number, after one of the number `before`; `None` if all begins anew.
    pub(crate) fn begin(&mut self, number: u32, before: Option<u32>) {
        let before = before.filter(|_| !self.made.are_stale());
        for (turn, has_turn) in self.turns.iter().zip(&mut self.has_turn) {
            *has_turn = before.is_none_or(|before| turn.is_due(number, before));
        }
    }

    /// Whether a pass runs in the frame, as far as its results are held.
    pub(crate) fn runs(&self, pass: usize) -> bool {
        self.has_one_of(&self.of_passes[pass])
    }

    /// Whether a buffer begins with zeros in the frame, if it does so whenever it is made.
    pub(crate) fn clears(&self, buffer: usize) -> bool {
        self.has_one_of(&self.of_buffers[buffer])
    }

    fn has_one_of(&self, turns: &[usize]) -> bool {
        turns.is_empty() || turns.iter().any(|turn| self.has_turn[*turn])
    }
}
