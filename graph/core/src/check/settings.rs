//! Changes to nodes: `set` sections, tiers and `--set`.

use std::sync::Arc;

use super::draft::{DraftGraph, Named, Scope};
use super::expand::{Change, Expansion};
use super::fields::{FieldReader, NODE_FIELDS};
use super::files::COMMAND_LINE;
use super::parameters::with_point;
use crate::document::{Item, Override, Tree, read_tree};
use afterimage_base::diagnostic::{Diagnostic, Location, Spanned, list, quote};

enum Target {
    Node(usize),
    Scope(usize),
}

impl Expansion<'_> {
    /// Takes the changes of the command line as if they stood in a file, one a line.
    pub(super) fn command_line(&mut self, sets: &[(String, String)]) {
        if sets.is_empty() {
            return;
        }
        let lines: Vec<String> = sets.iter().map(|(key, value)| format!("{key}={value}")).collect();
        let text = lines.join("\n");
        let file = self.fields.reports.diagnostics.sources.insert(COMMAND_LINE, &text);
        let mut start = 0;
        let mut settings = Vec::new();
        for (key, value) in sets {
            let value_start = start + key.len() + 1;
            let location = Location::new(&file, value_start..value_start + value.len());
            let key_location = Location::new(&file, start..start + key.len());
            start = value_start + value.len() + 1;
            match command_line_value(&file, value, &location) {
                Ok(item) => settings.push(Override { key: Spanned::new(key.clone(), key_location), value: item }),
                Err(diagnostic) => self.fields.reports.push(diagnostic),
            }
        }
        self.changes.push(Change { scope: 0, settings, tier: None });
    }

    /// Applies all overrides: those of inner pipelines first, then those of outer ones, the command line's last.
    pub(super) fn change(&mut self) {
        for change in std::mem::take(&mut self.changes) {
            let is_made = self.is_made(&change);
            let (drafted, fields) = (&mut self.drafted, &mut self.fields);
            let mut overrides = Overrides { drafted, fields, scope: change.scope, is_made };
            change.settings.iter().for_each(|setting| overrides.setting(setting));
        }
    }

    /// Returns whether changes are applied, not only checked.
    pub(super) fn is_made(&self, change: &Change) -> bool {
        change.tier.is_none() || change.tier == self.tier
    }
}

struct Overrides<'b, 'a> {
    drafted: &'b mut DraftGraph,
    fields: &'b mut FieldReader<'a>,
    scope: usize,
    /// True if they are applied, not only checked.
    is_made: bool,
}

impl Overrides<'_, '_> {
    fn setting(&mut self, setting: &Override) {
        let key = &setting.key;
        let (path, field) = match key.value.split_once('.') {
            Some((path, field)) => (path, Some(field)),
            None => (key.value.as_str(), None),
        };
        let Some(found) = self.find(path, key) else { return };
        match (found, field) {
            (Target::Node(node), None) => {
                if let Some(off) = self.switch(setting).filter(|_| self.is_made) {
                    self.drafted.nodes[node].off = off;
                    self.drafted.nodes[node].switched = Some(setting.value.location.clone());
                }
            }
            (Target::Scope(inner), None) => {
                if let Some(off) = self.switch(setting).filter(|_| self.is_made) {
                    self.drafted.scopes[inner].off = off;
                    self.drafted.scopes[inner].switched = Some(setting.value.location.clone());
                }
            }
            (Target::Node(node), Some(field)) => {
                let port = self.drafted.nodes[node].kind.inputs().iter().position(|port| port.name == field);
                match port {
                    Some(port) => self.wire_setting(node, port, setting),
                    None => self.node_setting(node, field, setting),
                }
            }
            (Target::Scope(inner), Some(field)) => self.scope_setting(inner, field, setting),
        }
    }

    /// The node or inner pipeline that a path such as `outer/inner` names.
    fn find(&mut self, path: &str, key: &Spanned<String>) -> Option<Target> {
        let mut scope = self.scope;
        let mut parts = path.split('/').peekable();
        while let Some(part) = parts.next() {
            let is_last = parts.peek().is_none();
            match self.drafted.scopes[scope].names.get(part) {
                Some(Named::Node(node)) if is_last => return Some(Target::Node(*node)),
                Some(Named::Scope(inner)) if is_last => return Some(Target::Scope(*inner)),
                Some(Named::Scope(inner)) => scope = *inner,
                Some(Named::Broken) => return None,
                _ => {
                    if !self.drafted.scopes[scope].is_partial {
                        let has_hint = !self.fields.reports.are_many();
                        let error = no_such_node(&self.drafted.scopes[scope], part, key, has_hint);
                        let is_alone = has_hint && error.correction.is_none() && key.value == part;
                        let owner = is_alone.then(|| self.drafted.owner(scope, part)).flatten();
                        self.fields.reports.push(error.maybe_help(owner.map(|owner| {
                            format!("a parameter is set by `node.parameter`: {}", quote(&format!("{owner}.{part}")))
                        })));
                    }
                    return None;
                }
            }
        }
        None
    }

    /// The value of `"node": Off`.
    fn switch(&mut self, setting: &Override) -> Option<bool> {
        match &setting.value.value {
            Tree::Name(name) if name == "Off" => Some(true),
            Tree::Name(name) if name == "On" => Some(false),
            Tree::Broken => None,
            other => {
                let name = &setting.key.value;
                let diagnostic =
                    Diagnostic::error("wrong-type", format!("{} can be set to `On` or `Off`", quote(name)))
                        .at(&setting.value.location, format!("this is {}", other.describe()))
                        .help(format!("a parameter of it is set by `\"{name}.parameter\": value`"));
                self.fields.reports.push(match other {
                    Tree::Name(word) => diagnostic.did_you_mean(word, ["Off", "On"]),
                    _ => diagnostic,
                });
                None
            }
        }
    }

    fn node_setting(&mut self, node: usize, field: &str, setting: &Override) {
        let mut draft = self.drafted.nodes[node].clone();
        let facts = self.drafted.facts(draft.scope);
        if self.fields.change_field(&mut draft, facts, field, &setting.value) {
            if self.is_made {
                self.drafted.nodes[node] = draft;
            }
            return;
        }
        let kind = draft.kind.clone();
        let known = || kind.params().iter().map(|param| &*param.name).chain(NODE_FIELDS);
        let name = quote(&draft.name.value);
        let diagnostic = Diagnostic::error("unknown-field", format!("{name} has no parameter {}", quote(field)))
            .at(&setting.key.location, "")
            .help(format!("{} has {}", quote(kind.name()), list(known(), 16)));
        self.fields.reports.push(self.fields.reports.with_nearest(diagnostic, field, known()));
    }

    /// Wires a port to something else. The old source is still needed: without this change, or in another tier.
    fn wire_setting(&mut self, node: usize, port: usize, setting: &Override) {
        let draft = &self.drafted.nodes[node];
        let name = draft.kind.inputs()[port].name.clone();
        if draft.scope != self.scope {
            let message = format!("{} is a port inside a pipeline, whose wires cannot be set", quote(&name));
            let help = "wire the inputs of that pipeline, or write the node anew in a file that `extends` it";
            let diagnostic = Diagnostic::error("unknown-field", message).at(&setting.key.location, "");
            return self.fields.reports.push(diagnostic.help(help));
        }
        let Some(text) = self.fields.wire(&name, &setting.value) else { return };
        let unused = if self.is_made { self.drafted.nodes[node].wire_texts[port].replace(text) } else { Some(text) };
        self.drafted.wires_elsewhere.extend(unused.map(|text| (self.scope, text)));
    }

    fn scope_setting(&mut self, inner: usize, field: &str, setting: &Override) {
        match field {
            "when" => {
                let parent = self.drafted.scopes[inner].parent.unwrap_or(0);
                let when = self.fields.condition(self.drafted.facts(parent), &setting.value);
                self.drafted.scopes[inner].when =
                    if self.is_made { when } else { self.drafted.scopes[inner].when.take() };
            }
            "label" => {
                let label = self.fields.label(&setting.value);
                self.drafted.scopes[inner].label =
                    if self.is_made { label } else { self.drafted.scopes[inner].label.take() };
            }
            _ => {
                let name = &self.drafted.scopes[inner].name.value;
                let message = format!("{} is a pipeline and has no parameter {}", quote(name), quote(field));
                let nodes: Vec<String> =
                    node_names(&self.drafted.scopes[inner]).map(|node| format!("{name}/{node}")).collect();
                let help = format!("name a node inside it: {}", list(nodes.iter().map(String::as_str), 6));
                self.fields
                    .reports
                    .push(Diagnostic::error("unknown-field", message).at(&setting.key.location, "").help(help));
            }
        }
    }
}

impl DraftGraph {
    /// The name of a node that has such a parameter.
    fn owner(&self, scope: usize, param: &str) -> Option<&str> {
        let owner = self.nodes.iter().find(|draft| draft.scope == scope && draft.kind.param(param).is_some())?;
        Some(&owner.name.value)
    }
}

fn node_names(scope: &Scope) -> impl Iterator<Item = &str> + '_ {
    scope.names.iter().filter(|(_, named)| !matches!(named, Named::Input(_))).map(|(name, _)| name.as_str())
}

fn no_such_node(scope: &Scope, part: &str, key: &Spanned<String>, has_hint: bool) -> Diagnostic {
    let message = match scope.names.get(part) {
        Some(Named::Input(_)) => format!("{} is an input, not a node", quote(part)),
        Some(_) => {
            let message = format!("{} is a node, not a pipeline: nothing is inside it", quote(part));
            let help = format!("a parameter of it is `{part}.parameter`");
            return Diagnostic::error("unknown-node", message).at(&key.location, "").help(help);
        }
        None if part.is_empty() => "the name of the node is missing".into(),
        None => format!("no node is called {}", quote(part)),
    };
    let diagnostic = Diagnostic::error("unknown-node", message).at(&key.location, "");
    if !has_hint {
        return diagnostic;
    }
    let help = match node_names(scope).next() {
        None => "there are no nodes".into(),
        Some(_) => format!("the nodes are {}", list(node_names(scope), 12)),
    };
    diagnostic.help(help).did_you_mean(part, node_names(scope))
}

/// The value of a `--set`, with its location in the text that all of them make.
fn command_line_value(file: &Arc<str>, value: &str, location: &Location) -> Result<Item, Diagnostic> {
    const HELP: &str = "write it as a pipeline file would: `--set bloom.strength=0.5`, `--set tone.curve=AgX`, \
                        `--set lut.file='\"film.cube\"'`";
    let parsed = read_tree(file, value);
    let Some(error) = parsed.errors.first() else { return Ok(shift(parsed.tree, location.start)) };
    let at = location.start + error.labels.first().map_or(0, |label| label.location.start);
    let message = match value {
        "" => "the value is missing".to_owned(),
        value => format!("{} is not a value", quote(value)),
    };
    let location = if value.is_empty() { location.clone() } else { Location::new(file, at..location.end.max(at)) };
    let help = with_point(value).map(|number| format!("a decimal number has a point: {}", quote(&number)));
    Err(Diagnostic::error("set-syntax", message).at(&location, "").help(help.unwrap_or_else(|| HELP.to_owned())))
}

/// The same tree, its locations moved by `by` bytes.
fn shift(mut item: Item, by: usize) -> Item {
    item.location.start += by;
    item.location.end += by;
    item.value = match item.value {
        Tree::Tuple(name, items) => Tree::Tuple(name, items.into_iter().map(|item| shift(item, by)).collect()),
        Tree::List(items) => Tree::List(items.into_iter().map(|item| shift(item, by)).collect()),
        other => other,
    };
    item
}
