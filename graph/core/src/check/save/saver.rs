//! From changes to a text that is checked again.

use indexmap::IndexMap;

use super::edits::Edits;
use super::state::{State, stated};
use crate::check::files::Files;
use crate::check::{Checker, Loader};
use crate::document::{Document, parse, without_mark};
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

/// New values by their keys, and whether the tier gives the value of before.
type NewValues = IndexMap<String, (Value, bool)>;

/// A pipeline file into whose text changes are written.
pub struct Saver<'a> {
    document: Document,
    text: &'a str,
    registry: &'a Registry,
    loader: &'a dyn Loader,
    files: Files<'a>,
}

/// The tier at which values change, and the new tier that is to have them, if there is one.
#[derive(Clone, Copy)]
struct Tiers<'t> {
    changed: Option<&'t str>,
    new: Option<&'t str>,
}

impl<'a> Saver<'a> {
    /// Reads a text. `file` is the name that messages show, and that files named in the text are relative to.
    ///
    /// # Errors
    /// The syntax errors of the text.
    pub fn new(file: &str, text: &'a str, registry: &'a Registry, loader: &'a dyn Loader) -> Result<Self, Diagnostics> {
        let document = parse(file, text)?;
        if document.problems.has_errors() {
            return Err(document.problems);
        }
        Ok(Self { document, text, registry, loader, files: Files::new(loader) })
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
        let state = self.state(&self.document, tier)?;
        let values = new_values(&state, changes)?;
        if values.is_empty() {
            return Ok(self.text.to_owned());
        }
        let mut edits = Edits::default();
        for (key, (value, _)) in &values {
            edits.write(&state, tier, key, value);
        }
        self.verified(&state, edits, Tiers { changed: tier, new: None }, &values)
    }

    /// The text with a new tier, which is the pipeline at `tier` with changes. The rest stays.
    ///
    /// # Errors
    /// Those of [`Self::save`], and a name that a tier has.
    pub fn save_as_tier(&self, name: &str, tier: Option<&str>, changes: &[Change]) -> Result<String, Diagnostics> {
        let state = self.state(&self.document, tier)?;
        if let Some((first, _)) = state.document.tiers.iter().find(|(known, _)| known.value == name) {
            let message = format!("the pipeline has a tier {} already", quote(name));
            let error = Diagnostic::error("doubled", message).also(&first.location, "this tier");
            return Err(state.error(error.help("choose another name")));
        }
        let values = new_values(&state, changes)?;
        let mut edits = Edits::default();
        edits.add_tier(name, tier.map(|tier| state.overrides(tier)).unwrap_or_default());
        for (key, (value, _)) in &values {
            edits.add_override(Some(name), key, state.text(state.settings[key].is_switch, value));
        }
        self.verified(&state, edits, Tiers { changed: tier, new: Some(name) }, &values)
    }

    fn state(&self, document: &Document, tier: Option<&str>) -> Result<State<'_>, Diagnostics> {
        State::new(document, self.registry, &self.files, tier)
    }

    /// The edited text, with overrides in the tiers whose values would change otherwise.
    fn verified(
        &self,
        state: &State<'_>,
        mut edits: Edits,
        tiers: Tiers<'_>,
        values: &NewValues,
    ) -> Result<String, Diagnostics> {
        let text = without_mark(self.text);
        for (tier, key, value) in self.differences(&edits.apply(text), tiers, values)? {
            if let Some(tier) = tier {
                edits.add_to_tier(state, &tier, &key, state.text(state.settings[&key].is_switch, &value));
            }
        }
        let saved = edits.apply(text);
        if let Some((_, key, _)) = self.differences(&saved, tiers, values)?.first() {
            let message = format!("{} cannot be saved: no text is known that gives this value", quote(key));
            return Err(state.error(Diagnostic::error("not-saved", message).help("write the value by hand")));
        }
        self.check(&saved, tiers)?;
        let mark = &self.text[..self.text.len() - text.len()];
        Ok(format!("{mark}{saved}"))
    }

    /// At all tiers, the keys whose values a text does not have: the new ones where they apply, and those of before.
    fn differences(
        &self,
        text: &str,
        tiers: Tiers<'_>,
        values: &NewValues,
    ) -> Result<Vec<(Option<String>, String, Value)>, Diagnostics> {
        let saved = parse(&self.document.file, text)?;
        let mut different = Vec::new();
        for tier in self.state(&saved, None)?.tiers() {
            let is_new = tier.is_some() && tier.as_deref() == tiers.new;
            let before = self.state(&self.document, if is_new { tiers.changed } else { tier.as_deref() })?;
            let after = self.state(&saved, tier.as_deref())?;
            for (key, setting) in &before.settings {
                // A value that a tier gives changes at that tier alone; any other one where no tier gives its own.
                let applies = |was_of_tier: bool| match tiers.new {
                    Some(_) => is_new,
                    None => tier.as_deref() == tiers.changed || !was_of_tier && !setting.is_of_tier,
                };
                let new = values.get(key).filter(|(_, was_of_tier)| applies(*was_of_tier));
                let expected = new.map_or_else(|| before.stated(setting), |(value, _)| value.clone());
                if after.settings.get(key).map(|setting| after.stated(setting)).as_ref() != Some(&expected) {
                    different.push((tier.clone(), key.clone(), expected));
                }
            }
        }
        Ok(different)
    }

    /// Checks that a text is right at all tiers at which it was right before. An error that the text had before at the
    /// tier that is saved is shown in that text.
    fn check(&self, text: &str, tiers: Tiers<'_>) -> Result<(), Diagnostics> {
        let saved = parse(&self.document.file, text)?;
        let checker = Checker::new(&saved, self.registry, self.loader);
        let before = Checker::new(&self.document, self.registry, self.loader);
        for tier in self.state(&saved, None)?.tiers() {
            let Err(errors) = checker.check(tier.as_deref(), &[]) else { continue };
            let is_new = tier.is_some() && tier.as_deref() == tiers.new;
            let tier = if is_new { tiers.changed } else { tier.as_deref() };
            match (before.check(tier, &[]), tier) {
                (Err(errors), _) if tier == tiers.changed => return Err(errors),
                (Ok(_), Some(other)) if tier != tiers.changed => return Err(wrong_tier(&saved, other, errors)),
                (Ok(_), _) => return Err(errors),
                (Err(_), _) => {}
            }
        }
        Ok(())
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
fn new_value(state: &State<'_>, key: &str, value: &Value) -> Result<(String, Option<Value>), Diagnostic> {
    let (name, field) = key.rsplit_once('.').unwrap_or((key, ""));
    let draft = state.node(name).ok_or_else(|| unknown_node(state, name))?;
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
    let new = stated(value, &state.document.file);
    let is_new = setting.value != *value && state.stated(setting) != new;
    Ok((key.to_owned(), is_new.then_some(new)))
}

/// A switch in place of another one; `None` if the node is on or off already.
fn new_switch(
    state: &State<'_>,
    changes: &[Change],
    name: &str,
    on: bool,
) -> Result<(String, Option<Value>), Diagnostic> {
    let setting = state.settings.get(name).filter(|setting| setting.is_switch);
    let setting = setting.ok_or_else(|| unknown_node(state, name))?;
    let becomes_off = |scope: &&str| {
        let switched = |change: &Change| match change {
            Change::Enabled { node, on } => (node == scope).then_some(!on),
            Change::Value { .. } => None,
        };
        let is_off = || state.settings.get(*scope).is_some_and(|setting| setting.value == Value::Bool(false));
        changes.iter().rev().find_map(switched).unwrap_or_else(is_off)
    };
    let outer = name.rmatch_indices('/').map(|(end, _)| &name[..end]).find(becomes_off);
    match outer {
        Some(outer) if on => {
            let message = format!("{} cannot be on while {} is off", quote(name), quote(outer));
            Err(Diagnostic::error("off-around", message).help(format!("switch {} on", quote(outer))))
        }
        _ => {
            let is_off = outer.is_some() || setting.value == Value::Bool(false);
            Ok((name.to_owned(), (is_off == on).then_some(Value::Bool(on))))
        }
    }
}

fn unknown_node(state: &State<'_>, name: &str) -> Diagnostic {
    let names = || state.settings.iter().filter(|(_, setting)| setting.is_switch).map(|(name, _)| name.as_str());
    Diagnostic::error("unknown-node", format!("no node is called {}", quote(name)))
        .help(format!("the nodes are {}", list(names(), 12)))
        .did_you_mean(name, names())
}

/// The errors of a tier that a change for all tiers makes wrong.
fn wrong_tier(saved: &Document, tier: &str, errors: Diagnostics) -> Diagnostics {
    let message = format!("the change cannot be saved: at the tier {} it is wrong", quote(tier));
    let named = saved.tiers.iter().find(|(name, _)| name.value == tier);
    let location = named.map_or(&saved.location, |(name, _)| &name.location);
    let mut all = Diagnostics::new(errors.sources.clone());
    all.push(Diagnostic::error("wrong-at-tier", message).at(location, "").help("change the value of the tier first"));
    all.absorb(errors);
    all
}
