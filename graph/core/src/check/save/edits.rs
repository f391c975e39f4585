//! Edits of the text of a pipeline file, which are made together.

use std::ops::Range;

use indexmap::IndexMap;

use super::state::{Setting, State};
use crate::document::edit;
use afterimage_base::value::Value;

/// Edits that have been decided.
#[derive(Default)]
pub(super) struct Edits {
    /// Values in place of others.
    replaced: Vec<(Range<usize>, String)>,
    /// Fields of nodes: the first byte of the kind, the name and the value.
    fields: Vec<(usize, String, String)>,
    /// Overrides of tiers, and of the section `set`.
    overrides: IndexMap<Option<String>, IndexMap<String, String>>,
}

impl Edits {
    /// Adds a tier with overrides.
    pub(super) fn add_tier(&mut self, tier: &str, overrides: IndexMap<String, String>) {
        self.overrides.insert(Some(tier.to_owned()), overrides);
    }

    /// Adds an override to a tier, or to the section `set`.
    pub(super) fn add_override(&mut self, tier: Option<&str>, key: &str, value: String) {
        self.overrides.entry(tier.map(str::to_owned)).or_default().insert(key.to_owned(), value);
    }

    /// Adds an override to a tier. A tier that the file inherits is copied into it, because a tier replaces the
    /// inherited one of its name.
    pub(super) fn add_to_tier(&mut self, state: &State<'_>, tier: &str, key: &str, value: String) {
        let named = state.document.tiers.iter().find(|(name, _)| name.value == tier);
        let is_own = named.is_some_and(|(name, _)| name.location.file == state.document.file);
        if !is_own && !self.overrides.contains_key(&Some(tier.to_owned())) {
            self.add_tier(tier, state.overrides(tier));
        }
        self.add_override(Some(tier), key, value);
    }

    /// Writes a value where the setting is given; `tier` is the one of the state.
    pub(super) fn write(&mut self, state: &State<'_>, tier: Option<&str>, key: &str, value: &Value) {
        let setting = &state.settings[key];
        let text = state.text(setting.is_switch, value);
        match (&setting.written, setting.kind_start, tier) {
            (Some(location), ..) if location.file == state.document.file => {
                self.replace(state, location.span(), setting, value);
            }
            (Some(_), _, Some(tier)) if setting.is_of_tier => self.add_to_tier(state, tier, key, text),
            (None, Some(kind), _) => {
                let (_, name) = key.rsplit_once('.').expect("the key of a parameter has its name");
                self.fields.push((kind, name.to_owned(), text));
            }
            _ => self.add_override(None, key, text),
        }
    }

    fn replace(&mut self, state: &State<'_>, span: Range<usize>, setting: &Setting, value: &Value) {
        match (&setting.value, value) {
            (Value::Vector(old, n), Value::Vector(new, _)) => {
                let text =
                    state.expansion.fields.reports.diagnostics.sources.text(&state.document.file).unwrap_or_default();
                let numbers = edit::numbers(text, &span).into_iter().zip(old.iter().zip(new).take(*n));
                let changed = numbers.filter(|(_, (old, new))| old != new);
                self.replaced.extend(changed.map(|(span, (_, new))| (span, Value::Float(*new).to_string())));
            }
            _ => self.replaced.push((span, state.text(setting.is_switch, value))),
        }
    }

    /// The text with all edits. Those whose places are known are made from the end on, so that none moves another one.
    pub(super) fn apply(&self, text: &str) -> String {
        let mut text = text.to_owned();
        let replaced = self.replaced.iter().map(|(span, value)| (span.start, Ok((span, value))));
        let fields = self.fields.iter().map(|(kind, name, value)| (*kind, Err((name, value))));
        let mut placed: Vec<_> = replaced.chain(fields).collect();
        placed.sort_by_key(|(start, _)| std::cmp::Reverse(*start));
        for (start, edit) in placed {
            text = match edit {
                Ok((span, value)) => edit::replaced(&text, span.clone(), value),
                Err((name, value)) => edit::with_field(&text, start, name, value),
            };
        }
        for (tier, overrides) in &self.overrides {
            if let (Some(tier), true) = (tier, overrides.is_empty()) {
                text = edit::with_tier(&text, tier);
            }
            for (key, value) in overrides {
                text = edit::with_override(&text, tier.as_deref(), key, value);
            }
        }
        text
    }
}
