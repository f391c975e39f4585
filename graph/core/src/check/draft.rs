//! The graph that a check builds: drafts of nodes, and the scopes of names that they live in.

use std::collections::BTreeMap;

use petgraph::graph::{DiGraph, NodeIndex};

use super::{Condition, Graph, GraphInput, GraphOutput, Source};
use crate::document::{InputEntry, OutputEntry};
use crate::node::{Bake, NodeInstance, NodeKind, PortType, Registry};
use afterimage_base::diagnostic::{Location, Spanned};
use afterimage_base::image::{ColorState, Format};
use afterimage_base::value::Value;

/// Nodes, scopes and outputs so far.
#[derive(Default)]
pub(super) struct DraftGraph {
    pub(super) scopes: Vec<Scope>,
    pub(super) nodes: Vec<NodeDraft>,
    pub(super) outputs: Vec<(OutputEntry, Option<Wire>)>,
    /// The wires of the inputs of inner pipelines, with the scopes that declare them.
    pub(super) inner_wires: Vec<(usize, InputEntry, Wire)>,
    /// Wires that are not in this graph, with their scopes: those of other tiers, and those that a change replaced.
    pub(super) wires_elsewhere: Vec<(usize, Spanned<String>)>,
    pub(super) sources_elsewhere: Vec<Source>,
}

/// A node that is being built.
#[derive(Clone)]
pub(super) struct NodeDraft {
    pub(super) name: Spanned<String>,
    pub(super) kind: NodeKind,
    pub(super) kind_location: Location,
    pub(super) scope: usize,
    pub(super) values: Vec<Value>,
    /// Location of each value; `None` for defaults.
    pub(super) written: Vec<Option<Location>>,
    /// Text of the wire of each input.
    pub(super) wire_texts: Vec<Option<Spanned<String>>>,
    /// Source that was found for each input.
    pub(super) wires: Vec<Option<Wire>>,
    pub(super) when: Option<Condition>,
    pub(super) off: bool,
    /// Location of `Off` or `On`.
    pub(super) switched: Option<Location>,
    pub(super) format: Option<Format>,
    pub(super) bake: Option<Bake>,
    pub(super) every: u32,
    pub(super) label: Option<String>,
    /// The state of each output once it is known.
    pub(super) states: Vec<Option<Option<ColorState>>>,
    /// True if parts of it could not be read.
    pub(super) is_partial: bool,
}

/// The names of one pipeline, at the top or used as a node.
pub(super) struct Scope {
    pub(super) parent: Option<usize>,
    /// The name in the parent; empty at the top.
    pub(super) name: Spanned<String>,
    pub(super) inputs: Vec<(InputEntry, Feed)>,
    pub(super) names: BTreeMap<String, Named>,
    pub(super) outputs: Vec<OutputEntry>,
    pub(super) when: Option<Condition>,
    pub(super) off: bool,
    /// Location of `Off` or `On`.
    pub(super) switched: Option<Location>,
    pub(super) label: Option<String>,
    pub(super) facts: Option<Vec<String>>,
    /// True if names are missing because of errors that have been reported.
    pub(super) is_partial: bool,
}

/// Source of an input of a scope.
pub(super) enum Feed {
    Host(usize),
    /// From a wire in the parent scope.
    Wire(Spanned<String>),
    Absent,
}

/// Meaning of a name in a scope.
#[derive(Clone, Copy)]
pub(super) enum Named {
    Input(usize),
    Node(usize),
    Scope(usize),
    /// Something whose error has been reported already.
    Broken,
}

/// A wire whose source has been found.
#[derive(Clone)]
pub(super) struct Wire {
    /// Its source; `None` where the host of an inner pipeline leaves an optional input out.
    pub(super) source: Option<Source>,
    pub(super) location: Location,
    /// The state that an inner pipeline declares for the input which it comes from.
    pub(super) declared: Option<ColorState>,
}

impl DraftGraph {
    /// The inputs of the pipeline at the top.
    pub(super) fn host_inputs(&self) -> impl Iterator<Item = &InputEntry> + '_ {
        self.scopes.first().into_iter().flat_map(|top| top.inputs.iter().map(|(input, _)| input))
    }

    pub(super) fn host_input(&self, input: usize) -> Option<&InputEntry> {
        self.scopes.first()?.inputs.get(input).map(|(input, _)| input)
    }

    pub(super) fn port_type(&self, source: Source) -> PortType {
        match source {
            Source::Input(input) => match self.host_input(input) {
                Some(input) => input_type(input),
                None => PortType::Image,
            },
            Source::Node { node, output, .. } => self.nodes[node].kind.outputs()[output].ty,
        }
    }

    /// The name of a node from the top: `outer/inner`.
    pub(super) fn full_name(&self, draft: &NodeDraft) -> String {
        self.inside(draft.scope, draft.name.value.clone(), |scope| Some(scope.name.value.clone()))
    }

    /// The name of a pipeline used as a node from the top; empty at the top.
    pub(super) fn full_scope_name(&self, scope: usize) -> String {
        let Scope { parent, name, .. } = &self.scopes[scope];
        parent.map_or(String::new(), |parent| {
            self.inside(parent, name.value.clone(), |scope| Some(scope.name.value.clone()))
        })
    }

    /// The name that people shall see, from the top, if it differs from the full name.
    pub(super) fn full_label(&self, draft: &NodeDraft) -> Option<String> {
        let shown = |scope: &Scope| Some(scope.label.clone().unwrap_or_else(|| scope.name.value.clone()));
        let labeled = draft.label.is_some() || self.scopes_around(draft.scope).any(|scope| scope.label.is_some());
        labeled.then(|| {
            let own = draft.label.clone().unwrap_or_else(|| draft.name.value.clone());
            self.inside(draft.scope, own, shown)
        })
    }

    fn inside(&self, scope: usize, name: String, shown: impl Fn(&Scope) -> Option<String>) -> String {
        let outer = self.scopes_around(scope).filter(|scope| scope.parent.is_some()).filter_map(shown);
        outer.fold(name, |name, outer| format!("{outer}/{name}"))
    }

    /// The facts that the file of a scope declares, if it declares any.
    pub(super) fn facts(&self, scope: usize) -> Option<&[String]> {
        self.scopes[scope].facts.as_deref()
    }

    /// The scope and those around it, from the inside.
    pub(super) fn scopes_around(&self, scope: usize) -> impl Iterator<Item = &Scope> + '_ {
        std::iter::successors(Some(&self.scopes[scope]), |scope| scope.parent.map(|parent| &self.scopes[parent]))
    }

    /// The graph, if there are no errors.
    pub(super) fn graph(&self, registry: &Registry, instances: Vec<NodeInstance>) -> Graph {
        let inputs = self.host_inputs().map(|input| GraphInput {
            name: input.name.value.clone(),
            block: input.block.as_ref().and_then(|name| registry.block(&name.value)),
            state: input.state,
            min_channels: input.min_channels,
            optional: input.optional,
            multisampled: input.multisampled,
            volume: input.volume,
            needs_alpha: input.needs_alpha,
            scale: input.scale,
        });
        let nodes = self.nodes.iter().zip(instances);
        let outputs = self.outputs.iter().filter_map(|(output, wire)| self.graph_output(output, wire.as_ref()?));
        Graph {
            inputs: inputs.collect(),
            nodes: nodes.map(|(draft, instance)| self.graph_node(draft, instance)).collect(),
            outputs: outputs.collect(),
            wires: self.same_frame(),
        }
    }

    fn graph_output(&self, output: &OutputEntry, wire: &Wire) -> Option<GraphOutput> {
        let state = self.state(wire).flatten().unwrap_or(ColorState::Data);
        let OutputEntry { name, has_coverage, .. } = output;
        Some(GraphOutput { name: name.value.clone(), source: wire.source?, state, has_coverage: *has_coverage })
    }

    /// An edge from each node to each that reads it in the same frame.
    pub(super) fn same_frame(&self) -> DiGraph<(), ()> {
        let mut graph = DiGraph::new();
        let indices: Vec<NodeIndex> = self.nodes.iter().map(|_| graph.add_node(())).collect();
        for (reader, draft) in self.nodes.iter().enumerate() {
            let mut made: Vec<usize> = draft.wires.iter().flatten().filter_map(Wire::same_frame_node).collect();
            made.sort_unstable();
            made.dedup();
            graph.extend_with_edges(made.into_iter().map(|maker| (indices[maker], indices[reader])));
        }
        graph
    }
}

pub(super) fn input_type(input: &InputEntry) -> PortType {
    match input.block {
        Some(_) => PortType::Block,
        None if input.multisampled => PortType::Multisampled,
        None if input.volume => PortType::Volume,
        None => PortType::Image,
    }
}

impl Wire {
    /// The node whose result of this frame it carries.
    pub(super) fn same_frame_node(&self) -> Option<usize> {
        match self.source {
            Some(Source::Node { node, previous: 0, .. }) => Some(node),
            _ => None,
        }
    }
}
