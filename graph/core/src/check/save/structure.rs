//! Edits of nodes and wires: each becomes a few edits of spans of the text.

use std::rc::Rc;

use super::edits::{Edits, Place};
use super::file::Before;
use super::proof::{Effect, NewValues, Proof, Tiers};
use super::reader::Reader;
use super::refusals::{free_name, inherited_wire, no_input, own_node, unread_output};
use super::saver::Saver;
use super::state::{State, Stated};
use super::wires::{MainWires, own_overrides, own_wires, renamed_key, renamed_wire};
use crate::check::connect::WireText;
use crate::document::NodeEntry;
use crate::node::NodeKind;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, quote};

/// An edit of the nodes and wires of a pipeline.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Edit {
    /// Something reads another wire.
    Connect {
        /// The input or output.
        reader: Reader,
        /// The wire, such as `node.port@previous`; `None` for an optional input that is to have none.
        wire: Option<String>,
    },
    /// A new node comes between an input or output and what it reads.
    Insert {
        /// The kind of the node.
        kind: String,
        /// Its name.
        name: String,
        /// The input or output that is to read it.
        reader: Reader,
    },
    /// A new node that nothing reads yet.
    Add {
        /// The kind of the node.
        kind: String,
        /// Its name.
        name: String,
        /// The wires of its inputs, by their names.
        inputs: Vec<(String, String)>,
    },
    /// A node goes. What reads it reads the node's main input instead: the one that takes its place where it is off.
    Remove {
        /// Its name.
        node: String,
    },
    /// A node gets another name, in every wire and override of the file, too.
    Rename {
        /// Its name.
        node: String,
        /// The new one.
        name: String,
    },
    /// A node is on or off at the tier that is shown, whatever it is elsewhere.
    SwitchAtTier {
        /// Its name; `outer/inner` for one inside of a pipeline used as a node.
        node: String,
        /// True if it is on; `None` if it shall be what it is elsewhere.
        on: Option<bool>,
    },
}

impl Saver<'_> {
    /// The text with an edit of the pipeline at a tier. Of what an inherited node reads, it is an override in `set`.
    ///
    /// # Errors
    /// Names that are unknown or taken, nodes that another file writes, and all that makes the edited text wrong at
    /// this tier or at another one that was right before.
    pub fn edit(&self, tier: Option<&str>, edit: &Edit) -> Result<String, Diagnostics> {
        Prepared::new(&Before::new(&self.file), tier, edit)?.text()
    }
}

/// An edit as edits of the text, which are still to be proven.
pub(super) struct Prepared<'b, 's> {
    state: Rc<State<'s>>,
    proof: Proof<'b, 's, 'b>,
    edits: Edits,
    /// Edits that take an override back, which leave less text if they are right.
    shorter: Option<Edits>,
}

impl<'b, 's> Prepared<'b, 's> {
    pub(super) fn new(before: &'b Before<'s>, tier: Option<&'b str>, edit: &Edit) -> Result<Self, Diagnostics> {
        let state = before.state(tier)?;
        let mut edits = Edits::default();
        let effect = match edit {
            Edit::Connect { reader, wire } => connect(&state, tier, (reader, wire), &mut edits),
            Edit::Insert { kind, name, reader } => insert(&state, tier, (kind, name, reader), &mut edits),
            Edit::Add { kind, name, inputs } => add(&state, (kind, name, inputs), &mut edits),
            Edit::Remove { node } => {
                let everywhere = before.state(None)?;
                own_node(before, &state, node).and_then(|entry| remove(before, &everywhere, (entry, false), &mut edits))
            }
            Edit::Rename { node, name } => own_node(before, &state, node).and_then(|entry| {
                free_name(&state, name)?;
                rename(before, &state, (entry, name), &mut edits);
                Ok(Effect::Renamed { node: node.clone(), name: name.clone() })
            }),
            Edit::SwitchAtTier { node, on } => switch(&state, tier, (node, *on), &mut edits),
        };
        let effect = effect.map_err(|error| state.error(error))?;
        let shorter = match edit {
            _ if edits.is_empty() => None,
            Edit::Connect { reader, wire: Some(_) } => without_override(before, &state, &reader.key()),
            Edit::Remove { node } => without_node_and_overrides(before, node)?,
            _ => None,
        };
        let proof = Proof { before, tiers: Tiers { changed: tier, new: None }, effect };
        Ok(Self { state, proof, edits, shorter })
    }

    /// The edited text, which is right and says what it is to say at every tier.
    pub(super) fn text(self) -> Result<String, Diagnostics> {
        if self.edits.is_empty() {
            return Ok(self.proof.before.file.text.to_owned());
        }
        let shorter = self.shorter.and_then(|edits| self.proof.text_if_it_holds(&edits));
        shorter.map_or_else(|| self.proof.proven(&self.state, self.edits), Ok)
    }

    /// The edited text before any proof.
    pub(super) fn unproven(&self) -> String {
        self.edits.apply(self.state.own_text())
    }
}

/// Edits that take back the override that gives a wire.
fn without_override(before: &Before<'_>, state: &State<'_>, key: &str) -> Option<Edits> {
    let written = state.settings[key].written.as_ref()?;
    let wires = own_wires(&before.file.document, state);
    let mut edits = Edits::default();
    edits.remove(written.start);
    wires.iter().any(|wire| wire.is_override && wire.location == written).then_some(edits)
}

/// Edits that remove a node and take back the overrides by which it was read; `None` if there are none.
fn without_node_and_overrides(before: &Before<'_>, node: &str) -> Result<Option<Edits>, Diagnostics> {
    let (document, everywhere) = (&before.file.document, before.state(None)?);
    let Some(entry) = document.nodes.iter().find(|entry| entry.name.value == node) else { return Ok(None) };
    let wires = own_wires(document, &everywhere);
    let is_read = wires.iter().any(|wire| wire.is_override && renamed_wire(wire.wire, node, "").is_some());
    let mut edits = Edits::default();
    let is_removed = remove(before, &everywhere, (entry, true), &mut edits).is_ok();
    Ok(Some(edits).filter(|_| is_removed && is_read))
}

fn connect(
    state: &State<'_>,
    tier: Option<&str>,
    (reader, wire): (&Reader, &Option<String>),
    edits: &mut Edits,
) -> Result<Effect, Diagnostic> {
    let key = reader.key();
    let setting = state.settings.get(&key).filter(|setting| matches!(setting.value, Stated::Wire(_)));
    let setting = setting.ok_or_else(|| no_input(state, reader))?;
    let value = Stated::Wire(wire.clone());
    if setting.value == value {
        return Ok(Effect::Values(NewValues::new()));
    }
    if let (None, Some(location)) = (wire, &setting.written) {
        if let Reader::Output(name) = reader {
            return Err(unread_output(name));
        }
        if location.file != state.document.file {
            return Err(inherited_wire(reader, location));
        }
    }
    edits.write(state, tier, &key, &value);
    Ok(Effect::Values(NewValues::from_iter([(key, (value, setting.is_of_tier))])))
}

fn insert(
    state: &State<'_>,
    tier: Option<&str>,
    (kind, name, reader): (&str, &str, &Reader),
    edits: &mut Edits,
) -> Result<Effect, Diagnostic> {
    let present = state.settings.get(&reader.key()).map(|setting| &setting.value);
    let Some(Stated::Wire(Some(wire))) = present else {
        return Err(match present {
            Some(Stated::Wire(None)) => Diagnostic::error("not-edited", format!("nothing is wired to {reader}"))
                .help("add the node, and wire it then"),
            _ => no_input(state, reader),
        });
    };
    let inputs = match state.expansion.registry.get(kind).map(main_input) {
        Some(Some(input)) => vec![(input.to_owned(), wire.clone())],
        Some(None) => {
            let message = format!("{} reads nothing: it cannot come between two nodes", quote(kind));
            return Err(Diagnostic::error("not-edited", message));
        }
        // The check knows the names of kinds.
        None => Vec::new(),
    };
    add(state, (kind, name, &inputs), edits)?;
    connect(state, tier, (reader, &Some(name.to_owned())), edits)
}

/// The input that a node of the kind reads its image from.
pub(super) fn main_input(kind: &NodeKind) -> Option<&str> {
    let required = kind.inputs().iter().find(|input| !input.optional);
    required.or(kind.inputs().first()).map(|input| &*input.name)
}

fn add(
    state: &State<'_>,
    (kind, name, inputs): (&str, &str, &[(String, String)]),
    edits: &mut Edits,
) -> Result<Effect, Diagnostic> {
    free_name(state, name)?;
    let wires: Vec<String> = inputs.iter().map(|(input, wire)| format!("{input}: {wire:?}")).collect();
    let place = inputs.first().map_or(Place::Last, |(_, wire)| place_after(state, wire));
    edits.add_node(place, format!("{name:?}: {kind}({})", wires.join(", ")));
    Ok(Effect::Values(NewValues::new()))
}

/// The place of a node that reads a wire: after the node that it comes from, or before all if it comes from elsewhere.
fn place_after(state: &State<'_>, wire: &str) -> Place {
    let source = WireText::parse(wire).map_or("", |wire| wire.node);
    let entry = state.document.nodes.iter().find(|entry| entry.name.value == source);
    let own = entry.filter(|entry| entry.kind.location.file == state.document.file);
    own.map_or(Place::First, |entry| Place::After(entry.kind.location.start))
}

fn remove(
    before: &Before<'_>,
    state: &State<'_>,
    (entry, takes_back): (&NodeEntry, bool),
    edits: &mut Edits,
) -> Result<Effect, Diagnostic> {
    let (document, node) = (&before.file.document, &*entry.name.value);
    let main = MainWires::of(state, node);
    for wire in own_wires(document, state).into_iter().filter(|wire| wire.reader != Some(node)) {
        match (main.in_place_of(wire.wire), wire.reader) {
            (Some(Some(_)), _) if takes_back && wire.is_override => edits.remove(wire.location.start),
            (Some(Some(other)), _) => edits.replace(wire.location.span(), format!("{other:?}")),
            (Some(None), Some(_)) => edits.remove(wire.location.start),
            (Some(None), None) => {
                let message =
                    format!("an output of the pipeline reads {}, and nothing can take its place", quote(node));
                return Err(Diagnostic::error("not-edited", message).help("wire the output to another node first"));
            }
            (None, _) => {}
        }
    }
    for own in own_overrides(document).filter(|own| renamed_key(&own.key.value, node, "").is_some()) {
        edits.remove(own.value.location.start);
    }
    for (_, meaning) in document.usual.iter().filter(|(key, _)| renamed_key(&key.value, node, "").is_some()) {
        edits.remove(meaning.location.start);
    }
    for (key, wire) in inherited_wires(state) {
        match main.in_place_of(wire) {
            Some(Some(other)) => edits.add_override(None, key, format!("{other:?}")),
            Some(None) => {
                let message = format!("{} of another file reads {}", quote(key), quote(node));
                return Err(Diagnostic::error("not-edited", message).help("wire it to another node first"));
            }
            None => {}
        }
    }
    edits.remove(entry.kind.location.start);
    Ok(Effect::Removed(node.to_owned()))
}

/// The wires of inherited nodes that other files write, by their keys.
fn inherited_wires<'s>(state: &'s State<'_>) -> impl Iterator<Item = (&'s str, &'s str)> {
    state.settings.iter().filter_map(|(key, setting)| match (&setting.value, &setting.written) {
        (Stated::Wire(Some(wire)), Some(location)) if location.file != state.document.file => {
            Some((key.as_str(), wire.as_str()))
        }
        _ => None,
    })
}

fn rename(before: &Before<'_>, state: &State<'_>, (entry, name): (&NodeEntry, &str), edits: &mut Edits) {
    let (document, node) = (&before.file.document, &*entry.name.value);
    edits.replace(entry.name.location.span(), format!("{name:?}"));
    for wire in own_wires(document, state) {
        if let Some(renamed) = renamed_wire(wire.wire, node, name) {
            edits.replace(wire.location.span(), format!("{renamed:?}"));
        }
    }
    let usual = document.usual.iter().map(|(key, _)| key);
    for key in own_overrides(document).map(|own| &own.key).chain(usual) {
        if let Some(renamed) = renamed_key(&key.value, node, name) {
            edits.replace(key.location.span(), format!("{renamed:?}"));
        }
    }
    for (key, wire) in inherited_wires(state) {
        if let Some(renamed) = renamed_wire(wire, node, name) {
            edits.add_override(None, key, format!("{renamed:?}"));
        }
    }
}

fn switch(
    state: &State<'_>,
    tier: Option<&str>,
    (node, on): (&str, Option<bool>),
    edits: &mut Edits,
) -> Result<Effect, Diagnostic> {
    let Some(tier) = tier else {
        let message = format!("no tier is shown at which {} could differ", quote(node));
        return Err(Diagnostic::error("not-edited", message).help("choose a tier first"));
    };
    let setting = state.settings.get(node).filter(|setting| setting.is_switch());
    let setting = setting.ok_or_else(|| state.unknown_node(node))?;
    let of_tier = setting.written.as_ref().filter(|_| setting.is_of_tier);
    let own = of_tier.filter(|location| location.file == state.document.file);
    match (on, own, of_tier) {
        (Some(on), _, _) if setting.value == Stated::Switch(on) => return Ok(Effect::Values(NewValues::new())),
        (Some(on), Some(own), _) => edits.replace(own.span(), if on { "On" } else { "Off" }.to_owned()),
        (Some(on), None, _) => edits.add_to_tier(state, tier, node, if on { "On" } else { "Off" }.to_owned()),
        (None, Some(own), _) => edits.remove(own.start),
        (None, None, Some(other)) => {
            let message = format!("{} is switched at this tier in {}", quote(node), quote(&other.file));
            return Err(Diagnostic::error("not-edited", message).help("switch it here: this file then has the tier"));
        }
        (None, None, None) => return Ok(Effect::Values(NewValues::new())),
    }
    Ok(Effect::SwitchedAtTier { node: node.to_owned(), on })
}
