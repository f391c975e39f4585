//! Wires, and the keys of overrides, as texts: the nodes that they name.

use super::state::{State, Stated};
use crate::check::connect::WireText;
use crate::document::{Document, Override, Tier, Tree};
use crate::node::Fallback;
use afterimage_base::diagnostic::Location;

/// A key with another name of its node in it; `None` if it is not that of the node.
pub(super) fn renamed_key(key: &str, node: &str, name: &str) -> Option<String> {
    let rest = key.strip_prefix(node)?;
    (rest.is_empty() || rest.starts_with(['.', '/'])).then(|| format!("{name}{rest}"))
}

/// A wire with another name of its node in it; `None` if it does not come from the node.
pub(super) fn renamed_wire(wire: &str, node: &str, name: &str) -> Option<String> {
    let rest = wire.strip_prefix(node)?;
    (rest.is_empty() || rest.starts_with(['.', '@'])).then(|| format!("{name}{rest}"))
}

/// A wire that the file itself writes.
pub(super) struct OwnWire<'d> {
    /// The node that reads it; `None` for an output of the pipeline.
    pub(super) reader: Option<&'d str>,
    pub(super) wire: &'d str,
    pub(super) location: &'d Location,
    /// It stands for one that the file has by itself or inherits.
    pub(super) is_override: bool,
}

/// The wires that a file itself writes: in its nodes, its outputs and its overrides. `state` is that of the file.
pub(super) fn own_wires<'d>(document: &'d Document, state: &State<'_>) -> Vec<OwnWire<'d>> {
    let is_wire = |key: &str| matches!(state.settings.get(key).map(|setting| &setting.value), Some(Stated::Wire(_)));
    let mut wires = Vec::new();
    for node in &document.nodes {
        for (field, item) in &node.fields.entries {
            if let (Tree::Text(wire), true) = (&item.value, is_wire(&format!("{}.{}", node.name.value, field.value))) {
                let (reader, location) = (Some(&*node.name.value), &item.location);
                wires.push(OwnWire { reader, wire, location, is_override: false });
            }
        }
    }
    for output in &document.outputs {
        let (wire, location) = (&*output.source.value, &output.source.location);
        wires.push(OwnWire { reader: None, wire, location, is_override: document.extends.is_some() });
    }
    for Override { key, value } in own_overrides(document) {
        if let (Tree::Text(wire), true, Some((node, _))) =
            (&value.value, is_wire(&key.value), key.value.split_once('.'))
        {
            wires.push(OwnWire { reader: Some(node), wire, location: &value.location, is_override: true });
        }
    }
    wires
}

/// The overrides that a file itself writes, in `set` and in its tiers.
pub(super) fn own_overrides(document: &Document) -> impl Iterator<Item = &Override> {
    let of_tiers = document.tiers.iter().filter_map(|(_, tier)| match tier {
        Tier::Settings(settings) => Some(settings),
        Tier::File(_) => None,
    });
    document.set.iter().chain(of_tiers.flatten())
}

/// Wires in place of the outputs of a node that goes: those of the inputs that the outputs fall back to.
pub(super) struct MainWires<'n> {
    node: &'n str,
    /// By the names of the outputs; `None` where the readers lose their wires.
    outputs: Vec<(String, Option<String>)>,
    /// In place of outputs that are not listed: those of a pipeline used as a node.
    other: Option<String>,
}

impl<'n> MainWires<'n> {
    pub(super) fn of(state: &State<'_>, node: &'n str) -> Self {
        let wire = |input: &str| match state.settings.get(&format!("{node}.{input}")).map(|setting| &setting.value) {
            Some(Stated::Wire(Some(wire))) if renamed_wire(wire, node, "").is_none() => Some(wire.clone()),
            _ => None,
        };
        let Some(kind) = state.node(node).map(|draft| &draft.kind) else {
            let scope = state.expansion.drafted.scopes.iter().find(|scope| scope.name.value == node);
            let other = scope.and_then(|scope| scope.inputs.iter().find_map(|(input, _)| wire(&input.name.value)));
            return Self { node, outputs: Vec::new(), other };
        };
        let of_type = |ty| kind.inputs().iter().filter(move |input| input.ty == ty).find_map(|input| wire(&input.name));
        let outputs = kind.outputs().iter().map(|output| match &output.fallback {
            Fallback::Input(input) => (output.name.to_string(), wire(input)),
            Fallback::Zero | Fallback::Absent => (output.name.to_string(), of_type(output.ty)),
        });
        Self { node, outputs: outputs.collect(), other: None }
    }

    /// The wire in place of one that comes from the node, which may be none; `None` if it does not come from it.
    pub(super) fn in_place_of(&self, wire: &str) -> Option<Option<String>> {
        let WireText { node, port, previous } = WireText::parse(wire).ok()?;
        if node != self.node {
            return None;
        }
        let output = match port {
            Some(port) => self.outputs.iter().find(|(name, _)| name == port),
            None => self.outputs.first(),
        };
        let main = output.map_or(&self.other, |(_, wire)| wire);
        Some(main.as_ref().map(|main| earlier(main, previous)))
    }

    /// Replaces a wire that comes from the node.
    pub(super) fn replace(&self, value: &mut Stated) {
        if let Stated::Wire(Some(wire)) = value
            && let Some(other) = self.in_place_of(wire)
        {
            *value = Stated::Wire(other);
        }
    }
}

/// A wire so many frames earlier.
pub(super) fn earlier(wire: &str, frames: u32) -> String {
    let own = WireText::parse(wire).map_or(0, |parsed| parsed.previous);
    let path = wire.split_once('@').map_or(wire, |(path, _)| path);
    match own + frames {
        0 => path.to_owned(),
        1 => format!("{path}@previous"),
        frames => format!("{path}@previous:{frames}"),
    }
}

#[cfg(test)]
mod tests {
    use super::{earlier, renamed_key, renamed_wire};

    #[test]
    fn only_the_name_of_the_node_changes() {
        for (wire, renamed) in [
            ("glow", Some("lit")),
            ("glow.result", Some("lit.result")),
            ("glow@previous", Some("lit@previous")),
            ("glow.a@previous:2", Some("lit.a@previous:2")),
            ("glowing", None),
            ("a.glow", None),
        ] {
            assert_eq!(renamed_wire(wire, "glow", "lit").as_deref(), renamed, "{wire}");
        }
        for (key, renamed) in [
            ("glow", Some("lit")),
            ("glow.strength", Some("lit.strength")),
            ("glow/mips.levels", Some("lit/mips.levels")),
            ("glow2.strength", None),
            ("@glow", None),
        ] {
            assert_eq!(renamed_key(key, "glow", "lit").as_deref(), renamed, "{key}");
        }
    }

    #[test]
    fn frames_add_up() {
        for (wire, frames, sum) in [
            ("a", 0, "a"),
            ("a.b", 1, "a.b@previous"),
            ("a.b@previous", 1, "a.b@previous:2"),
            ("a@previous:2", 0, "a@previous:2"),
        ] {
            assert_eq!(earlier(wire, frames), sum);
        }
    }
}
