//! The graph: what a document means once every error is out of it.

use std::collections::BTreeSet;

use petgraph::graph::DiGraph;

use crate::node::{Bake, HostBlock, NodeInstance, NodeKind, PortType};
use afterimage_base::diagnostic::{did_you_mean, list, quote};
use afterimage_base::image::{ColorState, Format};
use afterimage_base::value::{Param, Value};

use super::condition::{Condition, FactKind};

/// A valid pipeline: both ends of every wire have one type, every value is in its domain, there are no cycles.
#[derive(Clone, Debug)]
pub struct Graph {
    /// The images and blocks that the host gives.
    pub inputs: Vec<GraphInput>,
    /// The nodes, in the order of the file; those of a pipeline used as a node are called `outer/inner`.
    pub nodes: Vec<GraphNode>,
    /// Images of the host's outputs.
    pub outputs: Vec<GraphOutput>,
    /// An edge from each node to each that reads it in the same frame. Node indices are those of `nodes`.
    pub wires: DiGraph<(), ()>,
}

/// An image or a host block that the host gives.
#[derive(Clone, Debug, PartialEq)]
pub struct GraphInput {
    /// Its name.
    pub name: String,
    /// The declaration of a host block; `None` for an image.
    pub block: Option<&'static HostBlock>,
    /// Color state of an image.
    pub state: ColorState,
    /// Channels that an image has at least: 2 for `Motion`, 3 for `Normals`.
    pub min_channels: u8,
    /// True if the host may leave it out.
    pub optional: bool,
    /// True if it has several samples in each pixel.
    pub multisampled: bool,
    /// True if it is a volume.
    pub volume: bool,
    /// True if the pipeline needs an alpha that is not 1 everywhere, as a mask. A host should warn about an image
    /// without one.
    pub needs_alpha: bool,
    /// A factor of its colors, before they are limited to the range of half floats.
    pub scale: f64,
}

impl GraphInput {
    /// Its outputs.
    pub fn port_type(&self) -> PortType {
        match self.block {
            Some(_) => PortType::Block,
            None if self.multisampled => PortType::Multisampled,
            None if self.volume => PortType::Volume,
            None => PortType::Image,
        }
    }
}

/// A node.
#[derive(Clone, Debug)]
pub struct GraphNode {
    /// Its name in the file.
    pub name: String,
    /// The node of its kind at its parameter values.
    pub instance: NodeInstance,
    /// Sources of its inputs, in the order of the kind's ports.
    pub wires: Vec<Option<Source>>,
    /// Condition under which it is needed; always if `None`.
    pub when: Option<Condition>,
    /// True if a tier has switched it off.
    pub off: bool,
    /// The format of its results, if the file sets one.
    pub format: Option<Format>,
    /// True if a table may take its place, if the file says so.
    pub bake: Option<Bake>,
    /// In one of how many frames it runs, from 1, if nothing has begun anew. Its results are held in between.
    pub every: u32,
    /// The name that people shall see; the node's name otherwise.
    pub label: Option<String>,
    /// The state of each output, in the order of the kind's ports; `None` for what has none.
    pub states: Vec<Option<ColorState>>,
}

/// Images of the host's outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct GraphOutput {
    /// Its name.
    pub name: String,
    /// Its source.
    pub source: Source,
    /// Its color state.
    pub state: ColorState,
    /// True if its alpha is coverage, the share of the pixel that the picture covers. Otherwise it may be a mask, and a
    /// file for a display is opaque.
    pub has_coverage: bool,
}

/// Source of a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// An input of the pipeline.
    Input(usize),
    /// An output of a node.
    Node {
        /// The index of the node in the graph.
        node: usize,
        /// The index of the output in the kind's ports.
        output: usize,
        /// Number of frames back; 0 for this one.
        previous: u32,
    },
}

impl GraphNode {
    /// Its kind.
    pub fn kind(&self) -> &NodeKind {
        self.instance.kind()
    }

    /// Returns whether all but the values of parameters is the same.
    fn has_structure_of(&self, other: &Self) -> bool {
        let Self { name, instance, wires, when, off, format, bake, every, label, states } = other;
        self.name == *name
            && self.kind().is(instance.kind())
            && self.wires == *wires
            && self.when == *when
            && self.off == *off
            && self.format == *format
            && self.bake == *bake
            && self.every == *every
            && self.label == *label
            && self.states == *states
    }
}

fn with_hint(message: String, hint: Option<String>) -> String {
    match hint {
        Some(hint) => format!("{message}: {hint}"),
        None => message,
    }
}

/// A parameter of a node of a graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ParameterId {
    /// The index of the node in the graph.
    pub node: usize,
    /// The index of the parameter in the table of its kind.
    pub index: usize,
}

impl Graph {
    /// The parameter that `node.parameter` names.
    ///
    /// # Errors
    /// There is none: a sentence that suggests the nearest name.
    pub fn parameter(&self, name: &str) -> Result<ParameterId, String> {
        let (node_name, parameter) = name.rsplit_once('.').unwrap_or((name, ""));
        let Some((node, found)) = self.node(node_name) else {
            let names = self.nodes.iter().map(|node| node.name.as_str());
            let is_other = self.meaning_of(node_name).map(|meaning| format!("that is {meaning}"));
            let hint = is_other.or_else(|| did_you_mean(node_name, names));
            return Err(with_hint(format!("no node is called {}", quote(node_name)), hint));
        };
        let Some((index, _)) = found.kind().param(parameter) else {
            let names = found.kind().params().iter().map(|param| &*param.name);
            let node_name = quote(node_name);
            if name.contains('.') {
                let message = format!("{node_name} has no parameter {}", quote(parameter));
                return Err(with_hint(message, did_you_mean(parameter, names)));
            }
            let all: Vec<String> = names.map(|name| format!("{}.{name}", found.name)).collect();
            return Err(match all.is_empty() {
                true => format!("{node_name} is a node without parameters"),
                false => format!("{node_name} is a node; it has {}", list(all.iter().map(String::as_str), 16)),
            });
        };
        Ok(ParameterId { node, index })
    }

    /// Description of a name of this pipeline: a hint for a name in the wrong place.
    pub fn meaning_of(&self, name: &str) -> Option<String> {
        let input = self.inputs.iter().find(|input| input.name == name);
        let inner =
            self.nodes.iter().find(|node| node.name.strip_prefix(name).is_some_and(|rest| rest.starts_with('/')));
        Some(match (input, inner) {
            (Some(input), _) if input.block.is_some() => "an input for a block".into(),
            (Some(_), _) => "an image input".into(),
            _ if self.node(name).is_some() => "a node".into(),
            (_, Some(inner)) => format!("a pipeline with nodes like {}", quote(&inner.name)),
            _ if self.outputs.iter().any(|output| output.name == name) => "an output".into(),
            _ if self.facts().iter().any(|(fact, _)| fact == name) => "a fact".into(),
            _ if self.parameters().any(|id| self.parameter_name(id) == name) => "a parameter".into(),
            _ => return None,
        })
    }

    /// Returns whether another graph has the same inputs, nodes, wires and outputs: then at most values differ.
    pub fn has_structure_of(&self, other: &Self) -> bool {
        self.inputs == other.inputs
            && self.outputs == other.outputs
            && self.nodes.len() == other.nodes.len()
            && self.nodes.iter().zip(&other.nodes).all(|(own, other)| own.has_structure_of(other))
    }

    /// All parameters of all nodes.
    pub fn parameters(&self) -> impl Iterator<Item = ParameterId> + '_ {
        let of_node = |(node, found): (usize, &GraphNode)| {
            (0..found.kind().params().len()).map(move |index| ParameterId { node, index })
        };
        self.nodes.iter().enumerate().flat_map(of_node)
    }

    /// The name of a parameter, `node.parameter`.
    pub fn parameter_name(&self, parameter: ParameterId) -> String {
        format!("{}.{}", self.nodes[parameter.node].name, self.declaration(parameter).name)
    }

    /// The present value of a parameter.
    pub fn value(&self, parameter: ParameterId) -> &Value {
        &self.nodes[parameter.node].instance.values()[parameter.index]
    }

    /// The declaration of a parameter.
    pub fn declaration(&self, parameter: ParameterId) -> &Param {
        &self.nodes[parameter.node].kind().params()[parameter.index]
    }

    /// The node of that name and its location.
    pub fn node(&self, name: &str) -> Option<(usize, &GraphNode)> {
        self.nodes.iter().enumerate().find(|(_, node)| node.name == name)
    }

    /// The facts that conditions ask for, by name, and what each is taken for.
    pub fn facts(&self) -> Vec<(String, FactKind)> {
        let used = self.nodes.iter().filter_map(|node| node.when.as_ref()).flat_map(Condition::uses);
        let all: BTreeSet<(String, FactKind)> = used.map(|(name, kind)| (name.to_owned(), kind)).collect();
        all.into_iter().collect()
    }

    /// The type of what a wire carries.
    pub fn port_type(&self, source: Source) -> PortType {
        match source {
            Source::Input(input) => self.inputs[input].port_type(),
            Source::Node { node, output, .. } => self.nodes[node].kind().outputs()[output].ty,
        }
    }
}
