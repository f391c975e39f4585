//! Nodes of known kinds with their ports and parameters, those of inner pipelines included.

use std::collections::BTreeMap;

use super::build::{Builder, Change, Feed, Named, NodeDraft, Scope};
use super::files::join;
use super::suggest::{kinds_near, known_kinds};
use super::{Condition, DEEPEST, MOST_NODES};
use crate::document::{Document, Field, Group, Item, NodeEntry, Tier, Tree, doubled, renamed, settings};
use crate::node::NodeKind;
use afterimage_base::diagnostic::{Diagnostic, Location, Spanned, did_you_mean, list, nearest, quote};

/// The kind name of a pipeline used as a node.
const PIPELINE: &str = "Pipeline";
/// Fields that every node has, besides its ports and parameters.
pub(super) const COMMON: [&str; 3] = ["when", "format", "label"];

/// What surrounds a pipeline that is being expanded.
struct Around {
    parent: Option<usize>,
    name: Spanned<String>,
    /// The fields of the node that a pipeline is used as, without those that are not ports.
    ports: Group<Field>,
    when: Option<Condition>,
    label: Option<String>,
}

impl Builder<'_> {
    /// The whole document, and the changes that its tier makes.
    pub(super) fn expand_top(&mut self, document: &Document) {
        let name = Spanned::new(String::new(), document.location.clone());
        let around = Around { parent: None, name, ports: Group::default(), when: None, label: None };
        self.expand(document, around, &mut vec![join("", &document.file)]);
    }

    fn expand(&mut self, document: &Document, around: Around, files: &mut Vec<String>) -> usize {
        let Around { parent, name, ports, when, label } = around;
        let facts = document.facts.as_ref().map(|facts| facts.iter().map(|(name, _)| name.value.clone()).collect());
        let scope = self.scopes.len();
        self.scopes.push(Scope {
            parent,
            name,
            inputs: Vec::new(),
            names: BTreeMap::new(),
            outputs: Vec::new(),
            when,
            off: false,
            label,
            facts,
            is_partial: document.is_partial,
        });
        for name in &document.unread {
            self.scopes[scope].names.insert(name.clone(), Named::Broken);
        }
        self.inputs(scope, document, ports);
        for entry in &document.nodes {
            if !self.has_room(&entry.name.location) {
                break;
            }
            let is_good = self.good_name(&entry.name, "node") && self.is_free(scope, &entry.name);
            let named = if is_good { self.entry(scope, entry, files) } else { Named::Broken };
            self.scopes[scope].names.insert(entry.name.value.clone(), named);
        }
        for (name, _) in &document.outputs {
            self.good_name(name, "output");
        }
        self.scopes[scope].outputs = document.outputs.clone();
        self.own_changes(scope, document);
        scope
    }

    fn own_changes(&mut self, scope: usize, document: &Document) {
        self.changes.push(Change { scope, settings: document.set.clone(), is_made: true });
        for (name, tier) in &document.tiers {
            if let Tier::Settings(settings) = tier {
                let is_made = self.tier.as_ref() == Some(&name.value);
                self.changes.push(Change { scope, settings: settings.clone(), is_made });
            }
        }
    }

    /// The inputs of a scope: the host's at the top, the ports of the node inside.
    fn inputs(&mut self, scope: usize, document: &Document, ports: Group<Field>) {
        let Group { entries: mut ports, is_partial } = ports;
        let is_top = self.scopes[scope].parent.is_none();
        for (index, input) in document.inputs.iter().enumerate() {
            if !self.good_name(&input.name, "input") {
                continue;
            }
            let wired = ports.iter().position(|(name, _)| name.value == input.name.value);
            let feed = match wired.map(|at| ports.remove(at)) {
                _ if is_top => Feed::Host(index),
                Some((name, item)) => self.wire(&name.value, &item).map_or(Feed::Absent, Feed::Wire),
                None => {
                    self.report_missing_input(scope, input.optional || is_partial, &input.name);
                    Feed::Absent
                }
            };
            let at = self.scopes[scope].inputs.len();
            self.scopes[scope].inputs.push((input.clone(), feed));
            self.scopes[scope].names.insert(input.name.value.clone(), Named::Input(at));
        }
        for (name, _) in &ports {
            let known = || document.inputs.iter().map(|input| input.name.value.as_str());
            let help = format!("its inputs are {}", list(known(), 8));
            let message = format!("the pipeline {} has no input {}", quote(&document.file), quote(&name.value));
            let diagnostic = Diagnostic::error("unknown-field", message).at(&name.location, "");
            self.report(diagnostic.help(help).maybe_help(did_you_mean(&name.value, known())));
        }
    }

    fn report_missing_input(&mut self, scope: usize, is_optional: bool, input: &Spanned<String>) {
        if !is_optional {
            let node = &self.scopes[scope].name;
            let message = format!("{} has no {}", quote(&node.value), quote(&input.value));
            let diagnostic = Diagnostic::error("missing-port", message)
                .at(&node.location, "")
                .also(&input.location, "the inner pipeline needs this input")
                .help(format!("add `{}: \"...\"`, or declare the input with `(optional: true)`", input.value));
            self.report(diagnostic);
        }
    }

    fn has_room(&mut self, location: &Location) -> bool {
        if self.drafts.len() + self.scopes.len() <= MOST_NODES {
            return true;
        }
        if !self.is_full {
            self.is_full = true;
            let message = format!("the pipeline has more than {MOST_NODES} nodes");
            let diagnostic = Diagnostic::error("too-many-nodes", message).at(location, "the first one too many");
            self.report(diagnostic.help("look for a pipeline that uses others which use others, each of them twice"));
        }
        false
    }

    /// Names are free but for the signs that wires and settings are made of.
    fn good_name(&mut self, name: &Spanned<String>, what: &str) -> bool {
        let text = &name.value;
        let message = match text.chars().find(|c| ".@/".contains(*c) || c.is_control()) {
            _ if text.is_empty() => format!("the name of this {what} is empty"),
            _ if text.trim() != text => format!("the name of this {what} begins or ends with a space"),
            Some(c) => format!("the name {} holds {}", quote(text), quote(&c.to_string())),
            None => return true,
        };
        let diagnostic = Diagnostic::error("bad-name", message).at(&name.location, "");
        self.report(diagnostic.help("names are any text without `.`, `@` and `/`, which wires and settings use"));
        false
    }

    fn is_free(&mut self, scope: usize, name: &Spanned<String>) -> bool {
        let Some(Named::Input(index)) = self.scopes[scope].names.get(&name.value) else { return true };
        let first = self.scopes[scope].inputs[*index].0.name.location.clone();
        let message = format!("a node and an input are both called {}", quote(&name.value));
        let diagnostic = Diagnostic::error("doubled", message).at(&name.location, "the node").also(&first, "the input");
        self.report(diagnostic.help("a wire could mean either: give one of them another name"));
        false
    }

    fn entry(&mut self, scope: usize, entry: &NodeEntry, files: &mut Vec<String>) -> Named {
        let fields = self.unique(&entry.fields.entries);
        if entry.kind.value == PIPELINE {
            return self.inner(scope, entry, fields, files).unwrap_or(Named::Broken);
        }
        match self.registry.get(&entry.kind.value) {
            Some(kind) => self.node(scope, entry, kind, &fields),
            None => {
                let name = &entry.kind.value;
                let message = format!("no node kind is called {}", quote(name));
                let near = kinds_near(self.registry, name);
                let help =
                    near.or_else(|| did_you_mean(name, [PIPELINE])).unwrap_or_else(|| known_kinds(self.registry));
                self.report(Diagnostic::error("unknown-kind", message).at(&entry.kind.location, "").help(help));
                Named::Broken
            }
        }
    }

    fn unique(&mut self, fields: &[Field]) -> Vec<Field> {
        let mut kept: Vec<Field> = Vec::new();
        for (name, item) in fields {
            match kept.iter().find(|(known, _)| known.value == name.value) {
                Some((first, _)) => self.diagnostics.push(doubled(name, &first.location, "field")),
                None => kept.push((name.clone(), item.clone())),
            }
        }
        kept
    }

    fn node(&mut self, scope: usize, entry: &NodeEntry, kind: &NodeKind, fields: &[Field]) -> Named {
        let mut draft = NodeDraft {
            name: entry.name.clone(),
            kind: kind.clone(),
            kind_location: entry.kind.location.clone(),
            scope,
            values: kind.params().iter().map(|param| param.default.clone()).collect(),
            written: vec![None; kind.params().len()],
            asked: vec![None; kind.inputs().len()],
            wires: vec![None; kind.inputs().len()],
            when: None,
            off: false,
            format: None,
            label: None,
            states: vec![None; kind.outputs().len()],
            is_partial: entry.fields.is_partial || fields.iter().any(|(_, item)| item.value.is_broken()),
        };
        for (name, item) in fields {
            self.field(&mut draft, name, item);
        }
        if !entry.fields.is_partial {
            self.report_missing_ports(&draft, fields);
        }
        self.drafts.push(draft);
        Named::Node(self.drafts.len() - 1)
    }

    fn field(&mut self, draft: &mut NodeDraft, name: &Spanned<String>, item: &Item) {
        let kind = draft.kind.clone();
        if let Some(port) = kind.inputs().iter().position(|port| port.name == name.value) {
            draft.asked[port] = self.wire(&name.value, item);
        } else if !self.change_field(draft, &name.value, item) {
            if let Some(param) = kind.former_param(&name.value) {
                return self.report(renamed(name, &param.name));
            }
            let ports = kind.inputs().iter().map(|port| &*port.name);
            let params = kind.params().iter().map(|param| &*param.name);
            let known: Vec<&str> = ports.clone().chain(params.clone()).chain(COMMON).collect();
            let message = format!("{} has no port or parameter {}", quote(kind.name()), quote(&name.value));
            let help = [("ports", ports.collect::<Vec<_>>()), ("parameters", params.collect())]
                .into_iter()
                .filter(|(_, names)| !names.is_empty())
                .map(|(what, names)| format!("its {what} are {}", list(names, 16)))
                .collect::<Vec<_>>()
                .join("; ");
            let diagnostic = Diagnostic::error("unknown-field", message).at(&name.location, "");
            self.report(diagnostic.help(help).maybe_help(did_you_mean(&name.value, known)));
        }
    }

    /// Sets a parameter or one of what every node takes; false if the node has no such field.
    pub(super) fn change_field(&mut self, draft: &mut NodeDraft, name: &str, item: &Item) -> bool {
        let kind = draft.kind.clone();
        if let Some((index, param)) = kind.param(name) {
            if let Some(value) = self.value(&kind, param, item) {
                draft.values[index] = value;
                draft.written[index] = Some(item.location.clone());
            }
            return true;
        }
        match name {
            "when" => draft.when = self.condition(draft.scope, item),
            "format" => draft.format = self.format(item),
            "label" => draft.label = self.label(item),
            _ => return false,
        }
        true
    }

    /// The text of a wire.
    fn wire(&mut self, port: &str, item: &Item) -> Option<Spanned<String>> {
        if let Tree::Text(text) = &item.value {
            return Some(Spanned::new(text.clone(), item.location.clone()));
        }
        if item.value.is_broken() {
            return None;
        }
        let message = format!("the port {} takes the name of a node or an input in quotes", quote(port));
        let diagnostic =
            Diagnostic::error("wrong-type", message).at(&item.location, format!("this is {}", item.value.describe()));
        self.report(match &item.value {
            Tree::Name(name) => diagnostic.help(format!("write `{port}: \"{name}\"`")),
            _ => diagnostic.help(format!("write `{port}: \"name\"`")),
        });
        None
    }

    fn report_missing_ports(&mut self, draft: &NodeDraft, fields: &[Field]) {
        let ports = || draft.kind.inputs().iter().map(|port| &*port.name);
        // A misspelt port has been reported with the right name as a hint.
        let is_meant = |name: &str, port: &str| {
            name == port || (draft.kind.param(name).is_none() && nearest(name, ports()) == Some(port))
        };
        for port in draft.kind.inputs() {
            if !port.optional && !fields.iter().any(|(name, _)| is_meant(&name.value, &port.name)) {
                let message = format!("{} has no {}", quote(&draft.name.value), quote(&port.name));
                let location = &draft.kind_location;
                let needs = format!("{} needs it", quote(draft.kind.name()));
                let what = port.doc.trim().trim_end_matches('.');
                let help = format!("add `{}: \"...\"`, the name of a node or an input: {what}", port.name);
                self.report(Diagnostic::error("missing-port", message).at(location, needs).help(help));
            }
        }
    }

    /// A pipeline used as a node.
    fn inner(&mut self, scope: usize, entry: &NodeEntry, fields: Vec<Field>, files: &mut Vec<String>) -> Option<Named> {
        let mut around =
            Around { parent: Some(scope), name: entry.name.clone(), ports: Group::default(), when: None, label: None };
        around.ports.is_partial = entry.fields.is_partial;
        let mut named = None;
        let mut changes = Vec::new();
        for (name, item) in fields {
            match name.value.as_str() {
                "file" => named = Some(item),
                "set" => changes = self.inner_settings(item),
                "when" => around.when = self.condition(scope, &item),
                "label" => around.label = self.label(&item),
                "format" => self.report(
                    Diagnostic::error("unknown-field", "a pipeline has no format of its own")
                        .at(&name.location, "")
                        .help("name a node inside: `set: { \"node.format\": ... }`"),
                ),
                _ => around.ports.entries.push((name, item)),
            }
        }
        let document = self.inner_document(entry, named, files)?;
        files.push(document.file.to_string());
        let inner = self.expand(&document, around, files);
        files.pop();
        self.changes.push(Change { scope: inner, settings: changes, is_made: true });
        Some(Named::Scope(inner))
    }

    fn inner_settings(&mut self, item: Item) -> Vec<crate::document::Override> {
        match settings(item, "`set`") {
            Ok((settings, problems)) => {
                problems.into_iter().for_each(|problem| self.report(problem));
                settings
            }
            Err(problem) => {
                self.report(problem);
                Vec::new()
            }
        }
    }

    fn inner_document(&mut self, entry: &NodeEntry, named: Option<Item>, files: &[String]) -> Option<Document> {
        let location = &entry.kind.location;
        let help = "write it as `Pipeline(file: \"bloom.ron\", source: \"scene\")`";
        let named = match named {
            Some(Item { value: Tree::Text(file), location }) => Spanned::new(file, location),
            Some(Item { value: Tree::Broken, .. }) => return None,
            Some(item) => {
                let seen = format!("this is {}", item.value.describe());
                self.report(
                    Diagnostic::error("wrong-type", "`file` is a path in quotes").at(&item.location, seen).help(help),
                );
                return None;
            }
            None if entry.fields.is_partial => return None,
            None => {
                let message = format!("{} does not say which pipeline it is", quote(&entry.name.value));
                self.report(Diagnostic::error("missing-file", message).at(location, "`file` is missing").help(help));
                return None;
            }
        };
        let path = join(&named.location.file, &named.value);
        if files.contains(&path) || files.len() > DEEPEST {
            self.report(holds_itself(&named, &path, files));
            return None;
        }
        let document = self.document(&named)?;
        Some(self.inherited(&document))
    }
}

fn holds_itself(named: &Spanned<String>, path: &str, files: &[String]) -> Diagnostic {
    let message = match files.iter().position(|file| file == path) {
        Some(from) => {
            let names: Vec<&str> = files[from..].iter().map(String::as_str).chain([path]).collect();
            format!("a pipeline holds itself: {}", names.join(" -> "))
        }
        None => format!("pipelines are nested more than {DEEPEST} deep"),
    };
    Diagnostic::error("pipeline-cycle", message).at(&named.location, "").help("a pipeline cannot be a node of itself")
}
