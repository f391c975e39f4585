//! Parameters that do nothing at present, and why.

use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage_graph::check::{Graph, ParameterId};
use afterimage_graph::image::Size;
use afterimage_graph::node::{Decisive, Inactive, InactiveParameters, NodeInUse, NodeInstance};
use afterimage_graph::value::{Type, Value};

use super::changes::{Changes, Target};

/// What is known of the nodes whose parameters are shown.
#[derive(Default)]
pub(super) struct InactiveCache {
    finder: InactiveParameters,
    /// The graph that the nodes are of.
    graph: Option<Arc<Graph>>,
    /// By the indices of the nodes.
    nodes: BTreeMap<usize, KnownNode>,
}

struct KnownNode {
    instance: NodeInstance,
    wired: Vec<bool>,
    size: Size,
    found: Vec<Option<Inactive>>,
    /// The reasons that were asked for, by the indices of the parameters.
    reasons: BTreeMap<usize, String>,
}

/// Values that a reason lists.
const MAX_LISTED: usize = 4;

impl InactiveCache {
    /// Whether a parameter does nothing.
    pub(super) fn is_inactive(&self, parameter: ParameterId) -> bool {
        self.nodes.get(&parameter.node).is_some_and(|node| node.found[parameter.index].is_some())
    }

    /// Why a parameter does nothing, as a sentence.
    pub(super) fn reason(&mut self, parameter: ParameterId) -> Option<String> {
        let node = self.nodes.get_mut(&parameter.node)?;
        let why = node.found[parameter.index].as_ref()?;
        let in_use = NodeInUse { instance: &node.instance, wired: &node.wired, size: node.size };
        let reason = node.reasons.entry(parameter.index).or_insert_with(|| match why {
            Inactive::NoEffect => no_effect(in_use, self.finder.decisive(in_use, parameter.index)),
            Inactive::Refused(why) => format!("At present the node takes no other value: {why}."),
        });
        Some(reason.clone())
    }

    /// Looks at a node again if its values, the graph or the size are others. While a control is dragged, what was
    /// known before holds.
    pub(super) fn update(&mut self, graph: &Arc<Graph>, node: usize, changes: &Changes, size: Size) {
        if !self.graph.as_ref().is_some_and(|known| Arc::ptr_eq(known, graph)) {
            self.graph = Some(graph.clone());
            self.nodes.clear();
        }
        let known = self.nodes.get(&node);
        if known.is_some() && changes.is_dragging() {
            return;
        }
        let values = present_values(graph, node, changes);
        if known.is_some_and(|known| known.instance.values() == values && known.size == size) {
            return;
        }
        let instance = NodeInstance::new(graph.nodes[node].kind().clone(), values);
        let wired: Vec<bool> = graph.nodes[node].wires.iter().map(Option::is_some).collect();
        let found = self.finder.of(NodeInUse { instance: &instance, wired: &wired, size });
        self.nodes.insert(node, KnownNode { instance, wired, size, found, reasons: BTreeMap::new() });
    }
}

/// The values of a node's parameters with those that the user has changed.
fn present_values(graph: &Graph, node: usize, changes: &Changes) -> Vec<Value> {
    let mut values = graph.nodes[node].instance.values().to_vec();
    for (index, value) in values.iter_mut().enumerate() {
        let target = Target::Parameter(graph.parameter_name(ParameterId { node, index }));
        if let Some(changed) = changes.get(&target) {
            value.clone_from(changed);
        }
    }
    values
}

/// The reason of a parameter without effect.
fn no_effect(node: NodeInUse<'_>, decisive: Option<Decisive>) -> String {
    let kind = node.instance.kind();
    match decisive {
        Some(Decisive::Parameter(index, values)) => {
            let param = &kind.params()[index];
            let mut text = format!("Does nothing while `{}` is {}.", param.name, node.instance.values()[index]);
            if matches!(param.ty, Type::Choice(_)) && values.len() <= MAX_LISTED {
                let values: Vec<String> = values.iter().map(Value::to_string).collect();
                text += &format!(" It is for {}.", values.join(", "));
            }
            text
        }
        Some(Decisive::Input(index)) => {
            let what = if node.wired[index] { "something" } else { "nothing" };
            format!("Does nothing while {what} is wired to `{}`.", kind.inputs()[index].name)
        }
        None => "Does nothing at the present values of the other parameters, for images of this size.".to_owned(),
    }
}
