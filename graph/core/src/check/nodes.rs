//! Nodes of known kinds: from the entry in a file to the node of the graph.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use super::build::GraphBuilder;
use super::draft::{DraftGraph, Named, NodeDraft};
use super::suggest::{kinds_about, known_kinds};
use super::{Condition, GraphNode};
use crate::document::{Field, Item, NodeEntry, Tree, doubled};
use crate::node::{NodeInstance, NodeKind};
use afterimage_base::diagnostic::{Diagnostic, Location, Spanned, list, nearest, quote};
use afterimage_base::value::{ChoiceName, FileValue, Param, Type, Value};

/// The kind name of a pipeline used as a node.
pub(super) const PIPELINE: &str = "Pipeline";
/// Fields that every node has, besides its ports and parameters.
pub(super) const COMMON: [&str; 5] = ["when", "format", "bake", "every", "label"];

impl GraphBuilder<'_> {
    /// A node of a kind.
    pub(super) fn node(&mut self, scope: usize, entry: &NodeEntry) -> Named {
        let fields = self.unique(&entry.fields.entries);
        let Some(kind) = self.registry.get(&entry.kind.value) else {
            let name = &entry.kind.value;
            let topic = if self.reports.are_many() { None } else { kinds_about(self.registry, name) };
            let message = format!("no node kind is called {}", quote(name));
            let diagnostic = Diagnostic::error("unknown-kind", message).at(&entry.kind.location, "");
            let diagnostic = diagnostic.help(topic.unwrap_or_else(|| known_kinds(self.registry)));
            self.report(self.reports.with_nearest(diagnostic, name, self.registry.names().chain([PIPELINE])));
            return Named::Broken;
        };
        let mut draft = draft(scope, entry, kind);
        draft.is_partial |= fields.iter().any(|(_, item)| item.value.is_broken());
        for (name, item) in &fields {
            let port = meant_port(kind, &fields, name, item);
            self.field(&mut draft, name, item, port);
        }
        if !entry.fields.is_partial {
            self.report_missing_ports(&draft, &fields);
        }
        self.drafted.nodes.push(draft);
        Named::Node(self.drafted.nodes.len() - 1)
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

    /// `meant` is the port that an unknown name may stand for.
    fn field(&mut self, draft: &mut NodeDraft, name: &Spanned<String>, item: &Item, meant: Option<&str>) {
        let kind = draft.kind.clone();
        if let Some(port) = kind.inputs().iter().position(|port| port.name == name.value) {
            draft.wire_texts[port] = self.wire(&name.value, item);
        } else if !self.change_field(draft, &name.value, item) {
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
            let diagnostic = Diagnostic::error("unknown-field", message).at(&name.location, "").help(help);
            let diagnostic = match meant {
                Some(port) if !self.reports.are_many() => {
                    diagnostic.help(format!("did you mean {}?", quote(port))).correct(&name.value, port)
                }
                _ => diagnostic,
            };
            self.report(self.reports.with_nearest(diagnostic, &name.value, known));
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
        self.report(match &item.value {
            Tree::Name(name) => diagnostic.help(format!("write `{port}: \"{name}\"`")).rewrite(format!("\"{name}\"")),
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
        for (port, text) in draft.kind.inputs().iter().zip(&draft.wire_texts) {
            let stands_for = |(name, item): &Field| meant_port(&draft.kind, fields, name, item) == Some(&*port.name);
            let is_wired =
                text.is_some() || fields.iter().any(|field| is_meant(&field.0.value, &port.name) || stands_for(field));
            if !port.optional && !is_wired {
                let message = format!("{} has no {}", quote(&draft.name.value), quote(&port.name));
                let location = &draft.kind_location;
                let needs = format!("{} needs it", quote(draft.kind.name()));
                let what = port.doc.trim().trim_end_matches('.');
                let help = format!("add `{}: \"...\"`, the name of a node or an input: {what}", port.name);
                self.report(Diagnostic::error("missing-port", message).at(location, needs).help(help));
            }
        }
    }

    /// The value of a parameter; an error is reported otherwise.
    fn value(&mut self, kind: &NodeKind, param: &Param, item: &Item) -> Option<Value> {
        if item.value.is_broken() {
            return None;
        }
        let value = match self.typed(kind, param, item) {
            Ok(value) => value,
            Err(diagnostic) => {
                self.report(diagnostic);
                return None;
            }
        };
        if let Err(why) = param.accepts(&value) {
            let diagnostic = Diagnostic::error("out-of-domain", why).at(&item.location, "");
            self.report(diagnostic.help(about(param)));
            return None;
        }
        Some(value)
    }

    fn typed(&mut self, kind: &NodeKind, param: &Param, item: &Item) -> Result<Value, Diagnostic> {
        Ok(match (param.ty, &item.value) {
            (Type::Bool, Tree::Bool(flag)) => Value::Bool(*flag),
            (Type::Int, Tree::Int(whole)) => Value::Int(*whole),
            (Type::Float, Tree::Int(_) | Tree::Float(_)) => Value::Float(item.value.number().unwrap_or_default()),
            (Type::Vector(n), Tree::Tuple(None, items)) => vector(kind, param, n, items, &item.location)?,
            (Type::Choice(choices), Tree::Name(name)) => match choices.iter().find(|choice| choice.name == name) {
                Some(choice) => Value::Choice(choice.name),
                None => return Err(unknown_choice(param, choices, name, &item.location)),
            },
            (Type::Text, Tree::Text(text)) => Value::Text(text.as_str().into()),
            (Type::File, Tree::Text(path)) => self.file(&Spanned::new(path.clone(), item.location.clone()))?,
            _ => return Err(wrong_type(kind, param, item)),
        })
    }

    fn file(&mut self, named: &Spanned<String>) -> Result<Value, Diagnostic> {
        let path = named.value.clone();
        if path.is_empty() {
            return Ok(Value::File(FileValue::default()));
        }
        let bytes = self.used.bytes(named)?;
        Ok(Value::File(FileValue { path: path.into(), bytes: Some(bytes.into()) }))
    }

    /// Each node at its values. Reports those whose kind refuses them: a file that is not readable, two parameters that
    /// do not fit each other.
    pub(super) fn instances(&mut self) -> Vec<NodeInstance> {
        let instance = |draft: &NodeDraft| NodeInstance::new(draft.kind.clone(), draft.values.clone());
        let instances: Vec<NodeInstance> = self.drafted.nodes.iter().map(instance).collect();
        let complete = self.drafted.nodes.iter().zip(&instances).filter(|(draft, _)| !draft.is_partial);
        let refused: Vec<Diagnostic> =
            complete.filter_map(|(draft, instance)| Some(refused(draft, &doubt(draft, instance)?))).collect();
        refused.into_iter().for_each(|diagnostic| self.report(diagnostic));
        instances
    }
}

impl DraftGraph {
    pub(super) fn graph_node(&self, draft: &NodeDraft, instance: NodeInstance) -> GraphNode {
        let outer = self.scopes_around(draft.scope).filter_map(|scope| scope.when.clone());
        GraphNode {
            name: self.full_name(draft),
            instance,
            wires: draft.wires.iter().map(|wire| wire.as_ref().and_then(|wire| wire.source)).collect(),
            when: draft.when.clone().into_iter().chain(outer).reduce(Condition::and),
            off: draft.off || self.scopes_around(draft.scope).any(|scope| scope.off),
            format: draft.format,
            bake: draft.bake,
            every: draft.every,
            label: self.full_label(draft),
            states: draft.states.iter().map(|state| state.flatten()).collect(),
        }
    }
}

/// The node before any of its fields is read.
fn draft(scope: usize, entry: &NodeEntry, kind: &NodeKind) -> NodeDraft {
    NodeDraft {
        name: entry.name.clone(),
        kind: kind.clone(),
        kind_location: entry.kind.location.clone(),
        scope,
        values: kind.params().iter().map(|param| param.default.clone()).collect(),
        written: vec![None; kind.params().len()],
        wire_texts: vec![None; kind.inputs().len()],
        wires: vec![None; kind.inputs().len()],
        when: None,
        off: false,
        switched: None,
        format: None,
        bake: None,
        every: 1,
        label: None,
        states: vec![None; kind.outputs().len()],
        is_partial: entry.fields.is_partial,
    }
}

/// Reports why the kind refuses the values of the node or the format of its results.
fn doubt(draft: &NodeDraft, instance: &NodeInstance) -> Option<String> {
    let format = || draft.format.map_or(Ok(()), |format| instance.verify_format(format));
    instance.verify().and_then(|()| format()).err()
}

/// The kind of a node refuses its values.
fn refused(draft: &NodeDraft, why: &str) -> Diagnostic {
    let message = format!("{} cannot use its parameters: {why}", quote(&draft.name.value));
    let files = draft.kind.params().iter().zip(&draft.written).filter(|(param, _)| param.ty == Type::File);
    let file = files.filter_map(|(_, written)| written.as_ref()).next();
    Diagnostic::error("unusable", message).at(file.unwrap_or(&draft.kind_location), "")
}

fn vector(kind: &NodeKind, param: &Param, n: usize, items: &[Item], location: &Location) -> Result<Value, Diagnostic> {
    if items.len() != n {
        let message =
            format!("{} of {} takes {n} numbers, not {}", quote(&param.name), quote(kind.name()), items.len());
        return Err(Diagnostic::error("wrong-type", message).at(location, "").help(about(param)));
    }
    let mut numbers = [0.0; 4];
    for (slot, item) in numbers.iter_mut().zip(items) {
        *slot = item.value.number().ok_or_else(|| {
            let message = format!("{} of {} takes {n} numbers", quote(&param.name), quote(kind.name()));
            let seen = format!("this is {}", item.value.describe());
            Diagnostic::error("wrong-type", message).at(&item.location, seen).help(about(param))
        })?;
    }
    Ok(Value::Vector(numbers, n))
}

fn unknown_choice(param: &Param, choices: &[ChoiceName], name: &str, location: &Location) -> Diagnostic {
    let names = || choices.iter().map(|choice| choice.name);
    Diagnostic::error("unknown-choice", format!("{} has no value {}", quote(&param.name), quote(name)))
        .at(location, "")
        .help(format!("its values are {}", list(names(), 16)))
        .did_you_mean(name, names())
}

fn wrong_type(kind: &NodeKind, param: &Param, item: &Item) -> Diagnostic {
    let message = format!("{} of {} is {}", quote(&param.name), quote(kind.name()), param.ty.describe());
    let diagnostic =
        Diagnostic::error("wrong-type", message).at(&item.location, format!("this is {}", item.value.describe()));
    match (param.ty, &item.value) {
        (Type::Choice(choices), Tree::Text(name)) if choices.iter().any(|choice| choice.name == name) => {
            diagnostic.help(format!("write {} without quotes", quote(name))).rewrite(name)
        }
        (Type::Bool, Tree::Name(name)) if name.eq_ignore_ascii_case("true") || name.eq_ignore_ascii_case("false") => {
            diagnostic.help(format!("write {}", quote(&name.to_lowercase()))).rewrite(name.to_lowercase())
        }
        (Type::Int, Tree::Float(x)) if x.fract() == 0.0 && x.abs() < 1e15 => {
            diagnostic.help(format!("write `{x:.0}`")).rewrite(format!("{x:.0}"))
        }
        (Type::Int, Tree::Float(x)) if x.fract() == 0.0 => diagnostic.help("the number is too large"),
        (Type::Vector(n), Tree::List(items)) if items.len() == n => diagnostic.help("write parentheses, not brackets"),
        (Type::Int | Type::Float, Tree::Text(text)) if with_point(text).is_some() => {
            let number = with_point(text).unwrap_or_default();
            diagnostic.help(format!("write {} without quotes", quote(&number))).rewrite(number)
        }
        (Type::Choice(choices), Tree::Text(name)) => {
            let names = choices.iter().map(|choice| choice.name);
            diagnostic.help("its values are names without quotes").did_you_mean(name, names)
        }
        (Type::File | Type::Text, Tree::Name(name)) => {
            diagnostic.help(format!("write it in quotes: `{}: \"{name}...\"`", param.name))
        }
        (_, Tree::Text(_)) => diagnostic.help("only ports take the name of a node; a parameter takes a value"),
        _ => diagnostic.help(about(param)),
    }
}

/// The number that a text holds, with a point: `0.15` for `0,15`.
pub(super) fn with_point(text: &str) -> Option<String> {
    let number = text.trim().replacen(',', ".", 1);
    number.parse::<f64>().is_ok_and(f64::is_finite).then_some(number)
}

/// The first sentence of the parameter's manual, and its default.
fn about(param: &Param) -> String {
    let doc = param.doc.replace('\n', " ");
    let sentence = doc.split_inclusive(". ").next().unwrap_or_default().trim().trim_end_matches('.').to_owned();
    format!("{}: {sentence} (default {})", quote(&param.name), param.default)
}

/// The only port that a node needs and that no field names, for a field with an unknown name and the text of a wire.
fn meant_port<'k>(kind: &'k NodeKind, fields: &[Field], name: &Spanned<String>, item: &Item) -> Option<&'k str> {
    let is_known = |name: &str| {
        let is_port = kind.inputs().iter().any(|port| *port.name == *name);
        is_port || kind.param(name).is_some() || COMMON.contains(&name)
    };
    let is_left_out = |port: &str| !fields.iter().any(|(field, _)| field.value == port);
    let mut missing = kind.inputs().iter().filter(|port| !port.optional && is_left_out(&port.name));
    let (only, further) = (missing.next()?, missing.next());
    let is_wire = matches!(item.value, Tree::Text(_)) && !is_known(&name.value);
    (is_wire && further.is_none()).then_some(&*only.name)
}
