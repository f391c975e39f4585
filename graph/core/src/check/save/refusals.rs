//! Edits that cannot be made: names that are taken or unknown, and nodes that another file writes.

use super::file::Before;
use super::reader::Reader;
use super::state::{State, Stated};
use crate::document::NodeEntry;
use afterimage_base::diagnostic::{Diagnostic, Location, list, quote};

/// The entry of a node that the file itself has, and that stands for no inherited one.
pub(super) fn own_node<'b>(before: &'b Before<'_>, state: &State<'_>, name: &str) -> Result<&'b NodeEntry, Diagnostic> {
    if let Some(entry) = before.file.document.nodes.iter().find(|entry| entry.name.value == name) {
        if !before.file.inherits_node(name) {
            return Ok(entry);
        }
        let base = before.file.document.extends.as_ref().map_or("", |extends| &extends.value);
        let message = format!("{} takes the place of a node of {}", quote(name), quote(base));
        let help = "without it the other one would be there again: edit the text";
        return Err(Diagnostic::error("not-edited", message).help(help));
    }
    let inherited = state.document.nodes.iter().find(|entry| entry.name.value == name);
    if let Some(entry) = inherited {
        let file = quote(&entry.name.location.file);
        let message = format!("{} is written in {file}, which this file extends", quote(name));
        let help = format!("open {file}; here it can be switched off, or get another `label`");
        return Err(Diagnostic::error("not-edited", message).help(help));
    }
    Err(nested(state, name).unwrap_or_else(|| state.unknown_node(name)))
}

/// The refusal to edit a node inside of a pipeline used as a node.
fn nested(state: &State<'_>, name: &str) -> Option<Diagnostic> {
    let (outer, _) = name.rsplit_once('/')?;
    let file = &state.node(name)?.kind_location.file;
    let message = format!("{} is written in {}, which {} uses", quote(name), quote(file), quote(outer));
    let help = format!("open {}; here it can be switched off, and its parameters can be set", quote(file));
    Some(Diagnostic::error("not-edited", message).help(help))
}

/// Refuses a name that a node or an input has.
pub(super) fn free_name(state: &State<'_>, name: &str) -> Result<(), Diagnostic> {
    let inputs = state.document.inputs.iter().map(|input| (&input.name, "an input"));
    let nodes = state.document.nodes.iter().map(|node| (&node.name, "a node"));
    match nodes.chain(inputs).find(|(known, _)| known.value == name) {
        Some((first, what)) => {
            let error = Diagnostic::error("doubled", format!("{what} is called {} already", quote(name)));
            Err(error.also(&first.location, "this one").help("choose another name"))
        }
        None => Ok(()),
    }
}

/// The error of an input or an output that is not there, or not within reach.
pub(super) fn no_input(state: &State<'_>, reader: &Reader) -> Diagnostic {
    let (node, port) = match reader {
        Reader::Input { node, port } => (node, port),
        Reader::Output(name) => {
            let names = || state.document.outputs.iter().map(|output| output.name.value.as_str());
            return Diagnostic::error("unknown-output", format!("the pipeline has no output {}", quote(name)))
                .help(format!("its outputs are {}", list(names(), 8)))
                .did_you_mean(name, names());
        }
    };
    if let Some(refusal) = nested(state, node) {
        return refusal;
    }
    let start = format!("{node}.");
    let is_wire = |setting: &super::state::Setting| matches!(setting.value, Stated::Wire(_));
    let inputs = state.settings.iter().filter(|(_, setting)| is_wire(setting));
    let names: Vec<&str> = inputs.filter_map(|(key, _)| key.strip_prefix(&start)).collect();
    if !state.settings.contains_key(node) {
        return state.unknown_node(node);
    }
    let error = Diagnostic::error("unknown-field", format!("{} has no input {}", quote(node), quote(port)));
    let error = if names.is_empty() {
        error
    } else {
        error.help(format!("its inputs are {}", list(names.iter().copied(), 16)))
    };
    error.did_you_mean(port, names)
}

pub(super) fn unread_output(name: &str) -> Diagnostic {
    Diagnostic::error("not-edited", format!("the output {} needs a wire", quote(name)))
        .help("wire it to another node, or remove it from the text")
}

/// The refusal to take a wire away that another file writes.
pub(super) fn inherited_wire(reader: &Reader, location: &Location) -> Diagnostic {
    let file = quote(&location.file);
    let message = format!("the wire to {reader} is written in {file}: no override takes it away");
    Diagnostic::error("not-edited", message).help(format!("open {file}, or wire it to something else"))
}
