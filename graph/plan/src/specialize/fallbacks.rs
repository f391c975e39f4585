//! Nodes that are off, whose condition does not hold, or that are an identity at their present values get their
//! fallbacks.

use std::collections::{BTreeMap, BTreeSet};

use petgraph::Direction;
use petgraph::graph::NodeIndex;

use super::wires::{SpecializedGraph, WireSource};
use crate::plan::Skipped;
use crate::request::PlanRequest;
use crate::topological::stable_order;
use afterimage_base::value::Value;
use afterimage_graph::check::{Graph, Source};
use afterimage_graph::node::{Arrivals, Fallback, NodeInstance, PortType};

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
        identities: BTreeMap::new(),
    };
    let remembered = remembered(graph);
    for &index in &order {
        let arrivals = arrivals(graph, &specialized, index);
        let verdict = verdict(graph, request, index, (&arrivals, remembered.contains(&index)));
        specialized.outputs[index] = match &verdict {
            None => ports_of(index, graph.nodes[index].kind().outputs().len()),
            Some(verdict) => replace(graph, &specialized, index, &verdict.fallback),
        };
        specialized.runs[index] = verdict.is_none();
        let Some(Verdict { fallback, why, is_identity }) = verdict else { continue };
        specialized.skipped.push(Skipped { node: graph.nodes[index].name.clone(), why });
        if is_identity {
            specialized.identities.insert(index, (arrivals, fallback));
        }
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

/// Which inputs of a node are zero, and at which nothing arrives.
fn arrivals(graph: &Graph, specialized: &SpecializedGraph, index: usize) -> Arrivals {
    let node = &graph.nodes[index];
    let mut zero = Vec::new();
    let mut absent = Vec::new();
    for (port, wire) in node.kind().inputs().iter().zip(&node.wires) {
        match specialized.resolve(*wire) {
            WireSource::Zero => zero.push(port.name.clone()),
            WireSource::Absent => absent.push(port.name.clone()),
            WireSource::From(_) => {}
        }
    }
    Arrivals::new(zero, absent)
}

/// What replaces a node, and why.
struct Verdict {
    fallback: Fallback,
    why: String,
    is_identity: bool,
}

impl Verdict {
    fn new(fallback: Fallback, why: impl Into<String>) -> Self {
        Self { fallback, why: why.into(), is_identity: false }
    }
}

/// What replaces a node, or `None` if it runs. A node that is remembered runs also as an identity.
fn verdict(
    graph: &Graph,
    request: &PlanRequest<'_>,
    index: usize,
    (arrivals, remembered): (&Arrivals, bool),
) -> Option<Verdict> {
    let node = &graph.nodes[index];
    if node.off {
        return Some(Verdict::new(node.kind().fallback(), "switched off"));
    }
    if let Some(condition) = node.when.as_ref().filter(|condition| !condition.holds(&request.facts)) {
        return Some(Verdict::new(node.kind().fallback(), format!("`when: {condition}` does not hold")));
    }
    if !remembered && let Some(fallback) = identity(&node.instance, &request.dynamic_of(index), arrivals) {
        return Some(Verdict { is_identity: true, ..Verdict::new(fallback, "changes nothing here") });
    }
    let starved = node.kind().inputs().iter().find(|port| !port.optional && arrivals.is_absent(&port.name))?;
    Some(Verdict::new(Fallback::Absent, format!("nothing arrives at its input `{}`", starved.name)))
}

/// The fallback that equals the node's output, whatever values its dynamic parameters get.
fn identity(instance: &NodeInstance, dynamic: &[usize], arrivals: &Arrivals) -> Option<Fallback> {
    let fallback = instance.identity(arrivals)?;
    // An identity because of what arrives is one at all values. One because of its values is very likely not one at
    // some of these; should it be, `DynamicNodes` notices the first values at which it is none.
    let probes = if dynamic.is_empty() { 0 } else { PROBES };
    let holds = |probe: usize| probed(instance, dynamic, probe).identity(arrivals).as_ref() == Some(&fallback);
    (0..probes).all(holds).then_some(fallback)
}

/// Values of dynamic parameters at which an identity must hold.
const PROBES: usize = 48;

/// The node with its dynamic parameters at other values, mixed in a way that depends on the number of the probe.
fn probed(instance: &NodeInstance, dynamic: &[usize], probe: usize) -> NodeInstance {
    let mut other = instance.clone();
    for &index in dynamic {
        let param = &instance.kind().params()[index];
        let present = Some(instance.values()[index].clone());
        let values = [param.lowest(), param.highest(), param.middle(), Some(param.default.clone()), present];
        let values: Vec<Value> = values.into_iter().flatten().collect();
        let mixed = (probe as u32 + 1).wrapping_mul(0x9e37_79b1).wrapping_mul(2 * index as u32 + 1) >> 16;
        other.set(index, values[mixed as usize % values.len()].clone());
    }
    other
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
