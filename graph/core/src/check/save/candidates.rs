//! Edits that are tried before they are made: what an input may read, what may read an output, and kinds that fit on a
//! wire. The answer is that of the check of the edited text, with its errors.

use super::file::Before;
use super::reader::Reader;
use super::saver::Saver;
use super::state::{State, Stated};
use super::structure::{Edit, Prepared, main_input};
use super::wires::earlier;
use crate::check::draft::{DraftGraph, Named};
use crate::document::{Document, parse};
use crate::node::NodeKind;
use afterimage_base::diagnostic::Diagnostics;

/// A wire that an input or output may get.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The input or output.
    pub reader: Reader,
    /// The wire.
    pub wire: String,
    /// Errors of the text with this wire; none if it is right.
    pub refusal: Option<Diagnostics>,
}

/// An input or output, and a wire that it may get.
pub type Connection = (Reader, String);

impl Saver<'_> {
    /// All wires of this frame, or of one so many frames earlier, for an input or output. They are not tried yet.
    ///
    /// # Errors
    /// Those that the text has by itself.
    pub fn sources(&self, tier: Option<&str>, reader: &Reader, frames: u32) -> Result<Vec<Connection>, Diagnostics> {
        let wires = wires(&*Before::new(&self.file).state(tier)?);
        Ok(wires.into_iter().map(|wire| (reader.clone(), earlier(&wire, frames))).collect())
    }

    /// All inputs and outputs for a wire. They are not tried yet.
    ///
    /// # Errors
    /// Those that the text has by itself.
    pub fn readers(&self, tier: Option<&str>, wire: &str) -> Result<Vec<Connection>, Diagnostics> {
        let before = Before::new(&self.file);
        let state = before.state(tier)?;
        let wired = state.settings.iter().filter(|(_, setting)| matches!(setting.value, Stated::Wire(_)));
        Ok(wired.filter_map(|(key, _)| Some((Reader::of_key(key)?, wire.to_owned()))).collect())
    }

    /// The answers of the check to connections at a tier. Each takes a check of the whole pipeline at every tier.
    pub fn candidates(&self, tier: Option<&str>, connections: Vec<Connection>) -> Vec<Candidate> {
        let before = Before::new(&self.file);
        connections.into_iter().map(|(reader, wire)| candidate(&before, tier, reader, wire)).collect()
    }

    /// The kinds of which a node may come between an input or output and what it reads, at a tier.
    ///
    /// # Errors
    /// Those that the text has by itself.
    pub fn kinds_between(&self, tier: Option<&str>, reader: &Reader) -> Result<Vec<&NodeKind>, Diagnostics> {
        let before = Before::new(&self.file);
        let state = before.state(tier)?;
        let fits = |kind: &&NodeKind| {
            let name = unused_name(&state, kind.name());
            let insert = Edit::Insert { kind: kind.name().to_owned(), name, reader: reader.clone() };
            tried(&before, tier, &insert).is_ok()
        };
        Ok(self.file.registry.iter().filter(|kind| main_input(kind).is_some()).filter(fits).collect())
    }

    /// All kinds that a node may have.
    pub fn kinds(&self) -> impl Iterator<Item = &NodeKind> {
        self.file.registry.iter()
    }

    /// The edit that adds a node of a kind, whose inputs get wires that fit: `preferred`, or the first one of the file.
    ///
    /// # Errors
    /// Those that the text has by itself.
    pub fn addition(&self, tier: Option<&str>, kind: &str, preferred: Option<&str>) -> Result<Edit, Diagnostics> {
        let before = Before::new(&self.file);
        let state = before.state(tier)?;
        let wires: Vec<String> = preferred.map(str::to_owned).into_iter().chain(wires(&state)).collect();
        let name = unused_name(&state, kind);
        let inputs = self.file.registry.get(kind).map_or(&[][..], |kind| kind.inputs());
        let required = inputs.iter().filter(|input| !input.optional).map(|input| input.name.to_string());
        let mut inputs: Vec<(String, String)> =
            required.map(|input| (input, wires.first().cloned().unwrap_or_default())).collect();
        for index in 0..inputs.len() {
            let with = |wire: &String| {
                let mut inputs = inputs.clone();
                inputs[index].1.clone_from(wire);
                (kind.to_owned(), name.clone(), inputs)
            };
            let fitting = wires.iter().find(|wire| is_accepted(&before, tier, with(wire), index));
            if let Some(wire) = fitting {
                inputs[index].1.clone_from(wire);
            }
        }
        Ok(Edit::Add { kind: kind.to_owned(), name, inputs })
    }

    /// A name for a new node of a kind: that of the kind in small letters, with a number if it is taken.
    ///
    /// # Errors
    /// Those that the text has by itself.
    pub fn unused_name(&self, kind: &str) -> Result<String, Diagnostics> {
        let before = Before::new(&self.file);
        Ok(unused_name(&*before.state(None)?, kind))
    }
}

fn candidate(before: &Before<'_>, tier: Option<&str>, reader: Reader, wire: String) -> Candidate {
    let edit = Edit::Connect { reader: reader.clone(), wire: Some(wire.clone()) };
    // Most are wrong at this tier already.
    let refusal = tried(before, tier, &edit).and_then(|()| Prepared::new(before, tier, &edit)?.text());
    Candidate { reader, wire, refusal: refusal.err() }
}

/// Checks an edited text at one tier.
fn tried(before: &Before<'_>, tier: Option<&str>, edit: &Edit) -> Result<(), Diagnostics> {
    let document = edited(before, tier, edit)?.1;
    before.file.check(&document, tier).map(drop)
}

/// An edited text and what it says.
fn edited(before: &Before<'_>, tier: Option<&str>, edit: &Edit) -> Result<(String, Document), Diagnostics> {
    let text = Prepared::new(before, tier, edit)?.unproven();
    let document = parse(&before.file.document.file, &text)?;
    Ok((text, document))
}

/// Returns whether no error is about one of the wires of a new node.
fn is_accepted(
    before: &Before<'_>,
    tier: Option<&str>,
    (kind, name, inputs): (String, String, Vec<(String, String)>),
    index: usize,
) -> bool {
    let add = Edit::Add { kind, name: name.clone(), inputs: inputs.clone() };
    let Ok((_, document)) = edited(before, tier, &add) else { return false };
    let Err(errors) = before.file.check(&document, tier) else { return true };
    let entry = document.nodes.iter().find(|entry| entry.name.value == name);
    let Some((_, wire)) = entry.and_then(|entry| entry.fields.entries.get(index)) else { return false };
    !errors.iter().any(|error| error.labels.iter().any(|label| label.location == wire.location))
}

/// The wires of all inputs, nodes and pipelines used as nodes, in the order of the file.
fn wires(state: &State<'_>) -> Vec<String> {
    let drafted: &DraftGraph = &state.expansion.drafted;
    let names = state.document.inputs.iter().map(|input| &input.name.value);
    let mut wires: Vec<String> = names.cloned().collect();
    for entry in &state.document.nodes {
        let name = &entry.name.value;
        let outputs: Vec<String> = match drafted.scopes[0].names.get(name) {
            Some(Named::Node(node)) => drafted.nodes[*node].kind.outputs().iter().map(|o| o.name.to_string()).collect(),
            Some(Named::Scope(inner)) => drafted.scopes[*inner].outputs.iter().map(|o| o.name.value.clone()).collect(),
            _ => Vec::new(),
        };
        // The first output is meant by the name alone.
        let further = outputs.iter().skip(1).map(|output| format!("{name}.{output}"));
        wires.extend((!outputs.is_empty()).then(|| name.clone()).into_iter().chain(further));
    }
    wires
}

/// A name that neither a node nor an input has.
fn unused_name(state: &State<'_>, kind: &str) -> String {
    let mut name = String::new();
    for c in kind.chars() {
        if c.is_uppercase() && !name.is_empty() {
            name.push('_');
        }
        name.extend(c.to_lowercase());
    }
    let is_free = |name: &String| super::refusals::free_name(state, name).is_ok();
    let numbered = (2..).map(|number| format!("{name}_{number}"));
    std::iter::once(name.clone()).chain(numbered).find(is_free).unwrap_or(name)
}
