//! Nodes of known kinds: from the entry in a file to the node of the graph.

use super::draft::{DraftGraph, Named, NodeDraft};
use super::expand::{Expansion, PIPELINE};
use super::fields::NODE_FIELDS;
use super::reports::Reports;
use super::suggest::{kinds_about, known_kinds};
use super::{Condition, GraphNode};
use crate::document::{Field, Item, NodeEntry, Tree};
use crate::node::{NodeInstance, NodeKind};
use afterimage_base::diagnostic::{Diagnostic, Spanned, list, nearest, quote};
use afterimage_base::value::Type;

impl Expansion<'_> {
    /// A node of a kind.
    pub(super) fn node(&mut self, scope: usize, entry: &NodeEntry) -> Named {
        let fields = self.fields.unique(&entry.fields.entries);
        let Some(kind) = self.registry.get(&entry.kind.value) else {
            let name = &entry.kind.value;
            let topic = if self.fields.reports.are_many() { None } else { kinds_about(self.registry, name) };
            let message = format!("no node kind is called {}", quote(name));
            let diagnostic = Diagnostic::error("unknown-kind", message).at(&entry.kind.location, "");
            let diagnostic = diagnostic.help(topic.unwrap_or_else(|| known_kinds(self.registry)));
            self.fields.reports.push(self.fields.reports.with_nearest(
                diagnostic,
                name,
                self.registry.names().chain([PIPELINE]),
            ));
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

    /// `meant` is the port that an unknown name may stand for.
    fn field(&mut self, draft: &mut NodeDraft, name: &Spanned<String>, item: &Item, meant: Option<&str>) {
        let kind = draft.kind.clone();
        if let Some(port) = kind.inputs().iter().position(|port| port.name == name.value) {
            draft.wire_texts[port] = self.fields.wire(&name.value, item);
        } else if !self.fields.change_field(draft, self.drafted.facts(draft.scope), &name.value, item) {
            let ports = kind.inputs().iter().map(|port| &*port.name);
            let params = kind.params().iter().map(|param| &*param.name);
            let known: Vec<&str> = ports.clone().chain(params.clone()).chain(NODE_FIELDS).collect();
            let message = format!("{} has no port or parameter {}", quote(kind.name()), quote(&name.value));
            let help = [("ports", ports.collect::<Vec<_>>()), ("parameters", params.collect())]
                .into_iter()
                .filter(|(_, names)| !names.is_empty())
                .map(|(what, names)| format!("its {what} are {}", list(names, 16)))
                .collect::<Vec<_>>()
                .join("; ");
            let diagnostic = Diagnostic::error("unknown-field", message).at(&name.location, "").help(help);
            let diagnostic = match meant {
                Some(port) if !self.fields.reports.are_many() => {
                    diagnostic.help(format!("did you mean {}?", quote(port))).correct(&name.value, port)
                }
                _ => diagnostic,
            };
            self.fields.reports.push(self.fields.reports.with_nearest(diagnostic, &name.value, known));
        }
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
                self.fields.reports.push(Diagnostic::error("missing-port", message).at(location, needs).help(help));
            }
        }
    }
}

impl DraftGraph {
    /// Each node at its values. Reports those whose kind refuses them: a file that is not readable, two parameters that
    /// do not fit each other.
    pub(super) fn instances(&self, reports: &mut Reports) -> Vec<NodeInstance> {
        let instance = |draft: &NodeDraft| NodeInstance::new(draft.kind.clone(), draft.values.clone());
        let instances: Vec<NodeInstance> = self.nodes.iter().map(instance).collect();
        let complete = self.nodes.iter().zip(&instances).filter(|(draft, _)| !draft.is_partial);
        let refused = complete.filter_map(|(draft, instance)| Some(refused(draft, &doubt(draft, instance)?)));
        refused.for_each(|diagnostic| reports.push(diagnostic));
        instances
    }

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

/// The only port that a node needs and that no field names, for a field with an unknown name and the text of a wire.
fn meant_port<'k>(kind: &'k NodeKind, fields: &[Field], name: &Spanned<String>, item: &Item) -> Option<&'k str> {
    let is_known = |name: &str| {
        let is_port = kind.inputs().iter().any(|port| *port.name == *name);
        is_port || kind.param(name).is_some() || NODE_FIELDS.contains(&name)
    };
    let is_left_out = |port: &str| !fields.iter().any(|(field, _)| field.value == port);
    let mut missing = kind.inputs().iter().filter(|port| !port.optional && is_left_out(&port.name));
    let (only, further) = (missing.next()?, missing.next());
    let is_wire = matches!(item.value, Tree::Text(_)) && !is_known(&name.value);
    (is_wire && further.is_none()).then_some(&*only.name)
}
