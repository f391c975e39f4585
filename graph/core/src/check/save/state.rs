//! Values of a document at a tier, with their locations.

use std::collections::BTreeSet;

use indexmap::IndexMap;

use super::path::{join_written, relative};
use crate::check::draft::NodeDraft;
use crate::check::expand::Expansion;
use crate::check::files::{Files, join};
use crate::document::{Document, Override, Tier, Tree};
use crate::node::Registry;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Location, quote};
use afterimage_base::value::{FileValue, Type, Value};

/// Target of an override: a parameter, or the switch of a node or of a pipeline used as a node.
pub(super) struct Setting {
    /// The value; that of a switch is a flag, `true` for on.
    pub(super) value: Value,
    pub(super) is_switch: bool,
    /// The place of the value; `None` for defaults.
    pub(super) written: Option<Location>,
    /// True if the tier gives the value.
    pub(super) is_of_tier: bool,
    /// The first byte of the node's kind, of a parameter of a node that the file itself has.
    pub(super) kind_start: Option<usize>,
}

/// A document at a tier.
pub(super) struct State<'a> {
    pub(super) document: Document,
    pub(super) expansion: Expansion<'a>,
    /// By the keys of overrides: `node.parameter`, or the name of what is switched.
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
        let setting = |value, is_switch, written: &Option<Location>, kind_start| {
            let is_of_tier = written.as_ref().is_some_and(|location| of_tier.contains(location));
            Setting { value, is_switch, written: written.clone(), is_of_tier, kind_start }
        };
        let mut settings = IndexMap::new();
        for draft in &expansion.drafted.nodes {
            let name = expansion.drafted.full_name(draft);
            let is_own = draft.scope == 0 && draft.kind_location.file == document.file;
            for (index, param) in draft.kind.params().iter().enumerate() {
                let kind_start = is_own.then_some(draft.kind_location.start);
                let value = draft.values[index].clone();
                settings
                    .insert(format!("{name}.{}", param.name), setting(value, false, &draft.written[index], kind_start));
            }
            settings.insert(name, setting(Value::Bool(!draft.off), true, &draft.switched, None));
        }
        for (index, scope) in expansion.drafted.scopes.iter().enumerate().skip(1) {
            let switch = setting(Value::Bool(!scope.off), true, &scope.switched, None);
            settings.insert(expansion.drafted.full_scope_name(index), switch);
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
    pub(super) fn stated(&self, setting: &Setting) -> Value {
        stated(&setting.value, setting.written.as_ref().map_or(&self.document.file, |location| &location.file))
    }

    /// A value that was [stated](Self::stated), as the file writes it.
    pub(super) fn text(&self, is_switch: bool, value: &Value) -> String {
        match value {
            Value::Bool(on) if is_switch => if *on { "On" } else { "Off" }.to_owned(),
            Value::File(named) => format!("{:?}", relative(&self.document.file, &named.path)),
            value => value.to_string(),
        }
    }

    /// One error of the document.
    pub(super) fn error(&self, error: Diagnostic) -> Diagnostics {
        let mut errors = Diagnostics::new(self.expansion.fields.reports.diagnostics.sources.clone());
        errors.push(error.at(&self.document.location, ""));
        errors
    }
}

/// A value that a file states.
pub(super) fn stated(value: &Value, file: &str) -> Value {
    match value {
        Value::File(named) => Value::File(FileValue { path: join_written(file, &named.path).into(), bytes: None }),
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
