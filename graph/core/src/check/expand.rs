//! Documents with the pipelines that they use as nodes: names, inputs, outputs.

use std::collections::BTreeMap;

use super::Condition;
use super::draft::{DraftGraph, Feed, Named, Scope};
use super::fields::FieldReader;
use super::files::{Files, join};
use super::limits::{MAX_DEPTH, MAX_FACTS, MAX_INPUTS, MAX_OUTPUTS, MAX_TIERS};
use crate::document::{
    Document, Field, Group, InputEntry, Item, NodeEntry, Override, Tier, Tree, image_type_names, settings,
};
use crate::node::Registry;
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Spanned, is_control, list, quote};

/// The kind name of a pipeline used as a node.
pub(super) const PIPELINE: &str = "Pipeline";

/// Context of a pipeline that is being expanded.
struct Around {
    parent: Option<usize>,
    name: Spanned<String>,
    /// The fields of the node that a pipeline is used as, without those that are not ports.
    ports: Group<Field>,
    when: Option<Condition>,
    label: Option<String>,
}

/// A document that is being expanded: the nodes of all pipelines in it, and the changes that wait until they are known.
pub(super) struct Expansion<'a> {
    pub(super) registry: &'a Registry,
    pub(super) fields: FieldReader<'a>,
    pub(super) drafted: DraftGraph,
    pub(super) changes: Vec<Change>,
    /// The requested tier, if it is one of changes.
    pub(super) tier: Option<String>,
}

/// Changes to nodes, waiting until all nodes are known.
pub(super) struct Change {
    pub(super) scope: usize,
    pub(super) settings: Vec<Override>,
    /// The tier that they belong to, if they do; those of other tiers than the requested one are only checked.
    pub(super) tier: Option<String>,
}

impl<'a> Expansion<'a> {
    pub(super) fn new(registry: &'a Registry, files: &'a Files<'a>, diagnostics: Diagnostics) -> Self {
        let fields = FieldReader::new(files, diagnostics);
        Self { registry, fields, drafted: DraftGraph::default(), changes: Vec::new(), tier: None }
    }

    /// The whole document, and the changes that its tier makes.
    pub(super) fn expand_top(&mut self, document: &Document) {
        let name = Spanned::new(String::new(), document.location.clone());
        let around = Around { parent: None, name, ports: Group::default(), when: None, label: None };
        self.expand(document, around, &mut vec![join("", &document.file)]);
    }

    fn expand(&mut self, document: &Document, around: Around, files: &mut Vec<String>) -> usize {
        let Around { parent, name, ports, when, label } = around;
        self.report_long_sections(document);
        let facts = document.facts.as_ref().filter(|facts| facts.len() <= MAX_FACTS);
        let facts = facts.map(|facts| facts.iter().map(|(name, _)| name.value.clone()).collect());
        let scope = self.drafted.scopes.len();
        self.drafted.scopes.push(Scope {
            parent,
            name,
            inputs: Vec::new(),
            names: BTreeMap::new(),
            outputs: Vec::new(),
            when,
            off: false,
            switched: None,
            label,
            facts,
            is_partial: document.is_partial,
        });
        for name in &document.unread {
            self.drafted.scopes[scope].names.insert(name.clone(), Named::Broken);
        }
        self.inputs(scope, document, ports);
        for entry in &document.nodes {
            if !self.has_room(&entry.name.location) {
                self.drafted.scopes[scope].is_partial = true;
                break;
            }
            let is_good = self.good_name(scope, &entry.name, "node") && self.is_free(scope, &entry.name);
            let named = match entry.kind.value.as_str() {
                _ if !is_good => Named::Broken,
                PIPELINE => self.inner(scope, entry, files).unwrap_or(Named::Broken),
                _ => self.node(scope, entry),
            };
            self.drafted.scopes[scope].names.insert(entry.name.value.clone(), named);
        }
        let outputs = &document.outputs[..document.outputs.len().min(MAX_OUTPUTS)];
        for output in outputs {
            self.good_name(scope, &output.name, "output");
        }
        self.drafted.scopes[scope].outputs = outputs.to_vec();
        self.own_changes(scope, document);
        scope
    }

    fn own_changes(&mut self, scope: usize, document: &Document) {
        self.changes.push(Change { scope, settings: document.set.clone(), tier: None });
        for (name, tier) in document.tiers.iter().take(MAX_TIERS) {
            if let Tier::Settings(settings) = tier {
                self.changes.push(Change { scope, settings: settings.clone(), tier: Some(name.value.clone()) });
            }
        }
    }

    /// The inputs of a scope: the host's at the top, the ports of the node inside.
    fn inputs(&mut self, scope: usize, document: &Document, ports: Group<Field>) {
        let Group { entries, is_partial } = ports;
        let mut ports: indexmap::IndexMap<String, Field> =
            entries.into_iter().map(|field| (field.0.value.clone(), field)).collect();
        let is_top = self.drafted.scopes[scope].parent.is_none();
        for (index, input) in document.inputs.iter().take(MAX_INPUTS).enumerate() {
            if !self.good_name(scope, &input.name, "input") || !self.is_known_type(input) {
                self.drafted.scopes[scope].names.insert(input.name.value.clone(), Named::Broken);
                continue;
            }
            let feed = match ports.shift_remove(&input.name.value) {
                _ if is_top => Feed::Host(index),
                Some((name, item)) => self.fields.wire(&name.value, &item).map_or(Feed::Absent, Feed::Wire),
                None => {
                    self.report_missing_input(scope, input.optional || is_partial, &input.name);
                    Feed::Absent
                }
            };
            let at = self.drafted.scopes[scope].inputs.len();
            self.drafted.scopes[scope].inputs.push((input.clone(), feed));
            self.drafted.scopes[scope].names.insert(input.name.value.clone(), Named::Input(at));
        }
        // One of a file that is broken may be in what is lost.
        let is_lost = |name: &String| document.is_partial || document.unread.contains(name);
        for (name, _) in ports.values().filter(|(name, _)| !is_lost(&name.value)) {
            let known = || document.inputs.iter().map(|input| input.name.value.as_str());
            let help = format!("its inputs are {}", list(known(), 8));
            let message = format!("the pipeline {} has no input {}", quote(&document.file), quote(&name.value));
            let diagnostic = Diagnostic::error("unknown-field", message).at(&name.location, "").help(help);
            self.fields.reports.push(self.fields.reports.with_nearest(diagnostic, &name.value, known()));
        }
    }

    /// Returns whether an input is an image, or a block that some kind reads.
    fn is_known_type(&mut self, input: &InputEntry) -> bool {
        let Some(ty) = input.block.as_ref().filter(|ty| self.registry.block(&ty.value).is_none()) else { return true };
        let mut names: Vec<&str> = image_type_names().chain(self.registry.blocks().map(|block| block.name)).collect();
        names.dedup();
        let diagnostic =
            Diagnostic::error("unknown-input-type", format!("no input type is called {}", quote(&ty.value)))
                .at(&ty.location, "")
                .help(format!("the types are {}", list(names.iter().copied(), 24)))
                .did_you_mean(&ty.value, names);
        self.fields.reports.push(diagnostic);
        false
    }

    fn report_missing_input(&mut self, scope: usize, is_optional: bool, input: &Spanned<String>) {
        if !is_optional {
            let node = &self.drafted.scopes[scope].name;
            let message = format!("{} has no {}", quote(&node.value), quote(&input.value));
            let diagnostic = Diagnostic::error("missing-port", message)
                .at(&node.location, "")
                .also(&input.location, "the inner pipeline needs this input")
                .help(format!("add `{}: \"...\"`, or declare the input with `(optional: true)`", input.value));
            self.fields.reports.push(diagnostic);
        }
    }

    /// Names are free but for the signs that wires and settings are made of.
    fn good_name(&mut self, scope: usize, name: &Spanned<String>, what: &str) -> bool {
        let text = &name.value;
        let message = match text.chars().find(|c| ".@/".contains(*c) || is_control(*c)) {
            _ if text.is_empty() => format!("the name of this {what} is empty"),
            _ if text.trim() != text => format!("the name of this {what} begins or ends with a space"),
            Some(c) => format!("the name {} holds {}", quote(text), quote(&c.to_string())),
            None => return self.is_short(scope, name),
        };
        let diagnostic = Diagnostic::error("bad-name", message).at(&name.location, "");
        self.fields
            .reports
            .push(diagnostic.help("names are any text without `.`, `@` and `/`, which wires and settings use"));
        false
    }

    fn is_free(&mut self, scope: usize, name: &Spanned<String>) -> bool {
        let Some(Named::Input(index)) = self.drafted.scopes[scope].names.get(&name.value) else { return true };
        let first = self.drafted.scopes[scope].inputs[*index].0.name.location.clone();
        let message = format!("a node and an input are both called {}", quote(&name.value));
        let diagnostic = Diagnostic::error("doubled", message).at(&name.location, "the node").also(&first, "the input");
        self.fields.reports.push(diagnostic.help("a wire could mean either: give one of them another name"));
        false
    }

    /// A pipeline used as a node.
    fn inner(&mut self, scope: usize, entry: &NodeEntry, files: &mut Vec<String>) -> Option<Named> {
        let mut around =
            Around { parent: Some(scope), name: entry.name.clone(), ports: Group::default(), when: None, label: None };
        around.ports.is_partial = entry.fields.is_partial;
        let mut named = None;
        let mut changes = Vec::new();
        for (name, item) in self.fields.unique(&entry.fields.entries) {
            match name.value.as_str() {
                "file" => named = Some(item),
                "set" => changes = self.inner_settings(item),
                "when" => around.when = self.fields.condition(self.drafted.facts(scope), &item),
                "label" => around.label = self.fields.label(&item),
                field @ ("format" | "bake" | "every") => self.fields.reports.push(
                    Diagnostic::error("unknown-field", format!("a pipeline has no {field} of its own"))
                        .at(&name.location, "")
                        .help(format!("name a node inside: `set: {{ \"node.{field}\": ... }}`")),
                ),
                _ => around.ports.entries.push((name, item)),
            }
        }
        let document = self.inner_document(entry, named, files)?;
        files.push(document.file.to_string());
        let inner = self.expand(&document, around, files);
        files.pop();
        self.changes.push(Change { scope: inner, settings: changes, tier: None });
        Some(Named::Scope(inner))
    }

    fn inner_settings(&mut self, item: Item) -> Vec<Override> {
        match settings(item, "`set`") {
            Ok((settings, problems)) => {
                problems.into_iter().for_each(|problem| self.fields.reports.push(problem));
                settings
            }
            Err(problem) => {
                self.fields.reports.push(problem);
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
                self.fields.reports.push(
                    Diagnostic::error("wrong-type", "`file` is a path in quotes").at(&item.location, seen).help(help),
                );
                return None;
            }
            None if entry.fields.is_partial => return None,
            None => {
                let message = format!("{} does not say which pipeline it is", quote(&entry.name.value));
                self.fields
                    .reports
                    .push(Diagnostic::error("missing-file", message).at(location, "`file` is missing").help(help));
                return None;
            }
        };
        let path = join(&named.location.file, &named.value);
        if files.contains(&path) || files.len() > MAX_DEPTH {
            self.fields.reports.push(holds_itself(&named, &path, files));
            return None;
        }
        self.fields.document(&named)
    }
}

fn holds_itself(named: &Spanned<String>, path: &str, files: &[String]) -> Diagnostic {
    let message = match files.iter().position(|file| file == path) {
        Some(from) => {
            let names: Vec<&str> = files[from..].iter().map(String::as_str).chain([path]).collect();
            format!("a pipeline holds itself: {}", names.join(" -> "))
        }
        None => format!("pipelines are nested more than {MAX_DEPTH} deep"),
    };
    Diagnostic::error("pipeline-cycle", message).at(&named.location, "").help("a pipeline cannot be a node of itself")
}
