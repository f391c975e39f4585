//! Edits of the text of a pipeline: values are replaced, and fields, overrides and tiers are added in the layout that
//! the text has. Everything else, comments, spacing and line ends included, stays byte for byte.

mod entry;
mod layout;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use indexmap::IndexMap;

use super::parser::read;
use super::tree::{Item, Tree};
use entry::Entry;
use layout::{Edit, Layout};

/// Names and values in the order in which they are added.
type Additions = IndexMap<String, String>;

/// A text without errors, and what is to be changed in it. Values and keys are texts as RON writes them; names are
/// written in quotes by the editor.
pub(crate) struct Editor<'a> {
    layout: Layout<'a>,
    /// The first byte of `Pipeline`, of the maps of its sections, and of those of its tiers.
    pipeline: usize,
    sections: BTreeMap<String, usize>,
    tiers: BTreeMap<String, usize>,
    replaced: Vec<Edit>,
    /// By the first byte of the kind of the node.
    fields: BTreeMap<usize, Additions>,
    /// Of the section `set` and of tiers.
    overrides: IndexMap<Option<String>, Additions>,
}

impl<'a> Editor<'a> {
    pub(crate) fn new(file: &Arc<str>, text: &'a str) -> Self {
        let tree = read(file, text).tree;
        let sections = fields(&tree);
        let tiers = sections.iter().find(|(name, _)| *name == "tiers").map(|(_, tiers)| entries(tiers));
        let starts = |items: Vec<(&str, &Item)>| {
            items.into_iter().map(|(name, item)| (name.to_owned(), item.location.start)).collect()
        };
        Self {
            layout: Layout::new(file, text, tree.location.start),
            pipeline: tree.location.start,
            tiers: starts(tiers.unwrap_or_default()),
            sections: starts(sections),
            replaced: Vec::new(),
            fields: BTreeMap::new(),
            overrides: IndexMap::new(),
        }
    }

    /// Writes a value in place of another one.
    pub(crate) fn replace(&mut self, span: Range<usize>, value: String) {
        self.replaced.push(Edit { span, text: value });
    }

    /// Writes numbers in place of those of a vector; `None` leaves one as it is.
    pub(crate) fn replace_numbers(&mut self, span: Range<usize>, numbers: Vec<Option<String>>) {
        let written = self.layout.numbers(&span);
        let edits = written.into_iter().zip(numbers).filter_map(|(span, text)| Some(Edit { span, text: text? }));
        self.replaced.extend(edits);
    }

    /// Adds a field to the node whose kind begins at that byte.
    pub(crate) fn add_field(&mut self, kind: usize, name: &str, value: String) {
        self.fields.entry(kind).or_default().insert(name.to_owned(), value);
    }

    /// Adds an override to the section `set`.
    pub(crate) fn add_to_set(&mut self, key: &str, value: String) {
        self.overrides.entry(None).or_default().insert(key.to_owned(), value);
    }

    /// Whether the file has the tier, as it was read or by [`Self::add_tier`].
    pub(crate) fn has_tier(&self, tier: &str) -> bool {
        self.tiers.contains_key(tier) || self.overrides.contains_key(&Some(tier.to_owned()))
    }

    /// Adds a tier without overrides, unless it is there.
    pub(crate) fn add_tier(&mut self, tier: &str) {
        self.overrides.entry(Some(tier.to_owned())).or_default();
    }

    /// Adds an override to a tier; one that was added before gets the new value.
    pub(crate) fn add_to_tier(&mut self, tier: &str, key: &str, value: String) {
        self.overrides.entry(Some(tier.to_owned())).or_default().insert(key.to_owned(), value);
    }

    /// The text with all of the changes.
    pub(crate) fn text(&self) -> String {
        let mut edits = self.replaced.clone();
        for (kind, fields) in &self.fields {
            let fields: Vec<Entry> = fields.iter().map(|(name, value)| Entry::field(name, value)).collect();
            edits.extend(self.layout.insert(*kind, &fields));
        }
        let mut new: IndexMap<&str, Vec<Entry>> = IndexMap::new();
        for (tier, overrides) in &self.overrides {
            let overrides = overrides.iter().map(|(key, value)| Entry::named(key, value));
            match tier {
                None => new.entry("set").or_default().extend(overrides),
                Some(tier) => match self.tiers.get(tier) {
                    Some(place) => edits.extend(self.layout.insert(*place, &overrides.collect::<Vec<_>>())),
                    None => new.entry("tiers").or_default().push(Entry::tier(tier, overrides.collect())),
                },
            }
        }
        edits.extend(self.sections(new));
        self.layout.edited(edits)
    }

    /// New entries of the sections, and the sections themselves where there are none.
    fn sections(&self, new: IndexMap<&str, Vec<Entry>>) -> Vec<Edit> {
        let mut edits = Vec::new();
        let mut sections = Vec::new();
        for (section, entries) in new {
            match self.sections.get(section) {
                Some(place) => edits.extend(self.layout.insert(*place, &entries)),
                None => sections.push(Entry::section(section, entries)),
            }
        }
        edits.extend(self.layout.insert(self.pipeline, &sections));
        edits
    }
}

/// The fields of a pipeline.
fn fields(tree: &Item) -> Vec<(&str, &Item)> {
    match &tree.value {
        Tree::Struct(_, group) => group.entries.iter().map(|(name, item)| (name.value.as_str(), item)).collect(),
        _ => Vec::new(),
    }
}

/// The entries of a map whose keys are texts.
fn entries(item: &Item) -> Vec<(&str, &Item)> {
    let named = |(key, value)| match key {
        &Item { value: Tree::Text(ref name), .. } => Some((name.as_str(), value)),
        _ => None,
    };
    match &item.value {
        Tree::Map(group) => group.entries.iter().map(|(key, value)| (key, value)).filter_map(named).collect(),
        _ => Vec::new(),
    }
}
