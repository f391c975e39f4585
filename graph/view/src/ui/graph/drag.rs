//! Wires that are dragged from one of their ends.

use afterimage_graph::check::{Candidate, Edit, Reader};
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

/// A wire that is being dragged, and the answers of the check to every end that it could get.
pub(super) struct Drag {
    pub(super) held: Held,
    /// The place of the held end in the drawing.
    pub(super) from: Pos2,
    /// The wire is that of the frame before.
    is_earlier: bool,
    candidates: Vec<Candidate>,
}

impl Drag {
    /// Begins to drag. All ends that the wire could get are tried.
    pub(super) fn begin(model: &Model, held: Held, from: Pos2, is_earlier: bool) -> Result<Self, Problem> {
        let frames = u32::from(is_earlier);
        let candidates = match &held {
            Held::Reader(reader) => model.sources(reader, frames)?,
            Held::Wire(wire) => model.readers(&earlier(wire, frames))?,
        };
        Ok(Self { held, from, is_earlier, candidates })
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
