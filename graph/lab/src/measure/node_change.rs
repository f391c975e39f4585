//! The changes that a tier can make to a node.

use afterimage_graph::check::{Condition, Graph, GraphNode};
use afterimage_graph::image::Format;
use afterimage_graph::node::Bake;
use afterimage_graph::value::Value;

/// A change of one field of a node.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum NodeChange {
    /// Of a parameter, by its index among the node's values.
    Value(usize, Value),
    /// True switches the node off.
    Off(bool),
    When(Option<Condition>),
    /// Of its results; `None` is the format that the node chooses.
    Format(Option<Format>),
    Bake(Option<Bake>),
    /// In one of how many frames it runs.
    Every(u32),
    Label(Option<String>),
}

impl NodeChange {
    /// The changes that turn one node into another of the same kind.
    pub(crate) fn between(from: &GraphNode, to: &GraphNode) -> Vec<Self> {
        let all = |node: &GraphNode| {
            let mut all = vec![Self::Off(node.off)];
            all.extend(node.instance.values().iter().cloned().enumerate().map(|(at, value)| Self::Value(at, value)));
            all.extend([
                Self::When(node.when.clone()),
                Self::Format(node.format),
                Self::Bake(node.bake),
                Self::Every(node.every),
                Self::Label(node.label.clone()),
            ]);
            all
        };
        all(from).into_iter().zip(all(to)).filter(|(from, to)| from != to).map(|(_, to)| to).collect()
    }

    /// Makes it.
    pub(crate) fn apply(&self, node: &mut GraphNode) {
        match self {
            Self::Value(at, value) => drop(node.instance.set(*at, value.clone())),
            Self::Off(off) => node.off = *off,
            Self::When(when) => node.when.clone_from(when),
            Self::Format(format) => node.format = *format,
            Self::Bake(bake) => node.bake = *bake,
            Self::Every(every) => node.every = *every,
            Self::Label(label) => node.label.clone_from(label),
        }
    }

    /// The name of the field, as tiers and `--set` name it: `node.parameter`, or the node's for `On` and `Off`.
    pub(crate) fn key(&self, node: &GraphNode) -> String {
        let field = match self {
            Self::Value(at, _) => &*node.kind().params()[*at].name,
            Self::Off(_) => return node.name.clone(),
            Self::When(_) => "when",
            Self::Format(_) => "format",
            Self::Bake(_) => "bake",
            Self::Every(_) => "every",
            Self::Label(_) => "label",
        };
        format!("{}.{field}", node.name)
    }

    /// The value as in a pipeline file; `None` for that of a field that the file leaves out.
    pub(crate) fn text(&self) -> Option<String> {
        match self {
            Self::Value(_, value) => Some(value.to_string()),
            Self::Off(off) => Some(if *off { "Off" } else { "On" }.to_owned()),
            Self::When(when) => when.as_ref().map(|when| format!("{:?}", when.to_string())),
            Self::Format(format) => format.map(|format| format.name().to_owned()),
            Self::Bake(bake) => bake.map(|bake| bake.to_string()),
            Self::Every(every) => Some(every.to_string()),
            Self::Label(label) => label.as_ref().map(|label| format!("{label:?}")),
        }
    }
}

/// The entries of a tier that turns `from` into `to`: `"node.parameter": value`. Both graphs have the same nodes and
/// wires.
pub fn changes(from: &Graph, to: &Graph) -> Vec<String> {
    let mut all = Vec::new();
    for (from, to) in from.nodes.iter().zip(&to.nodes) {
        for change in NodeChange::between(from, to) {
            all.extend(change.text().map(|text| format!("{:?}: {text}", change.key(to))));
        }
    }
    all
}

/// Copies of `from`, each with one of the changes that turn it into `to`. A change that is not valid without others
/// has none, nor has one that a file cannot write.
pub(crate) fn single_changes(from: &Graph, to: &Graph) -> Vec<Graph> {
    let mut all = Vec::new();
    for (index, (before, after)) in from.nodes.iter().zip(&to.nodes).enumerate() {
        for change in NodeChange::between(before, after) {
            let mut graph = from.clone();
            change.apply(&mut graph.nodes[index]);
            let is_seen = change.text().is_some() && !matches!(change, NodeChange::Label(_));
            if is_seen && graph.nodes[index].instance.verify().is_ok() {
                all.push(graph);
            }
        }
    }
    all
}
