//! Changes whose subjects have been found, and the errors of those that cannot be made.

use std::collections::BTreeMap;

use indexmap::IndexMap;

use super::change::Change;
use super::state::{SetTo, State, Subject};
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, list, quote};
use afterimage_base::value::Value;

/// A change that the text needs.
#[derive(Clone, Debug)]
pub(super) struct ResolvedChange {
    pub(super) subject: Subject,
    pub(super) set_to: SetTo,
    /// The value as the file writes it.
    pub(super) text: String,
    /// Whether the tier gives the value that is changed.
    pub(super) is_of_tier: bool,
}

/// The changes that differ from the state, each subject once; of several of one subject the last.
pub(super) fn resolve(state: &State<'_>, changes: &[Change]) -> Result<Vec<ResolvedChange>, Diagnostics> {
    let mut last = IndexMap::new();
    let mut errors = Diagnostics::new(state.builder.diagnostics.sources.clone());
    let scopes = switched_scopes(state, changes);
    for change in changes {
        let found = match change {
            Change::Value { parameter, value } => changed(state, parameter, value),
            Change::Enabled { node, on } => switched(state, &scopes, node, *on),
        };
        match found {
            Ok((subject, change)) => drop(last.insert(subject, change)),
            Err(error) => errors.push(error.at(&state.document.location, "")),
        }
    }
    if errors.is_empty() { Ok(last.into_values().flatten().collect()) } else { Err(errors) }
}

/// How a node is switched.
pub(super) fn switch(off: bool) -> &'static str {
    if off { "Off" } else { "On" }
}

/// The pipelines used as nodes that changes switch, and whether they are off then.
fn switched_scopes(state: &State<'_>, changes: &[Change]) -> BTreeMap<usize, bool> {
    let switched = |change: &Change| match change {
        Change::Enabled { node, on } => Some((state.scope(node)?, !on)),
        Change::Value { .. } => None,
    };
    changes.iter().filter_map(switched).collect()
}

fn changed(state: &State<'_>, parameter: &str, value: &Value) -> Result<(Subject, Option<ResolvedChange>), Diagnostic> {
    let (name, field) = parameter.rsplit_once('.').unwrap_or((parameter, ""));
    let node = state.node(name).ok_or_else(|| unknown_node(state, name))?;
    let draft = state.draft(node);
    let Some((index, param)) = draft.kind.param(field) else {
        let known = || draft.kind.params().iter().map(|param| &*param.name);
        let message = format!("{} has no parameter {}", quote(name), quote(field));
        let help = format!("{} has {}", quote(draft.kind.name()), list(known(), 16));
        let error = Diagnostic::error("unknown-field", message).help(help);
        return Err(error.did_you_mean(field, known()));
    };
    if let Err(why) = param.accepts(value) {
        return Err(Diagnostic::error("out-of-domain", format!("{} cannot be saved: {why}", quote(parameter))));
    }
    let subject = Subject::Value(node, index);
    let set_to = SetTo::value(value, &state.document.file);
    let is_new = draft.values[index] != *value && state.set_to(subject) != set_to;
    let is_of_tier = state.is_of_tier(subject);
    Ok((subject, is_new.then(|| ResolvedChange { subject, set_to, text: value.to_string(), is_of_tier })))
}

fn switched(
    state: &State<'_>,
    scopes: &BTreeMap<usize, bool>,
    name: &str,
    on: bool,
) -> Result<(Subject, Option<ResolvedChange>), Diagnostic> {
    let of_scope = || state.scope(name).map(Subject::Scope);
    let subject = state.node(name).map(Subject::Node).or_else(of_scope).ok_or_else(|| unknown_node(state, name))?;
    let outer = state.outer(subject).find(|scope| scopes.get(scope).copied().unwrap_or(state.is_scope_off(*scope)));
    let is_off = outer.is_some() || state.set_to(subject) == SetTo::Off(true);
    match outer {
        Some(outer) if on => {
            let outer = state.key(Subject::Scope(outer));
            let message = format!("{} cannot be on while {} is off", quote(name), quote(&outer));
            Err(Diagnostic::error("off-around", message).help(format!("switch {} on", quote(&outer))))
        }
        _ => {
            let (set_to, is_of_tier) = (SetTo::Off(!on), state.is_of_tier(subject));
            let change = ResolvedChange { subject, set_to, text: switch(!on).to_owned(), is_of_tier };
            Ok((subject, (is_off == on).then_some(change)))
        }
    }
}

fn unknown_node(state: &State<'_>, name: &str) -> Diagnostic {
    Diagnostic::error("unknown-node", format!("no node is called {}", quote(name)))
        .help(format!("the nodes are {}", list(state.names(), 12)))
        .did_you_mean(name, state.names())
}
