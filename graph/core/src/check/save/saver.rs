//! From changes to a text that is checked again.

use indexmap::IndexMap;

use super::edits::Edits;
use super::file::{Before, SavedFile};
use super::proof::{Effect, NewValues, Proof, Tiers};
use super::state::{State, Stated, stated};
use crate::check::Loader;
use crate::node::Registry;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, list, quote};
use afterimage_base::value::Value;

/// A change of a graph that its text does not state.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// A parameter has another value.
    Value {
        /// `node.parameter`, as [`Graph::parameter_name`](crate::check::Graph::parameter_name) gives it.
        parameter: String,
        /// The value. The path of a file is relative to the saved file; its bytes are not needed.
        value: Value,
    },
    /// A node, or a pipeline used as a node, is switched on or off.
    Enabled {
        /// The name of the node; `outer/inner` for one inside of a pipeline used as a node.
        node: String,
        /// True if it is on.
        on: bool,
    },
}

/// A pipeline file into whose text changes are written.
pub struct Saver<'a> {
    pub(super) file: SavedFile<'a>,
}

impl<'a> Saver<'a> {
    /// Reads a text. `file` is the name that messages show, and that files named in the text are relative to.
    ///
    /// # Errors
    /// The syntax errors of the text.
    pub fn new(file: &str, text: &'a str, registry: &'a Registry, loader: &'a dyn Loader) -> Result<Self, Diagnostics> {
        Ok(Self { file: SavedFile::new(file, text, registry, loader)? })
    }

    /// The text with changes to the pipeline at a tier. Checked again at this tier, it has the new values.
    ///
    /// A value that the tier gives changes in the tier, and the other tiers keep theirs. Any other value changes for
    /// all tiers that give none of their own. A change to what the text states already changes nothing. If the tier is
    /// inherited, it is copied into the file with the change, because a tier replaces the inherited one of its name.
    ///
    /// # Errors
    /// Unknown names, values outside of their domain, a tier that is a file of its own, and all that makes the changed
    /// text wrong, at this tier or at another one that was right before. An error of a change itself points to the word
    /// `Pipeline`; one of the changed text points into that text.
    pub fn save(&self, tier: Option<&str>, changes: &[Change]) -> Result<String, Diagnostics> {
        let before = Before::new(&self.file);
        let state = before.state(tier)?;
        let values = new_values(&state, changes)?;
        if values.is_empty() {
            return Ok(self.file.text.to_owned());
        }
        let mut edits = Edits::default();
        for (key, (value, _)) in &values {
            edits.write(&state, tier, key, value);
        }
        let proof =
            Proof { before: &before, tiers: Tiers { changed: tier, new: None }, effect: Effect::Values(values) };
        proof.proven(&state, edits)
    }

    /// The text with a new tier, which is the pipeline at `tier` with changes. The rest stays.
    ///
    /// # Errors
    /// Those of [`Self::save`], and a name that a tier has.
    pub fn save_as_tier(&self, name: &str, tier: Option<&str>, changes: &[Change]) -> Result<String, Diagnostics> {
        let before = Before::new(&self.file);
        let state = before.state(tier)?;
        if let Some((first, _)) = state.document.tiers.iter().find(|(known, _)| known.value == name) {
            let message = format!("the pipeline has a tier {} already", quote(name));
            let error = Diagnostic::error("doubled", message).also(&first.location, "this tier");
            return Err(state.error(error.help("choose another name")));
        }
        let values = new_values(&state, changes)?;
        let mut edits = Edits::default();
        edits.add_tier(name, tier.map(|tier| state.overrides(tier)).unwrap_or_default());
        for (key, (value, _)) in &values {
            if let Some(text) = state.text(value) {
                edits.add_override(Some(name), key, text);
            }
        }
        let tiers = Tiers { changed: tier, new: Some(name) };
        Proof { before: &before, tiers, effect: Effect::Values(values) }.proven(&state, edits)
    }
}

/// The values of changes that differ from the state; of several of one key the last.
fn new_values(state: &State<'_>, changes: &[Change]) -> Result<NewValues, Diagnostics> {
    let mut last = IndexMap::new();
    let mut errors = Diagnostics::new(state.expansion.fields.reports.diagnostics.sources.clone());
    for change in changes {
        let found = match change {
            Change::Value { parameter, value } => new_value(state, parameter, value),
            Change::Enabled { node, on } => new_switch(state, changes, node, *on),
        };
        match found {
            Ok((key, value)) => drop(last.insert(key, value)),
            Err(error) => errors.push(error.at(&state.document.location, "")),
        }
    }
    let of_tier = |key: &str| state.settings[key].is_of_tier;
    let different = last.into_iter().filter_map(|(key, value)| Some((key.clone(), (value?, of_tier(&key)))));
    if errors.is_empty() { Ok(different.collect()) } else { Err(errors) }
}

/// A value in place of another one; `None` if the text states it already.
fn new_value(state: &State<'_>, key: &str, value: &Value) -> Result<(String, Option<Stated>), Diagnostic> {
    let (name, field) = key.rsplit_once('.').unwrap_or((key, ""));
    let draft = state.node(name).ok_or_else(|| state.unknown_node(name))?;
    let Some((_, param)) = draft.kind.param(field) else {
        let known = || draft.kind.params().iter().map(|param| &*param.name);
        let message = format!("{} has no parameter {}", quote(name), quote(field));
        let help = format!("{} has {}", quote(draft.kind.name()), list(known(), 16));
        let error = Diagnostic::error("unknown-field", message).help(help);
        return Err(error.did_you_mean(field, known()));
    };
    if let Err(why) = param.accepts(value) {
        return Err(Diagnostic::error("out-of-domain", format!("{} cannot be saved: {why}", quote(key))));
    }
    let setting = &state.settings[key];
    let value = Stated::Value(value.clone());
    let new = stated(&value, &state.document.file);
    let is_new = setting.value != value && state.stated(setting) != new;
    Ok((key.to_owned(), is_new.then_some(new)))
}

/// A switch in place of another one; `None` if the node is on or off already.
fn new_switch(
    state: &State<'_>,
    changes: &[Change],
    name: &str,
    on: bool,
) -> Result<(String, Option<Stated>), Diagnostic> {
    let setting = state.settings.get(name).filter(|setting| setting.is_switch());
    let setting = setting.ok_or_else(|| state.unknown_node(name))?;
    let becomes_off = |scope: &&str| {
        let switched = |change: &Change| match change {
            Change::Enabled { node, on } => (node == scope).then_some(!on),
            Change::Value { .. } => None,
        };
        let is_off = || state.settings.get(*scope).is_some_and(|setting| setting.value == Stated::Switch(false));
        changes.iter().rev().find_map(switched).unwrap_or_else(is_off)
    };
    let outer = name.rmatch_indices('/').map(|(end, _)| &name[..end]).find(becomes_off);
    match outer {
        Some(outer) if on => {
            let message = format!("{} cannot be on while {} is off", quote(name), quote(outer));
            Err(Diagnostic::error("off-around", message).help(format!("switch {} on", quote(outer))))
        }
        _ => {
            let is_off = outer.is_some() || setting.value == Stated::Switch(false);
            Ok((name.to_owned(), (is_off == on).then_some(Stated::Switch(on))))
        }
    }
}
