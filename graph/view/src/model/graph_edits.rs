//! Edits of the graph: each is an edit of the text, and one step of the history.

use std::collections::BTreeMap;

use afterimage_graph::check::{Candidate, Connection, Edit, Graph, Reader, Source};
use afterimage_graph::node::NodeKind;

use super::{InspectedWire, Model};
use crate::Problem;

impl Model {
    /// Edits nodes and wires. The changed values of a node follow its name, and go with it.
    ///
    /// # Errors
    /// The edit is not possible, or the edited text would be wrong. Nothing is changed then.
    pub fn edit_graph(&mut self, edit: &Edit) -> Result<(), Problem> {
        let text = self.editor.ask(|saver| saver.edit(self.editor.tier(), edit))?;
        if text == self.editor.text() {
            return Ok(());
        }
        self.editor.changes.edit_graph(&text, |name| name_after(edit, name));
        let inspected = self.inspector().wire().cloned();
        let wire_after = inspected.as_ref().map(|wire| name_after(edit, &wire.wire));
        if wire_after == Some(None) {
            self.inspect_wire(None);
        }
        self.reload();
        self.instances.reset_values(&self.editor.changes);
        if let (Some(before), Some(Some(wire))) = (inspected, wire_after)
            && wire != before.wire
        {
            self.inspect_wire(Some(InspectedWire { wire, ..before }));
        }
        Ok(())
    }

    /// All wires, so many frames earlier, for an input or output. They are not tried yet.
    ///
    /// # Errors
    /// The text has errors.
    pub fn sources(&self, reader: &Reader, frames: u32) -> Result<Vec<Connection>, Problem> {
        self.editor.ask(|saver| saver.sources(self.editor.tier(), reader, frames))
    }

    /// All inputs and outputs for a wire. They are not tried yet.
    ///
    /// # Errors
    /// The text has errors.
    pub fn readers(&self, wire: &str) -> Result<Vec<Connection>, Problem> {
        self.editor.ask(|saver| saver.readers(self.editor.tier(), wire))
    }

    /// Tries connections. Those that are not possible have errors.
    ///
    /// # Errors
    /// The text has errors.
    pub fn candidates(&self, connections: Vec<Connection>) -> Result<Vec<Candidate>, Problem> {
        self.editor.ask(|saver| Ok(saver.candidates(self.editor.tier(), connections)))
    }

    /// The kinds of which a node may come between an input or output and what it reads.
    ///
    /// # Errors
    /// The text has errors.
    pub fn kinds_between(&self, reader: &Reader) -> Result<Vec<NodeKind>, Problem> {
        self.editor.ask(|saver| Ok(saver.kinds_between(self.editor.tier(), reader)?.into_iter().cloned().collect()))
    }

    /// All kinds, whatever the text.
    ///
    /// # Errors
    /// The kinds cannot be read.
    pub fn kinds(&self) -> Result<Vec<NodeKind>, Problem> {
        self.editor.kinds()
    }

    /// Inserts a node before an input or output. Returns its name.
    ///
    /// # Errors
    /// It does not fit there.
    pub fn insert_node(&mut self, kind: &str, reader: Reader) -> Result<String, Problem> {
        let name = self.editor.ask(|saver| saver.unused_name(kind))?;
        self.edit_graph(&Edit::Insert { kind: kind.to_owned(), name: name.clone(), reader })?;
        Ok(name)
    }

    /// The nearest input or output to another one before which a node of a kind fits; `None` if there is no such place.
    ///
    /// # Errors
    /// The text has errors.
    pub fn nearest_place(&self, kind: &str, reader: &Reader) -> Result<Option<Reader>, Problem> {
        let Some(graph) = self.editor.graph() else { return Ok(None) };
        let tier = self.editor.tier();
        self.editor.ask(|saver| {
            let name = saver.unused_name(kind)?;
            let fits = |reader: &Reader| {
                let edit = Edit::Insert { kind: kind.to_owned(), name: name.clone(), reader: reader.clone() };
                saver.edit(tier, &edit).is_ok()
            };
            Ok(readers_by_distance(graph, reader).into_iter().find(fits))
        })
    }

    /// Adds a node of a kind that reads a wire, if it takes it. Returns its name.
    ///
    /// # Errors
    /// None of the wires fits.
    pub fn add_node(&mut self, kind: &str, wire: Option<&str>) -> Result<String, Problem> {
        let edit = self.editor.ask(|saver| saver.addition(self.editor.tier(), kind, wire))?;
        self.edit_graph(&edit)?;
        Ok(if let Edit::Add { name, .. } = edit { name } else { String::new() })
    }
}

/// All inputs with a wire and all outputs, those that are fewer wires away from one of them first.
fn readers_by_distance(graph: &Graph, from: &Reader) -> Vec<Reader> {
    let mut readers = Vec::new();
    for (index, node) in graph.nodes.iter().enumerate() {
        for (port, wire) in node.wires.iter().enumerate().filter(|(_, wire)| wire.is_some()) {
            let reader = Reader::input(&node.name, &node.kind().inputs()[port].name);
            readers.push((reader, Some(index), *wire));
        }
    }
    readers.extend(graph.outputs.iter().map(|output| (Reader::Output(output.name.clone()), None, Some(output.source))));
    let node_of = |source: Option<Source>| if let Some(Source::Node { node, .. }) = source { Some(node) } else { None };
    // The nodes that so many wires reach, from both ends of the wire of `from`.
    let ends = readers.iter().find(|(reader, ..)| reader == from).map(|(_, node, source)| [*node, node_of(*source)]);
    let mut reached: Vec<usize> = ends.into_iter().flatten().flatten().collect();
    let mut distances: BTreeMap<usize, usize> = BTreeMap::new();
    for distance in 0.. {
        reached.retain(|node| !distances.contains_key(node));
        if reached.is_empty() {
            break;
        }
        distances.extend(reached.iter().map(|node| (*node, distance)));
        let wires = readers.iter().filter_map(|(_, node, source)| Some(((*node)?, node_of(*source)?)));
        let next = wires.flat_map(|(a, b)| [(a, b), (b, a)]).filter(|(at, _)| reached.contains(at));
        reached = next.map(|(_, other)| other).collect();
    }
    let distance = |node: Option<usize>| node.and_then(|node| distances.get(&node).copied()).unwrap_or(usize::MAX);
    readers.sort_by_key(|(_, node, source)| distance(*node).min(distance(node_of(*source))));
    readers.into_iter().map(|(reader, ..)| reader).collect()
}

/// The name of a node, a parameter or a wire after an edit; `None` if it is gone.
fn name_after(edit: &Edit, before: &str) -> Option<String> {
    let (Edit::Rename { node, .. } | Edit::Remove { node }) = edit else { return Some(before.to_owned()) };
    match (before.strip_prefix(&**node).filter(|rest| rest.is_empty() || rest.starts_with(['.', '/'])), edit) {
        (None, _) => Some(before.to_owned()),
        (Some(rest), Edit::Rename { name, .. }) => Some(format!("{name}{rest}")),
        (Some(_), _) => None,
    }
}
