//! Edits of the text of a pipeline file, which are made together.

use std::ops::Range;

use indexmap::IndexMap;

use super::state::{Setting, State, Stated, output_key};
use crate::document::{edit, entry};
use afterimage_base::value::Value;

/// Place of a new node among the entries of `nodes`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    First,
    /// After the node whose kind begins at that byte.
    After(usize),
    Last,
}

/// Edits that have been decided.
#[derive(Clone, Default, PartialEq)]
pub(super) struct Edits {
    /// Values in place of others.
    replaced: Vec<(Range<usize>, String)>,
    /// Fields of nodes: the first byte of the kind, the name and the value.
    fields: Vec<(usize, String, String)>,
    /// Entries that go: the first bytes of their values.
    removed: Vec<usize>,
    /// New nodes.
    nodes: Vec<(Place, String)>,
    /// Outputs in place of inherited ones.
    outputs: IndexMap<String, String>,
    /// Overrides of tiers, and of the section `set`.
    overrides: IndexMap<Option<String>, IndexMap<String, String>>,
}

/// An edit at a place that is known before any edit is made.
enum Placed<'e> {
    Replace(&'e Range<usize>, &'e str),
    Field(&'e str, &'e str),
    Remove,
    After(&'e str),
}

impl Edits {
    /// Returns whether they change nothing.
    pub(super) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

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

    /// Adds a node: its name, its kind and its fields, as an entry.
    pub(super) fn add_node(&mut self, place: Place, entry: String) {
        self.nodes.push((place, entry));
    }

    /// Removes the entry whose value begins at that byte.
    pub(super) fn remove(&mut self, value: usize) {
        if !self.removed.contains(&value) {
            self.removed.push(value);
        }
    }

    /// Replaces what is written in a span.
    pub(super) fn replace(&mut self, span: Range<usize>, text: String) {
        self.replaced.push((span, text));
    }

    /// Writes a value where the setting is given; `tier` is the one of the state.
    pub(super) fn write(&mut self, state: &State<'_>, tier: Option<&str>, key: &str, value: &Stated) {
        let setting = &state.settings[key];
        let own = setting.written.as_ref().filter(|location| location.file == state.document.file);
        let Some(text) = state.text(value) else {
            return own.into_iter().for_each(|location| self.remove(location.start));
        };
        match (own, &setting.written, setting.kind_start, tier) {
            (Some(location), ..) => self.replace_value(state, location.span(), setting, (value, text)),
            (None, Some(_), _, Some(tier)) if setting.is_of_tier => self.add_to_tier(state, tier, key, text),
            (None, None, Some(kind), _) => {
                let (_, name) = key.rsplit_once('.').expect("the key of a field has its name");
                self.fields.push((kind, name.to_owned(), text));
            }
            _ => match state.document.outputs.iter().find(|output| output_key(&output.name.value) == key) {
                Some(output) => {
                    let text = if output.has_coverage { with_coverage(&text) } else { text };
                    self.outputs.insert(output.name.value.clone(), text);
                }
                None => self.add_override(None, key, text),
            },
        }
    }

    fn replace_value(
        &mut self,
        state: &State<'_>,
        span: Range<usize>,
        setting: &Setting,
        (value, text): (&Stated, String),
    ) {
        match (&setting.value, value) {
            (Stated::Value(Value::Vector(old, n)), Stated::Value(Value::Vector(new, _))) => {
                let numbers = edit::numbers(state.own_text(), &span).into_iter().zip(old.iter().zip(new).take(*n));
                let changed = numbers.filter(|(_, (old, new))| old != new);
                self.replaced.extend(changed.map(|(span, (_, new))| (span, Value::Float(*new).to_string())));
            }
            _ => self.replace(span, text),
        }
    }

    /// The text with all edits.
    pub(super) fn apply(&self, text: &str) -> String {
        let mut edited = self.apply_placed(text);
        for (place, entry) in &self.nodes {
            edited = match place {
                Place::First => entry::with_first_entry(&edited, "nodes", entry),
                Place::Last => edit::with_entry(&edited, &["nodes"], entry),
                Place::After(_) => continue,
            };
        }
        for (name, source) in &self.outputs {
            edited = edit::with_entry(&edited, &["outputs"], &format!("{name:?}: {source}"));
        }
        for (tier, overrides) in &self.overrides {
            if let (Some(tier), true) = (tier, overrides.is_empty()) {
                edited = edit::with_tier(&edited, tier);
            }
            for (key, value) in overrides {
                edited = edit::with_override(&edited, tier.as_deref(), key, value);
            }
        }
        if self.removed.is_empty() { edited } else { without_emptied_sections(text, &edited) }
    }

    /// Those whose places are known are made from the end on, so that none moves another one.
    fn apply_placed(&self, text: &str) -> String {
        let mut placed: Vec<(usize, Placed<'_>)> = Vec::new();
        placed.extend(self.replaced.iter().map(|(span, value)| (span.start, Placed::Replace(span, value))));
        placed.extend(self.fields.iter().map(|(kind, name, value)| (*kind, Placed::Field(name, value))));
        placed.extend(self.removed.iter().map(|value| (*value, Placed::Remove)));
        for (place, entry) in &self.nodes {
            if let Place::After(kind) = place {
                placed.push((*kind, Placed::After(entry)));
            }
        }
        placed.sort_by_key(|(start, _)| std::cmp::Reverse(*start));
        placed.into_iter().fold(text.to_owned(), |text, (start, edit)| match edit {
            Placed::Replace(span, value) => edit::replaced(&text, span.clone(), value),
            Placed::Field(name, value) => edit::with_field(&text, start, name, value),
            Placed::Remove => entry::without_entry(&text, start),
            Placed::After(new) => entry::with_entry_after(&text, start, new),
        })
    }
}

/// An output with its option, of which another file has declared that its alpha is coverage.
fn with_coverage(source: &str) -> String {
    format!("Output(source: {source}, alpha: Coverage)")
}

/// A text without the sections whose last entry went. A file needs the others unless it extends another one.
fn without_emptied_sections(before: &str, after: &str) -> String {
    let extends = edit::has_section(before, "extends");
    let sections = if extends { &["set", "nodes", "outputs"][..] } else { &["set"] };
    let had_entries = |section: &&&str| entry::without_empty_section(before, section) == before;
    let emptied = sections.iter().filter(had_entries);
    emptied.fold(after.to_owned(), |text, section| entry::without_empty_section(&text, section))
}
