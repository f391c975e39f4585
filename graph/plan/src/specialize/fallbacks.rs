//! Nodes that are off, whose condition does not hold, or that are an identity at their present values get their
//! fallbacks.

use std::collections::BTreeSet;

use petgraph::Direction;
use petgraph::graph::NodeIndex;

use super::wires::{SpecializedGraph, WireSource};
use crate::plan::Skipped;
use crate::request::PlanRequest;
use crate::topological::stable_order;
use afterimage_graph::check::{Graph, Source};
use afterimage_graph::node::{Arrivals, Fallback, PortType};

pub(super) fn put_fallbacks(graph: &Graph, request: &PlanRequest<'_>) -> SpecializedGraph {
    let order = order(graph);
    let count = graph.nodes.len();
    let given = graph.inputs.iter().map(|input| request.inputs.contains_key(&input.name)).collect();
    let mut specialized = SpecializedGraph {
        order: Vec::new(),
        runs: vec![false; count],
        outputs: vec![Vec::new(); count],
        given,
        wanted: Vec::new(),
        skipped: Vec::new(),
    };
    let remembered = remembered(graph);
    for &index in &order {
        let verdict = verdict(graph, request, &specialized, index, remembered.contains(&index));
        specialized.outputs[index] = match &verdict {
            None => ports_of(index, graph.nodes[index].kind().outputs().len()),
            Some((fallback, _)) => replace(graph, &specialized, index, fallback),
        };
        specialized.runs[index] = verdict.is_none();
        let node = graph.nodes[index].name.clone();
        specialized.skipped.extend(verdict.map(|(_, why)| Skipped { node, why }));
    }
    specialized.order = order;
    specialized
}

fn ports_of(node: usize, count: usize) -> Vec<WireSource> {
    (0..count).map(|output| WireSource::From(Source::Node { node, output, previous: 0 })).collect()
}

/// Nodes whose results of earlier frames are read: their memory must go on, so no identity removes them.
fn remembered(graph: &Graph) -> BTreeSet<usize> {
    let wires = graph.nodes.iter().flat_map(|node| &node.wires).flatten();
    let outputs = graph.outputs.iter().map(|output| &output.source);
    wires
        .chain(outputs)
        .filter_map(|source| match source {
            Source::Node { node, previous: 1.., .. } => Some(*node),
            _ => None,
        })
        .collect()
}

/// The fallback of a node and the reason, or `None` if it runs.
fn verdict(
    graph: &Graph,
    request: &PlanRequest<'_>,
    specialized: &SpecializedGraph,
    index: usize,
    remembered: bool,
) -> Option<(Fallback, String)> {
    let node = &graph.nodes[index];
    if node.off {
        return Some((node.kind().fallback(), "switched off".into()));
    }
    if let Some(condition) = node.when.as_ref().filter(|condition| !condition.holds(&request.facts)) {
        return Some((node.kind().fallback(), format!("`when: {condition}` does not hold")));
    }
    let mut zero = Vec::new();
    let mut absent = Vec::new();
    for (port, wire) in node.kind().inputs().iter().zip(&node.wires) {
        match specialized.resolve(*wire) {
            WireSource::Zero => zero.push(port.name.clone()),
            WireSource::Absent => absent.push(port.name.clone()),
            WireSource::From(_) => {}
        }
    }
    let arrivals = Arrivals::new(zero, absent);
    if !remembered && let Some(fallback) = node.instance.identity(&arrivals) {
        return Some((fallback, "changes nothing here".into()));
    }
    let starved = node.kind().inputs().iter().find(|port| !port.optional && arrivals.is_absent(&port.name))?;
    Some((Fallback::Absent, format!("nothing arrives at its input `{}`", starved.name)))
}

fn replace(graph: &Graph, specialized: &SpecializedGraph, index: usize, fallback: &Fallback) -> Vec<WireSource> {
    let node = &graph.nodes[index];
    let of_port = |ty: PortType| match fallback {
        Fallback::Absent => WireSource::Absent,
        Fallback::Zero if matches!(ty, PortType::Image | PortType::Pyramid) => WireSource::Zero,
        Fallback::Zero => WireSource::Absent,
        Fallback::Input(name) => {
            let port = node.kind().inputs().iter().position(|input| input.name == *name && input.ty == ty);
            port.map_or(WireSource::Absent, |port| specialized.resolve(node.wires[port]))
        }
    };
    node.kind().outputs().iter().map(|output| of_port(output.ty)).collect()
}

/// An order in which nodes can be recorded.
fn order(graph: &Graph) -> Vec<usize> {
    let before = |node| graph.wires.neighbors_directed(node, Direction::Incoming).map(NodeIndex::index).collect();
    stable_order(&graph.wires.node_indices().map(before).collect::<Vec<_>>())
}
