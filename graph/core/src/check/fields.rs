//! Fields of nodes: wires, parameters, and what every node takes.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use super::condition::{Condition, FactKind};
use super::draft::NodeDraft;
use super::files::Files;
use super::inherit::UsedFiles;
use super::limits::{MAX_EVERY, MAX_NAME};
use super::reports::Reports;
use crate::document::{Document, Field, Item, Tree, doubled};
use crate::node::Bake;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Location, Spanned, list, quote, shown};
use afterimage_base::image::Format;

/// Fields that every node has, besides its ports and parameters.
pub const NODE_FIELDS: [&str; 5] = ["when", "format", "bake", "every", "label"];

/// Reads the fields of nodes and the files that they name, and reports what is wrong with them.
pub(super) struct FieldReader<'a> {
    pub(super) used: UsedFiles<'a>,
    pub(super) reports: Reports,
    /// The kind of each fact that a condition uses, and its first use.
    facts: BTreeMap<String, (FactKind, Location)>,
}

impl<'a> FieldReader<'a> {
    pub(super) fn new(files: &'a Files<'a>, diagnostics: Diagnostics) -> Self {
        Self { used: UsedFiles::new(files), reports: Reports::new(diagnostics), facts: BTreeMap::new() }
    }

    /// The document with what it inherits.
    pub(super) fn inherited(&mut self, document: &Document) -> Document {
        self.used.inherited(document, &mut self.reports)
    }

    /// The document of a file that another one names, with what it inherits. `None` where an error has been reported.
    pub(super) fn document(&mut self, named: &Spanned<String>) -> Option<Document> {
        let document = self.used.document(named, &mut self.reports)?;
        Some(self.inherited(&document))
    }

    /// The fields without those whose name has occurred before.
    pub(super) fn unique(&mut self, fields: &[Field]) -> Vec<Field> {
        let mut seen: BTreeMap<&str, &Location> = BTreeMap::new();
        let mut kept: Vec<Field> = Vec::new();
        for (name, item) in fields {
            match seen.entry(&name.value) {
                Entry::Occupied(first) => self.reports.diagnostics.push(doubled(name, first.get(), "field")),
                Entry::Vacant(first) => {
                    first.insert(&name.location);
                    kept.push((name.clone(), item.clone()));
                }
            }
        }
        kept
    }

    /// Sets a parameter or one of what every node takes; false if the node has no such field. `facts` are those
    /// that the node's file declares.
    pub(super) fn change_field(
        &mut self,
        draft: &mut NodeDraft,
        facts: Option<&[String]>,
        name: &str,
        item: &Item,
    ) -> bool {
        let kind = draft.kind.clone();
        if let Some((index, param)) = kind.param(name) {
            if let Some(value) = self.value(&kind, param, item) {
                draft.values[index] = value;
                draft.written[index] = Some(item.location.clone());
            }
            return true;
        }
        match name {
            "when" => draft.when = self.condition(facts, item),
            "format" => draft.format = self.format(item),
            "bake" => draft.bake = self.bake(item),
            "every" => draft.every = self.every(item),
            "label" => draft.label = self.label(item),
            _ => return false,
        }
        true
    }

    /// The text of a wire.
    pub(super) fn wire(&mut self, port: &str, item: &Item) -> Option<Spanned<String>> {
        if let Tree::Text(text) = &item.value {
            return Some(Spanned::new(text.clone(), item.location.clone()));
        }
        if item.value.is_broken() {
            return None;
        }
        let message = format!("the port {} takes the name of a node or an input in quotes", quote(port));
        let diagnostic =
            Diagnostic::error("wrong-type", message).at(&item.location, format!("this is {}", item.value.describe()));
        self.reports.push(match &item.value {
            Tree::Name(name) => diagnostic.help(format!("write `{port}: \"{name}\"`")).rewrite(format!("\"{name}\"")),
            _ => diagnostic.help(format!("write `{port}: \"name\"`")),
        });
        None
    }

    /// Reads a node's `when`; `known` lists the facts that its file declares.
    pub(super) fn condition(&mut self, known: Option<&[String]>, item: &Item) -> Option<Condition> {
        let Tree::Text(text) = &item.value else {
            if item.value.is_broken() {
                return None;
            }
            let message = format!("`when` is a condition in quotes, not {}", item.value.describe());
            let diagnostic = Diagnostic::error("wrong-type", message).at(&item.location, "");
            self.reports.push(match &item.value {
                Tree::Name(name) => diagnostic.help(format!("write `when: \"{name}\"`")).rewrite(format!("\"{name}\"")),
                _ => diagnostic.help("write it as `when: \"emissive and illuminance < 10\"`"),
            });
            return None;
        };
        let inner = self.inner_location(item, text);
        match Condition::parse(text) {
            Ok(condition) => {
                self.facts_of(known, &condition, inner.as_ref().unwrap_or(&item.location));
                Some(condition)
            }
            Err(error) => {
                let location = inner.map_or(item.location.clone(), |inner| inner.part(error.span));
                self.reports.push(Diagnostic::error("condition", error.message).at(&location, "").help(error.help));
                None
            }
        }
    }

    /// The location of a text within its quotes; `None` if escapes make it longer than it is.
    fn inner_location(&self, item: &Item, text: &str) -> Option<Location> {
        let written = self.reports.diagnostics.sources.text(&item.location.file)?.get(item.location.span())?;
        let start = written.find(text)?;
        Some(item.location.part(start..start + text.len()))
    }

    /// Facts must be declared where the file declares facts, and be of one kind everywhere.
    fn facts_of(&mut self, known: Option<&[String]>, condition: &Condition, location: &Location) {
        for (name, kind) in condition.uses() {
            let location = self.fact_location(location, name);
            if let Some(known) = known
                && !known.iter().any(|known| known == name)
            {
                let help = if known.is_empty() {
                    "the section `facts` is empty".into()
                } else {
                    format!("the section `facts` has {}", list(known.iter().map(String::as_str), 8))
                };
                let diagnostic = Diagnostic::error("unknown-fact", format!("no fact is called {}", quote(name)))
                    .at(&location, "")
                    .help(help);
                self.reports.push(self.reports.with_nearest(diagnostic, name, known.iter().map(String::as_str)));
                continue;
            }
            self.fact_kind(name, kind, &location);
        }
    }

    fn fact_location(&self, condition: &Location, name: &str) -> Location {
        let text = self.reports.diagnostics.sources.text(&condition.file).and_then(|text| text.get(condition.span()));
        match text.and_then(|text| text.find(name)) {
            Some(start) => condition.part(start..start + name.len()),
            None => condition.clone(),
        }
    }

    fn fact_kind(&mut self, name: &str, kind: FactKind, location: &Location) {
        let (known, first) = self.facts.entry(name.to_owned()).or_insert_with(|| (kind, location.clone()));
        if *known != kind {
            let message =
                format!("the fact {} is used as {} and as {}", quote(name), known.describe(), kind.describe());
            let diagnostic = Diagnostic::error("fact-kind", message)
                .at(location, format!("here it is {}", kind.describe()))
                .also(first, format!("here it is {}", known.describe()));
            self.reports.push(diagnostic.help("the host can tell it only one way: use two names"));
        }
    }

    pub(super) fn format(&mut self, item: &Item) -> Option<Format> {
        let names = Format::ALL.map(Format::name);
        let diagnostic = match &item.value {
            Tree::Name(name) => match Format::named(name) {
                Some(format) => return Some(format),
                None => Diagnostic::error("unknown-format", format!("no format is called {}", quote(name)))
                    .at(&item.location, "")
                    .help(format!("the formats are {}", list(names, names.len())))
                    .did_you_mean(name, names),
            },
            Tree::Text(name) if Format::named(name).is_some() => {
                Diagnostic::error("wrong-type", "`format` is the bare name of a format")
                    .at(&item.location, "this is a text in quotes")
                    .help(format!("write {} without quotes", quote(name)))
                    .rewrite(name)
            }
            Tree::Broken => return None,
            other => Diagnostic::error("wrong-type", "`format` is the bare name of a format")
                .at(&item.location, format!("this is {}", other.describe()))
                .help(format!("the formats are {}", list(names, names.len()))),
        };
        self.reports.push(diagnostic);
        None
    }

    /// Reads a node's `bake`: the size of its LUT, or that it stays out of one.
    pub(super) fn bake(&mut self, item: &Item) -> Option<Bake> {
        let known = match &item.value {
            Tree::Name(name) => Bake::named(name),
            Tree::Int(size) => Bake::named(&size.to_string()),
            Tree::Broken => return None,
            _ => None,
        };
        if known.is_none() {
            let sizes = Bake::SIZES.map(|size| size.to_string());
            let names: Vec<&str> = ["Off", "Auto"].into_iter().chain(sizes.iter().map(String::as_str)).collect();
            let diagnostic = Diagnostic::error("unknown-bake", "`bake` is `Off`, `Auto` or the size of a table")
                .at(&item.location, format!("this is {}", item.value.describe()))
                .help(format!("its values are {}", list(names.iter().copied(), names.len())));
            self.reports.push(match &item.value {
                Tree::Name(name) => diagnostic.did_you_mean(name, ["Off", "Auto"]),
                _ => diagnostic,
            });
        }
        known
    }

    /// In one of how many frames a node runs.
    pub(super) fn every(&mut self, item: &Item) -> u32 {
        match item.value {
            Tree::Int(frames) if (1..=i64::from(MAX_EVERY)).contains(&frames) => return frames as u32,
            Tree::Broken => return 1,
            _ => {}
        }
        let diagnostic = Diagnostic::error("bad-every", format!("`every` is a number from 1 to {MAX_EVERY}"))
            .at(&item.location, format!("this is {}", item.value.describe()))
            .help("`every: 4` runs the node in each fourth frame");
        self.reports.push(diagnostic);
        1
    }

    fn short_label(&mut self, label: &str, location: &Location) -> Option<String> {
        if label.len() > MAX_NAME {
            let error = Diagnostic::error("long-name", format!("the label has {} bytes", label.len()));
            self.reports.push(error.at(location, "").help(format!("a label has at most {MAX_NAME} bytes")));
            return None;
        }
        Some(shown(label).into_owned())
    }

    pub(super) fn label(&mut self, item: &Item) -> Option<String> {
        if let Tree::Text(label) = &item.value {
            return self.short_label(label, &item.location);
        }
        if item.value.is_broken() {
            return None;
        }
        let diagnostic = Diagnostic::error("wrong-type", "`label` is a text in quotes");
        self.reports.push(diagnostic.at(&item.location, format!("this is {}", item.value.describe())));
        None
    }
}
