//! Edits of the graph: each is an edit of the text, and one step of the history.

use afterimage_graph::check::{Candidate, Connection, Edit, Reader};
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

    /// All kinds.
    ///
    /// # Errors
    /// The text has errors.
    pub fn kinds(&self) -> Result<Vec<NodeKind>, Problem> {
        self.editor.ask(|saver| Ok(saver.kinds().cloned().collect()))
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

/// The name of a node, a parameter or a wire after an edit; `None` if it is gone.
fn name_after(edit: &Edit, before: &str) -> Option<String> {
    let (Edit::Rename { node, .. } | Edit::Remove { node }) = edit else { return Some(before.to_owned()) };
    match (before.strip_prefix(&**node).filter(|rest| rest.is_empty() || rest.starts_with(['.', '/'])), edit) {
        (None, _) => Some(before.to_owned()),
        (Some(rest), Edit::Rename { name, .. }) => Some(format!("{name}{rest}")),
        (Some(_), _) => None,
    }
}
