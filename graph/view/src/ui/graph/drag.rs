//! Wires that are dragged from one of their ends.

use afterimage_graph::check::{Candidate, Connection, Edit, Reader};
use afterimage_graph::diagnostic::Diagnostics;
use egui::Pos2;

use super::wire::earlier;
use crate::Problem;
use crate::model::Model;

/// The end of a wire that is held; the other one follows the pointer.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Held {
    /// An input of a node or an output of the pipeline, which is to read something else.
    Reader(Reader),
    /// A wire, which something else is to read.
    Wire(String),
}

/// Ends of other boxes than that under the pointer that are tried in a frame: each takes some milliseconds.
const TRIED_IN_A_FRAME: usize = 2;

/// A wire that is being dragged, and the answers of the check to the ends that it could get.
pub(super) struct Drag {
    pub(super) held: Held,
    /// The place of the held end in the drawing.
    pub(super) from: Pos2,
    /// The wire is that of the frame before.
    is_earlier: bool,
    /// The ends that are to be tried.
    untried: Vec<Connection>,
    candidates: Vec<Candidate>,
}

impl Drag {
    /// Begins to drag. The ends that the wire could get are tried later.
    pub(super) fn begin(model: &Model, held: Held, from: Pos2, is_earlier: bool) -> Result<Self, Problem> {
        let frames = u32::from(is_earlier);
        let untried = match &held {
            Held::Reader(reader) => model.sources(reader, frames)?,
            Held::Wire(wire) => model.readers(&earlier(wire, frames))?,
        };
        Ok(Self { held, from, is_earlier, untried, candidates: Vec::new() })
    }

    /// Tries the ends at the box of that name, and a few others. Returns true while others are left.
    pub(super) fn try_ends(&mut self, model: &Model, name: Option<&str>) -> bool {
        let is_near = |connection: &Connection| name.is_some_and(|name| is_at(connection, &self.held, name));
        let (near, mut others): (Vec<_>, Vec<_>) = std::mem::take(&mut self.untried).into_iter().partition(is_near);
        let next = near.into_iter().chain(others.drain(..TRIED_IN_A_FRAME.min(others.len()))).collect();
        // A text that has errors meanwhile ends the drag at its drop.
        self.candidates.extend(model.candidates(next).unwrap_or_default());
        self.untried = others;
        !self.untried.is_empty()
    }

    /// Changes to the frame before, or back.
    pub(super) fn set_earlier(&mut self, model: &Model, is_earlier: bool) {
        if self.is_earlier != is_earlier
            && let Ok(other) = Self::begin(model, self.held.clone(), self.from, is_earlier)
        {
            *self = other;
        }
    }

    /// The answer for a wire of this frame that is read by the held end.
    pub(super) fn of_wire(&self, wire: &str) -> Option<&Candidate> {
        let wire = earlier(wire, u32::from(self.is_earlier));
        self.candidates.iter().find(|candidate| matches!(self.held, Held::Reader(_)) && candidate.wire == wire)
    }

    /// The answer for an end that reads the held wire.
    pub(super) fn of_reader(&self, reader: &Reader) -> Option<&Candidate> {
        self.candidates.iter().find(|candidate| matches!(self.held, Held::Wire(_)) && candidate.reader == *reader)
    }

    /// The answers for the inputs of a node, in the order of its ports.
    pub(super) fn of_node<'d>(&'d self, name: &'d str) -> impl Iterator<Item = &'d Candidate> {
        let is_own = move |reader: &Reader| matches!(reader, Reader::Input { node, .. } if node == name);
        let holds_wire = matches!(self.held, Held::Wire(_));
        self.candidates.iter().filter(move |candidate| holds_wire && is_own(&candidate.reader))
    }
}

/// Returns whether the free end of a connection is at a box: an input, a node or an output of the pipeline.
fn is_at((reader, wire): &Connection, held: &Held, name: &str) -> bool {
    match (held, reader) {
        (Held::Reader(_), _) => {
            wire.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '@']))
        }
        (Held::Wire(_), Reader::Input { node, .. }) => node == name,
        (Held::Wire(_), Reader::Output(output)) => output == name,
    }
}

/// The edit that an accepted end makes.
pub(super) fn connection(candidate: &Candidate) -> Edit {
    Edit::Connect { reader: candidate.reader.clone(), wire: Some(candidate.wire.clone()) }
}

/// The reason of a refusal in a sentence, with help.
pub(super) fn reason(errors: &Diagnostics) -> String {
    let Some(first) = errors.iter().next() else { return String::new() };
    match &first.help {
        Some(help) => format!("{}\n{help}", first.message),
        None => first.message.clone(),
    }
}
