//! The end under the pointer that a dragged wire would get.

use afterimage_graph::check::{Candidate, Reader, Source};
use egui::Pos2;

use super::drag::{Drag, Held};
use super::drawing::{Drawing, rect};
use super::layout::{Item, Placed};
use super::wire::{source_of, wire_text};

/// The distance from an end in points at which it is meant, and not its box.
const NEAR: f32 = 10.0;

/// Returns whether a place means a box or one of its ends.
pub(super) fn is_near(placed: &Placed, at: Pos2) -> bool {
    rect(placed).expand(NEAR).contains(at)
}

impl<'d> Drawing<'d> {
    /// The answer of the check for what is at a place: the end there, or else the best one of the box.
    pub(super) fn candidate_at(&self, drag: &'d Drag, at: Pos2) -> Option<&Candidate> {
        let placed = self.placed.iter().find(|placed| is_near(placed, at))?;
        match &drag.held {
            Held::Reader(_) => self.source_at(drag, placed, at),
            Held::Wire(_) => self.reader_at(drag, placed, at),
        }
    }

    fn source_at(&self, drag: &'d Drag, placed: &Placed, at: Pos2) -> Option<&Candidate> {
        let node = match placed.item {
            Item::Input(input) => return drag.of_wire(&self.graph.inputs[input].name),
            Item::Output(_) => return None,
            Item::Node(node) => node,
        };
        let sources = (0..self.graph.nodes[node].kind().outputs().len())
            .map(|output| Source::Node { node, output, previous: 0 })
            .filter_map(|source| Some((self.output_at(source), drag.of_wire(&wire_text(self.graph, source))?)));
        best(sources.collect(), at, |_| false)
    }

    fn reader_at(&self, drag: &'d Drag, placed: &Placed, at: Pos2) -> Option<&Candidate> {
        let node = match placed.item {
            Item::Output(output) => return drag.of_reader(&Reader::Output(self.graph.outputs[output].name.clone())),
            Item::Input(_) => return None,
            Item::Node(node) => &self.graph.nodes[node],
        };
        let place = |candidate: &Candidate| self.place_of(&candidate.reader).unwrap_or(Pos2::new(f32::MAX, f32::MAX));
        let readers = drag.of_node(&node.name).map(|candidate| (place(candidate), candidate));
        // A box stands for its input without a wire: one with a wire has an end of its own.
        best(readers.collect(), at, |candidate| source_of(self.graph, &candidate.reader).is_none())
    }
}

/// The candidate whose end is near; otherwise the first one that is possible, preferred ones before others; otherwise
/// the first one.
fn best(
    mut candidates: Vec<(Pos2, &Candidate)>,
    at: Pos2,
    is_preferred: impl Fn(&Candidate) -> bool,
) -> Option<&Candidate> {
    candidates.sort_by(|(a, _), (b, _)| a.distance(at).total_cmp(&b.distance(at)));
    let nearest = candidates.first().filter(|(place, _)| place.distance(at) < NEAR);
    let possible = || candidates.iter().filter(|(_, candidate)| candidate.refusal.is_none());
    let preferred = || possible().find(|(_, candidate)| is_preferred(candidate));
    let found = nearest.or_else(preferred).or_else(|| possible().next()).or(candidates.first());
    found.map(|(_, candidate)| *candidate)
}
