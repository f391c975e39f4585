//! Values of a document at a tier, with their locations.

use std::collections::BTreeSet;

use indexmap::IndexMap;

use super::path::{join_written, relative};
use crate::check::draft::{Feed, NodeDraft};
use crate::check::expand::Expansion;
use crate::check::files::{Files, join};
use crate::document::{Document, Override, Tier, Tree};
use crate::node::Registry;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Location, Spanned, list, quote};
use afterimage_base::value::{FileValue, Type, Value};

/// A value, a switch or a wire as a file states it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Stated {
    Value(Value),
    /// True for a node, or a pipeline used as a node, that is on.
    Switch(bool),
    /// The text of a wire; `None` for an input that has none.
    Wire(Option<String>),
}

/// Target of an override: a parameter, a wire, or the switch of a node or of a pipeline used as a node.
pub(super) struct Setting {
    pub(super) value: Stated,
    /// The place of the value; `None` for defaults.
    pub(super) written: Option<Location>,
    /// True if the tier gives the value.
    pub(super) is_of_tier: bool,
    /// The first byte of the node's kind, of a parameter or an input of a node that the file itself has.
    pub(super) kind_start: Option<usize>,
}

impl Setting {
    pub(super) fn is_switch(&self) -> bool {
        matches!(self.value, Stated::Switch(_))
    }
}

/// The key of an output of the pipeline. No other key begins with this sign.
pub(super) fn output_key(name: &str) -> String {
    format!("@{name}")
}

/// A document at a tier.
pub(super) struct State<'a> {
    pub(super) document: Document,
    pub(super) expansion: Expansion<'a>,
    /// By the keys of overrides: `node.parameter`, `node.input`, or the name of what is switched; and by those of
    /// [outputs](output_key).
    pub(super) settings: IndexMap<String, Setting>,
}

impl<'a> State<'a> {
    /// The state of a document without errors in its nodes and overrides; all errors that were found otherwise.
    pub(super) fn new(
        document: &Document,
        registry: &'a Registry,
        files: &'a Files<'a>,
        tier: Option<&str>,
    ) -> Result<Self, Diagnostics> {
        let mut expansion = Expansion::new(registry, files, document.problems.clone());
        let document = expansion.fields.inherited(document);
        expansion.fields.reports.diagnostics.absorb(file_tier(&document, tier));
        let document = expansion.tier(document, tier);
        expansion.expand_top(&document);
        if expansion.fields.used.has_document(&join("", &document.file)) {
            expansion.fields.reports.push(used_twice(&document));
        }
        let made = expansion.changes.iter().filter(|change| change.tier.is_some() && expansion.is_made(change));
        let values = made.flat_map(|change| &change.settings).map(|setting| setting.value.location.clone());
        let of_tier: BTreeSet<Location> = values.collect();
        expansion.change();
        if expansion.fields.reports.diagnostics.has_errors() {
            return Err(expansion.fields.reports.diagnostics.sorted());
        }
        let setting = |value, written: Option<&Location>, kind_start| {
            let is_of_tier = written.is_some_and(|location| of_tier.contains(location));
            Setting { value, written: written.cloned(), is_of_tier, kind_start }
        };
        let own = |kind: &Location| (kind.file == document.file).then_some(kind.start);
        let wire = |text: Option<&Spanned<String>>, kind: Option<usize>| {
            setting(Stated::Wire(text.map(|text| text.value.clone())), text.map(|text| &text.location), kind)
        };
        let mut settings = IndexMap::new();
        for draft in &expansion.drafted.nodes {
            let name = expansion.drafted.full_name(draft);
            let kind_start = own(&draft.kind_location).filter(|_| draft.scope == 0);
            for (index, param) in draft.kind.params().iter().enumerate() {
                let value = Stated::Value(draft.values[index].clone());
                let written = draft.written[index].as_ref();
                settings.insert(format!("{name}.{}", param.name), setting(value, written, kind_start));
            }
            // Wires within pipelines used as nodes are those of other files.
            let inputs = draft.kind.inputs().iter().zip(&draft.wire_texts).filter(|_| draft.scope == 0);
            for (port, text) in inputs {
                settings.insert(format!("{name}.{}", port.name), wire(text.as_ref(), kind_start));
            }
            settings.insert(name, setting(Stated::Switch(!draft.off), draft.switched.as_ref(), None));
        }
        for (index, scope) in expansion.drafted.scopes.iter().enumerate().skip(1) {
            let name = expansion.drafted.full_scope_name(index);
            let entry = document.nodes.iter().find(|entry| entry.name.value == name);
            for (input, feed) in scope.inputs.iter().filter(|_| scope.parent == Some(0)) {
                let text = if let Feed::Wire(text) = feed { Some(text) } else { None };
                let kind_start = entry.and_then(|entry| own(&entry.kind.location));
                settings.insert(format!("{name}.{}", input.name.value), wire(text, kind_start));
            }
            settings.insert(name, setting(Stated::Switch(!scope.off), scope.switched.as_ref(), None));
        }
        for output in &document.outputs {
            settings.insert(output_key(&output.name.value), wire(Some(&output.source), None));
        }
        Ok(Self { document, expansion, settings })
    }

    pub(super) fn node(&self, name: &str) -> Option<&NodeDraft> {
        self.expansion.drafted.nodes.iter().find(|draft| self.expansion.drafted.full_name(draft) == name)
    }

    /// The names of the tiers that are overrides, and before them `None`.
    pub(super) fn tiers(&self) -> Vec<Option<String>> {
        let own = self.document.tiers.iter().filter(|(_, tier)| matches!(tier, Tier::Settings(_)));
        std::iter::once(None).chain(own.map(|(name, _)| Some(name.value.clone()))).collect()
    }

    /// The overrides of a tier, as the saved file writes them; none if it is a file, or if there is no such tier.
    pub(super) fn overrides(&self, tier: &str) -> IndexMap<String, String> {
        let named = self.document.tiers.iter().find(|(name, _)| name.value == tier);
        let Some((_, Tier::Settings(overrides))) = named else { return IndexMap::new() };
        let copied = |setting: &Override| Some((setting.key.value.clone(), self.copied(setting)?));
        overrides.iter().filter_map(copied).collect()
    }

    /// The value of an override; a path is written from the folder of the saved file.
    fn copied(&self, setting: &Override) -> Option<String> {
        let (location, own) = (&setting.value.location, &self.document.file);
        let param = setting.key.value.rsplit_once('.').and_then(|(node, field)| self.node(node)?.kind.param(field));
        if let (Tree::Text(path), Some(Type::File)) = (&setting.value.value, param.map(|(_, param)| param.ty)) {
            let [here, there] = [own, &location.file].map(|file| join_written(file, path));
            if here != there {
                return Some(format!("{:?}", relative(own, &there)));
            }
        }
        let text = self.expansion.fields.reports.diagnostics.sources.text(&location.file)?;
        text.get(location.span()).map(str::to_owned)
    }

    /// The value of a setting. Paths are relative to the folder of the program, and files have no bytes.
    pub(super) fn stated(&self, setting: &Setting) -> Stated {
        stated(&setting.value, setting.written.as_ref().map_or(&self.document.file, |location| &location.file))
    }

    /// A value that was [stated](Self::stated), as the file writes it; `None` for a wire that is none.
    pub(super) fn text(&self, value: &Stated) -> Option<String> {
        Some(match value {
            Stated::Switch(on) => if *on { "On" } else { "Off" }.to_owned(),
            Stated::Value(Value::File(named)) => format!("{:?}", relative(&self.document.file, &named.path)),
            Stated::Value(value) => value.to_string(),
            Stated::Wire(wire) => format!("{:?}", wire.as_ref()?),
        })
    }

    /// The text of the document, without a mark at its beginning.
    pub(super) fn own_text(&self) -> &str {
        self.expansion.fields.reports.diagnostics.sources.text(&self.document.file).unwrap_or_default()
    }

    /// The error of a node that is not there.
    pub(super) fn unknown_node(&self, name: &str) -> Diagnostic {
        let names = || self.settings.iter().filter(|(_, setting)| setting.is_switch()).map(|(name, _)| name.as_str());
        Diagnostic::error("unknown-node", format!("no node is called {}", quote(name)))
            .help(format!("the nodes are {}", list(names(), 12)))
            .did_you_mean(name, names())
    }

    /// One error of the document.
    pub(super) fn error(&self, error: Diagnostic) -> Diagnostics {
        let mut errors = Diagnostics::new(self.expansion.fields.reports.diagnostics.sources.clone());
        errors.push(error.at(&self.document.location, ""));
        errors
    }
}

/// A value that a file states.
pub(super) fn stated(value: &Stated, file: &str) -> Stated {
    match value {
        Stated::Value(Value::File(named)) => {
            let path = join_written(file, &named.path).into();
            Stated::Value(Value::File(FileValue { path, bytes: None }))
        }
        other => other.clone(),
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
