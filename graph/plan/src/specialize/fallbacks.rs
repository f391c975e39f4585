//! Nodes that are off, whose condition does not hold, or that are an identity at their present values get their
//! fallbacks.

use std::collections::{BTreeMap, BTreeSet};

use petgraph::Direction;
use petgraph::graph::NodeIndex;

use super::specialized_graph::{SpecializedGraph, WireSource};
use crate::plan::Skipped;
use crate::request::PlanRequest;
use crate::topological::stable_order;
use afterimage_base::value::Value;
use afterimage_graph::check::{Graph, GraphNode, Source};
use afterimage_graph::node::{Fallback, Input, InputValues, NodeInstance, Output};

pub(super) fn put_fallbacks(graph: &Graph, request: &PlanRequest<'_>) -> SpecializedGraph {
    let order = order(graph);
    let count = graph.nodes.len();
    let given = graph.inputs.iter().map(|input| request.given.has(input)).collect();
    let mut specialized = SpecializedGraph {
        order: Vec::new(),
        runs: vec![false; count],
        outputs: vec![Vec::new(); count],
        given,
        used_outputs: Vec::new(),
        skipped: Vec::new(),
        identities: BTreeMap::new(),
    };
    let remembered = remembered(graph);
    for &index in &order {
        let (inputs, outputs) = (inputs(graph, &specialized, index), graph.nodes[index].kind().outputs());
        let dynamic = request.dynamic_of(index);
        let off = off(&graph.nodes[index], request);
        let may_be_replaced = off.is_none() && !remembered.contains(&index);
        let equals = |output: &Output| is_identity(&graph.nodes[index].instance, &dynamic, &output.name, &inputs);
        let replaced: Vec<bool> = outputs.iter().map(|output| may_be_replaced && equals(output)).collect();
        let verdict = off.map_or_else(|| verdict(&graph.nodes[index], &inputs, &replaced), Verdict::Fallbacks);
        specialized.outputs[index] = (0..outputs.len())
            .map(|output| match &verdict {
                Verdict::Runs if !replaced[output] => {
                    WireSource::From(Source::Node { node: index, output, previous: 0 })
                }
                Verdict::Runs | Verdict::Fallbacks(_) => fallback(graph, &specialized, index, &outputs[output]),
                Verdict::Starved(_) => WireSource::Absent,
            })
            .collect();
        specialized.runs[index] = matches!(verdict, Verdict::Runs);
        let node = graph.nodes[index].name.clone();
        specialized.skipped.extend(verdict.reason().map(|why| Skipped { node, why }));
        if replaced.contains(&true) && !dynamic.is_empty() {
            specialized.identities.insert(index, (inputs, replaced));
        }
    }
    specialized.order = order;
    specialized
}

enum Verdict {
    /// It runs. Outputs that equal their fallbacks are replaced by them.
    Runs,
    /// It does not run for this reason; readers of each output get its fallback.
    Fallbacks(String),
    /// Its first input does not arrive: it does not run, and its readers get nothing.
    Starved(String),
}

impl Verdict {
    /// The reason that the node does not run.
    fn reason(self) -> Option<String> {
        match self {
            Self::Runs => None,
            Self::Fallbacks(why) | Self::Starved(why) => Some(why),
        }
    }
}

/// Nodes whose results of earlier frames are read: their memory must continue, so no identity removes them.
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

/// The reason that a node is off, if it is.
fn off(node: &GraphNode, request: &PlanRequest<'_>) -> Option<String> {
    if node.off {
        return Some("switched off".into());
    }
    let condition = node.when.as_ref().filter(|condition| !condition.holds(&request.facts))?;
    Some(format!("`when: {condition}` does not hold"))
}

/// Decides about a node that is not off. `replaced` states of each output whether its fallback equals it.
fn verdict(node: &GraphNode, inputs: &InputValues, replaced: &[bool]) -> Verdict {
    if replaced.iter().all(|replaced| *replaced) {
        return Verdict::Fallbacks("changes nothing here".into());
    }
    let mut ports = node.kind().inputs().iter().enumerate();
    let starved = ports.find(|(_, port)| !port.optional && inputs.is_absent(&port.name));
    let why = |port: &Input| format!("nothing arrives at its input `{}`", port.name);
    match starved {
        None => Verdict::Runs,
        // Without its image there is nothing to give. Without a depth or a camera the image stays as it is.
        Some((0, port)) => Verdict::Starved(why(port)),
        Some((_, port)) => Verdict::Fallbacks(why(port)),
    }
}

/// Returns whether an output equals its fallback at all values of the dynamic parameters.
fn is_identity(instance: &NodeInstance, dynamic: &[usize], output: &str, inputs: &InputValues) -> bool {
    // An identity because of what arrives is one at all values. One because of its values is very likely not one at
    // some of these; should it be, `DynamicNodes` notices the first values at which it is none.
    let trials = if dynamic.is_empty() { 0 } else { TRIALS };
    instance.identity_of(output, inputs)
        && (0..trials).all(|trial| at_other_values(instance, dynamic, trial).identity_of(output, inputs))
}

/// Trials of values of dynamic parameters at which an identity must hold.
const TRIALS: usize = 48;

/// The node with its dynamic parameters at other values, mixed in a way that depends on the number of the trial.
fn at_other_values(instance: &NodeInstance, dynamic: &[usize], trial: usize) -> NodeInstance {
    let mut other = instance.clone();
    for &index in dynamic {
        let param = &instance.kind().params()[index];
        let present = Some(instance.values()[index].clone());
        let values = [param.lowest(), param.highest(), param.middle(), Some(param.default.clone()), present];
        let values: Vec<Value> = values.into_iter().flatten().collect();
        let mixed = (trial as u32 + 1).wrapping_mul(0x9e37_79b1).wrapping_mul(2 * index as u32 + 1) >> 16;
        other.set(index, values[mixed as usize % values.len()].clone());
    }
    other
}

/// The inputs of a node that are zero, and those without a source.
fn inputs(graph: &Graph, specialized: &SpecializedGraph, index: usize) -> InputValues {
    let node = &graph.nodes[index];
    let mut zero = Vec::new();
    let mut absent = Vec::new();
    for (input, wire) in node.wires.iter().enumerate() {
        match specialized.resolve(*wire) {
            WireSource::Zero => zero.push(input),
            WireSource::Absent => absent.push(input),
            WireSource::From(_) => {}
        }
    }
    InputValues::new(node.kind().clone(), zero, absent)
}

/// The source of readers of an output whose node does not run.
fn fallback(graph: &Graph, specialized: &SpecializedGraph, index: usize, output: &Output) -> WireSource {
    let node = &graph.nodes[index];
    match &output.fallback {
        Fallback::Absent => WireSource::Absent,
        Fallback::Zero => WireSource::Zero,
        Fallback::Input(name) => {
            let port = node.kind().inputs().iter().position(|input| input.name == *name);
            let port =
                port.unwrap_or_else(|| panic!("the contract test finds the fallback `{name}` of `{}`", node.name));
            specialized.resolve(node.wires[port])
        }
    }
}

/// An order in which nodes can be recorded.
fn order(graph: &Graph) -> Vec<usize> {
    let before = |node| graph.wires.neighbors_directed(node, Direction::Incoming).map(NodeIndex::index).collect();
    stable_order(&graph.wires.node_indices().map(before).collect::<Vec<_>>())
}
