//! What a document states at a tier, and where it states it.

use std::collections::{BTreeMap, BTreeSet};

use super::path::join_written;
use crate::check::build::{GraphBuilder, NodeDraft};
use crate::check::files::{Files, join};
use crate::document::{Document, Override, Tier};
use crate::node::Registry;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Location, quote};
use afterimage_base::value::{FileValue, Value};

/// What an override can change: a parameter of a node, or whether a node or a pipeline used as a node is off. Numbers
/// are those of drafts, parameters and scopes, and the same at all tiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Subject {
    Value(usize, usize),
    Node(usize),
    Scope(usize),
}

/// What it is set to. Paths of files are relative to the folder of the program, and files have no bytes.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum SetTo {
    Value(Value),
    Off(bool),
}

/// A document at a tier.
pub(super) struct State<'a> {
    /// With what it inherits.
    pub(super) document: Document,
    pub(super) builder: GraphBuilder<'a>,
    /// The values of overrides of the tier, in all files.
    of_tier: BTreeSet<Location>,
    nodes: BTreeMap<String, usize>,
    scopes: BTreeMap<String, usize>,
}

impl<'a> State<'a> {
    /// The state of a document without errors in its nodes and overrides; all errors that were found otherwise.
    pub(super) fn new(
        document: &Document,
        registry: &'a Registry,
        files: &'a Files<'a>,
        tier: Option<&str>,
    ) -> Result<Self, Diagnostics> {
        let mut builder = GraphBuilder::new(registry, files, document.problems.clone());
        let document = builder.inherited(document);
        builder.diagnostics.absorb(file_tier(&document, tier));
        let document = builder.tier(document, tier);
        builder.expand_top(&document);
        if builder.files_used.contains(&join("", &document.file)) {
            builder.report(used_twice(&document));
        }
        let made = builder.changes.iter().filter(|change| change.tier.is_some() && builder.is_made(change));
        let values = made.flat_map(|change| &change.settings).map(|setting| setting.value.location.clone());
        let of_tier = values.collect();
        builder.change();
        if builder.diagnostics.has_errors() {
            return Err(builder.diagnostics.sorted());
        }
        let nodes = builder.drafts.iter().enumerate().map(|(index, draft)| (builder.full_name(draft), index)).collect();
        let inner = 1..builder.scopes.len();
        let scopes = inner.map(|scope| (builder.full_scope_name(scope), scope)).collect();
        Ok(Self { document, builder, of_tier, nodes, scopes })
    }

    pub(super) fn draft(&self, node: usize) -> &NodeDraft {
        &self.builder.drafts[node]
    }

    pub(super) fn node(&self, name: &str) -> Option<usize> {
        self.nodes.get(name).copied()
    }

    pub(super) fn scope(&self, name: &str) -> Option<usize> {
        self.scopes.get(name).copied()
    }

    /// The names of all nodes, and of pipelines used as nodes.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> + '_ {
        self.nodes.keys().chain(self.scopes.keys()).map(String::as_str)
    }

    /// The names of the tiers that are overrides, and before them `None`.
    pub(super) fn tiers(&self) -> Vec<Option<String>> {
        let own = self.document.tiers.iter().filter(|(_, tier)| matches!(tier, Tier::Settings(_)));
        std::iter::once(None).chain(own.map(|(name, _)| Some(name.value.clone()))).collect()
    }

    /// The overrides of a tier; none if it is a file, or if there is no such tier.
    pub(super) fn overrides(&self, tier: &str) -> &[Override] {
        match self.document.tiers.iter().find(|(name, _)| name.value == tier) {
            Some((_, Tier::Settings(settings))) => settings,
            _ => &[],
        }
    }

    /// All that overrides can change, in the order of the nodes.
    pub(super) fn subjects(&self) -> impl Iterator<Item = Subject> + '_ {
        let of_draft = |(node, draft): (usize, &NodeDraft)| {
            let values = (0..draft.values.len()).map(move |index| Subject::Value(node, index));
            values.chain([Subject::Node(node)])
        };
        let scopes = (1..self.builder.scopes.len()).map(Subject::Scope);
        self.builder.drafts.iter().enumerate().flat_map(of_draft).chain(scopes)
    }

    /// The key of an override of it.
    pub(super) fn key(&self, subject: Subject) -> String {
        match subject {
            Subject::Value(node, index) => {
                let draft = self.draft(node);
                format!("{}.{}", self.builder.full_name(draft), draft.kind.params()[index].name)
            }
            Subject::Node(node) => self.builder.full_name(self.draft(node)),
            Subject::Scope(scope) => self.builder.full_scope_name(scope),
        }
    }

    pub(super) fn set_to(&self, subject: Subject) -> SetTo {
        match subject {
            Subject::Value(node, index) => {
                let file = self.given(subject).map_or(&*self.document.file, |location| &*location.file);
                SetTo::value(&self.draft(node).values[index], file)
            }
            Subject::Node(node) => SetTo::Off(self.draft(node).off),
            Subject::Scope(scope) => SetTo::Off(self.builder.scopes[scope].off),
        }
    }

    /// Where the value that it has is written; `None` for a default.
    pub(super) fn given(&self, subject: Subject) -> Option<&Location> {
        match subject {
            Subject::Value(node, index) => self.draft(node).written[index].as_ref(),
            Subject::Node(node) => self.draft(node).switched.as_ref(),
            Subject::Scope(scope) => self.builder.scopes[scope].switched.as_ref(),
        }
    }

    /// The pipelines used as nodes around it.
    pub(super) fn outer(&self, subject: Subject) -> impl Iterator<Item = usize> + '_ {
        let parent = |scope: usize| self.builder.scopes[scope].parent;
        let first = match subject {
            Subject::Value(node, _) | Subject::Node(node) => Some(self.draft(node).scope),
            Subject::Scope(scope) => parent(scope),
        };
        std::iter::successors(first, move |scope| parent(*scope)).filter(|scope| *scope > 0)
    }

    pub(super) fn is_scope_off(&self, scope: usize) -> bool {
        self.builder.scopes[scope].off
    }

    /// Whether the tier gives the value that it has.
    pub(super) fn is_of_tier(&self, subject: Subject) -> bool {
        self.given(subject).is_some_and(|location| self.of_tier.contains(location))
    }

    /// What the nodes have that is never saved: conditions, formats, tables, the frames that they run in, labels.
    pub(super) fn others(&self) -> impl Iterator<Item = (String, Option<String>, Option<&'static str>)> + '_ {
        let builder = &self.builder;
        builder.drafts.iter().map(|draft| {
            let conditions = builder.scopes_around(draft.scope).filter_map(|scope| scope.when.as_ref());
            let conditions = draft.when.iter().chain(conditions).map(ToString::to_string);
            let conditions: Vec<String> = conditions.collect();
            let text = format!("{}: {conditions:?} {:?} {}", builder.full_name(draft), draft.bake, draft.every);
            (text, builder.full_label(draft), draft.format.map(|format| format.name()))
        })
    }
}

/// The error of a tier that is a file.
fn file_tier(document: &Document, tier: Option<&str>) -> Diagnostics {
    let mut errors = Diagnostics::default();
    let named = document.tiers.iter().find(|(name, _)| Some(name.value.as_str()) == tier);
    if let Some((name, Tier::File(file))) = named {
        let message = format!("the tier {} is a file: its values are not saved in this one", quote(&name.value));
        let error = Diagnostic::error("tier-is-a-file", message).at(&file.location, "");
        errors.push(error.help(format!("open {} and change it there", quote(&file.value))));
    }
    errors
}

/// The error of a file that a pipeline within it extends: its values stand for those of several nodes.
fn used_twice(document: &Document) -> Diagnostic {
    let message = format!("{} is extended by a pipeline that it uses as a node", quote(&document.file));
    Diagnostic::error("used-twice", message)
        .at(&document.location, "")
        .help("a value of it is one of several nodes: write the value by hand")
}

impl SetTo {
    /// A value as it is written in a file.
    pub(super) fn value(value: &Value, file: &str) -> Self {
        Self::Value(match value {
            Value::File(named) => Value::File(FileValue { path: join_written(file, &named.path).into(), bytes: None }),
            other => other.clone(),
        })
    }
}
