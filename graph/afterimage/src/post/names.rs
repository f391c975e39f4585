//! Names that the host uses and the graph does not know, each with the nearest one that it knows.

use afterimage_gpu::{Frame, HostDraw};
use afterimage_graph::check::{Fact, FactKind, Graph};
use afterimage_graph::diagnostic::{did_you_mean, list, quote};
use afterimage_graph::node::PortType;

use super::bindings::HostBindings;
use super::plans::Plans;
use super::readings::Readings;
use super::values::Values;

/// The warnings of a host's names. They are looked at when a plan is activated and when a fact or a watch is new.
#[derive(Default)]
pub(super) struct NameCheck {
    is_done: bool,
    pub(super) warnings: Vec<String>,
}

impl NameCheck {
    /// Checks names again in the next frame.
    pub(super) fn queue(&mut self) {
        self.is_done = false;
    }

    /// Looks for unknown names, if that is due, and logs those that are new.
    pub(super) fn update(
        &mut self,
        values: &Values,
        plans: &Plans,
        bindings: &HostBindings,
        readings: &Readings,
        frame: &Frame<'_>,
        draws: &[HostDraw<'_>],
    ) {
        if std::mem::replace(&mut self.is_done, true) {
            return;
        }
        let graph = values.graph();
        let mut warnings = Vec::new();
        let images: Vec<&str> = names_of_images(graph).collect();
        let blocks: Vec<&str> = names_of_blocks(graph).collect();
        let outputs: Vec<&str> = graph.outputs.iter().map(|output| output.name.as_str()).collect();
        let ports: Vec<&str> = images.iter().chain(&outputs).copied().collect();
        let finite = bindings.finite.iter().map(String::as_str);
        let given = frame.inputs.iter().map(|(name, _)| *name).chain(frame.factors.iter().map(|(name, _)| *name));
        for name in given.chain(finite) {
            warn(&mut warnings, graph, "the pipeline has no image input", name, &images);
        }
        for (name, _) in frame.blocks {
            warn(&mut warnings, graph, "the pipeline has no input for a block", name, &blocks);
        }
        for name in &bindings.linear {
            warn(&mut warnings, graph, "the pipeline has no output", name, &outputs);
        }
        for name in frame.described_ports() {
            warn(&mut warnings, graph, "the pipeline has no input or output", name, &ports);
        }
        let facts = graph.facts();
        let names: Vec<&str> = facts.iter().map(|(name, _)| name.as_str()).collect();
        for (name, fact) in plans.facts.iter() {
            warn(&mut warnings, graph, "no condition of the pipeline tests the fact", name, &names);
            let kinds: Vec<FactKind> = facts.iter().filter(|(known, _)| known == name).map(|(_, kind)| *kind).collect();
            if matches!(fact, Fact::Number(number) if number.is_nan()) {
                add(&mut warnings, format!("the fact {} is not a number", quote(name)));
            }
            if !kinds.is_empty() && !kinds.contains(&kind_of(fact)) {
                let (wanted, given) = (kinds[0].describe(), kind_of(fact).describe());
                add(&mut warnings, format!("the pipeline takes the fact {} as {wanted}, not as {given}", quote(name)));
            }
        }
        let buffers = names_of_buffers(graph);
        let buffers: Vec<&str> = buffers.iter().map(String::as_str).collect();
        let computed = plans.active.as_ref().map_or(&[][..], |active| &active.plan.buffers);
        for label in readings.labels().filter(|label| computed.iter().all(|buffer| buffer.label != *label)) {
            let of_node = buffers.iter().filter(|name| name.rsplit_once('.').is_some_and(|(node, _)| node == label));
            let of_node: Vec<&str> = of_node.copied().collect();
            match of_node.as_slice() {
                [] => warn(&mut warnings, graph, "the pipeline has no table or value", label, &buffers),
                own => {
                    add(&mut warnings, format!("{} is a node: watch {}", quote(label), list(own.iter().copied(), 8)))
                }
            }
        }
        let nodes: Vec<&str> = graph.nodes.iter().map(|node| node.name.as_str()).collect();
        for draw in draws {
            warn(&mut warnings, graph, "the pipeline has no node", draw.node, &nodes);
        }
        for (name, other_type) in values.stale_handles() {
            let name = quote(name);
            add(
                &mut warnings,
                match other_type {
                    Some(ty) => format!("a handle of {name} is left over: the parameter is {ty} now"),
                    None => format!("a handle of {name} is left over: the pipeline has no such parameter"),
                },
            );
        }
        for warning in &warnings {
            if !self.warnings.contains(warning) {
                log::warn!("{warning}");
            }
        }
        self.warnings = warnings;
    }
}

/// Adds a warning if none of the known names is `name`.
fn warn(warnings: &mut Vec<String>, graph: &Graph, what: &str, name: &str, known: &[&str]) {
    if known.contains(&name) {
        return;
    }
    let is_other = graph.meaning_of(name).map(|meaning| format!("that is {meaning}"));
    let hint = is_other.or_else(|| did_you_mean(name, known.iter().copied()));
    let hint = hint.map_or(String::new(), |hint| format!(": {hint}"));
    add(warnings, format!("{what} {}{hint}", quote(name)));
}

fn add(warnings: &mut Vec<String>, warning: String) {
    if !warnings.contains(&warning) {
        warnings.push(warning);
    }
}

fn kind_of(fact: Fact) -> FactKind {
    match fact {
        Fact::Flag(_) => FactKind::Flag,
        Fact::Number(_) => FactKind::Number,
    }
}

fn names_of_images(graph: &Graph) -> impl Iterator<Item = &str> {
    graph.inputs.iter().filter(|input| input.block.is_none()).map(|input| input.name.as_str())
}

fn names_of_blocks(graph: &Graph) -> impl Iterator<Item = &str> {
    graph.inputs.iter().filter(|input| input.block.is_some()).map(|input| input.name.as_str())
}

/// The labels of all tables and values, `node.port`.
fn names_of_buffers(graph: &Graph) -> Vec<String> {
    let mut names = Vec::new();
    for node in &graph.nodes {
        for port in node.kind().outputs().iter().filter(|port| matches!(port.ty, PortType::Table | PortType::Value)) {
            names.push(format!("{}.{}", node.name, port.name));
        }
    }
    names
}
