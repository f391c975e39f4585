//! The truth of a pipeline, and the variants that are measured against it.

use std::path::Path;

use afterimage_graph::check::{Graph, GraphNode};
use afterimage_graph::image::{ColorState, Format};
use afterimage_graph::node::{PortType, Registry};
use afterimage_graph::value::Value;

use crate::args::PipelineOptions;
use crate::failure::Failure;
use crate::pipeline::{check_file, tier_names};

/// What kind of variant it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum VariantKind {
    /// What all others are compared with.
    Truth,
    /// The file as it is.
    Written,
    /// A tier of the file.
    Tier,
    /// One quality switch turned.
    Switch,
    /// The format of one node's results changed.
    Format,
}

impl VariantKind {
    /// The name in files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Truth => "truth",
            Self::Written => "written",
            Self::Tier => "tier",
            Self::Switch => "switch",
            Self::Format => "format",
        }
    }
}

/// A pipeline to measure.
#[derive(Clone, Debug)]
pub(crate) struct Variant {
    /// What people see: `tier low`, or what `--set` takes, `mips.filter=Tap9`.
    pub(crate) name: String,
    pub(crate) kind: VariantKind,
    pub(crate) graph: Graph,
}

impl Variant {
    /// Whether intermediates are stored in 32 bits.
    pub(crate) fn is_exact(&self) -> bool {
        self.kind == VariantKind::Truth
    }
}

/// What a switch turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turns {
    /// A parameter, by its place among the node's values.
    Parameter(usize),
    /// The format of the node's results.
    Format,
}

/// A value that a switch can have.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Choice {
    /// Of a parameter.
    Value(Value),
    /// Of the format; `None` leaves it to the node.
    Format(Option<Format>),
}

/// An accuracy switch of a pipeline, with the values worth trying.
#[derive(Clone, Debug)]
pub(crate) struct Switch {
    /// The node's place in the graph.
    pub(crate) node: usize,
    pub(crate) turns: Turns,
    /// `node.parameter`, as tiers and `--set` name it.
    pub(crate) key: String,
    /// The most exact first.
    pub(crate) choices: Vec<Choice>,
    /// What the file chooses.
    pub(crate) written: Choice,
}

impl Choice {
    /// The value as a pipeline file has it; `None` for a format that is left to the node.
    pub(crate) fn text(&self) -> Option<String> {
        match self {
            Self::Value(value) => Some(value.to_string()),
            Self::Format(format) => format.map(|format| format.name().to_owned()),
        }
    }
}

impl Switch {
    /// Leaves only the choices at these places.
    pub(crate) fn keep(&mut self, places: &[usize]) {
        self.choices = places.iter().map(|at| self.choices[*at].clone()).collect();
    }

    /// Turns it in a graph.
    pub(crate) fn turn(&self, graph: &mut Graph, choice: usize) {
        let node = &mut graph.nodes[self.node];
        match (self.turns, &self.choices[choice]) {
            (Turns::Parameter(at), Choice::Value(value)) => node.values[at] = value.clone(),
            (Turns::Format, Choice::Format(format)) => node.format = *format,
            _ => unreachable!("a switch has choices of its own kind"),
        }
    }
}

/// All switches of a graph, in the order of its nodes and their parameters; a node's format comes last.
pub(crate) fn switches(graph: &Graph) -> Vec<Switch> {
    let mut all = Vec::new();
    for (index, node) in graph.nodes.iter().enumerate().filter(|(_, node)| !node.off) {
        all.extend(parameter_switches(index, node));
        all.extend(format_switch(graph, index));
    }
    all
}

fn parameter_switches(index: usize, node: &GraphNode) -> impl Iterator<Item = Switch> + '_ {
    node.kind.params().iter().enumerate().filter_map(move |(at, param)| {
        let quality = param.quality.as_ref()?;
        let mut values = vec![quality.exact.clone()];
        values.extend(quality.cheaper.iter().cloned());
        let written = node.values[at].clone();
        // A value that the table does not list stands between those it lists, for all that is known.
        if !values.contains(&written) {
            values.insert(1, written.clone());
        }
        let choices = values.into_iter().map(Choice::Value).collect();
        let key = format!("{}.{}", node.name, param.name);
        Some(Switch { node: index, turns: Turns::Parameter(at), key, choices, written: Choice::Value(written) })
    })
}

/// The format switch of a node whose images stay inside the pipeline.
fn format_switch(graph: &Graph, index: usize) -> Option<Switch> {
    let node = &graph.nodes[index];
    let makes_images = node.kind.outputs().iter().any(|port| matches!(port.ty, PortType::Image | PortType::Pyramid));
    let leaves = |output: &afterimage_graph::check::GraphOutput| match output.source {
        afterimage_graph::check::Source::Node { node, .. } => node == index,
        afterimage_graph::check::Source::Input(_) => false,
    };
    // An unsigned format without alpha cannot hold what is not light, and an encoded signal goes out as it is.
    let is_light =
        |state: &ColorState| matches!(state, ColorState::Scene | ColorState::Exposed | ColorState::DisplayLinear);
    let all_light = node.states.iter().flatten().all(is_light);
    if !makes_images || !all_light || graph.outputs.iter().any(leaves) {
        return None;
    }
    let mut formats = vec![Some(Format::Rgba16Float), Some(Format::Rg11b10Ufloat)];
    if !formats.contains(&node.format) {
        formats.insert(0, node.format);
    }
    let choices = formats.into_iter().map(Choice::Format).collect();
    let written = Choice::Format(node.format);
    Some(Switch { node: index, turns: Turns::Format, key: format!("{}.format", node.name), choices, written })
}

/// The entries of a tier that makes one graph of another: `"node.parameter": value`. Both have the same nodes and wires.
pub(crate) fn changes(from: &Graph, to: &Graph) -> Vec<String> {
    from.nodes.iter().zip(&to.nodes).flat_map(|(from, to)| node_changes(from, to)).collect()
}

fn node_changes(from: &GraphNode, to: &GraphNode) -> Vec<String> {
    let mut all = Vec::new();
    if from.off != to.off {
        all.push(format!("{:?}: {}", to.name, if to.off { "Off" } else { "On" }));
    }
    let mut set = |name: &str, value: Option<String>| {
        all.extend(value.map(|value| format!("{:?}: {value}", format!("{}.{name}", to.name))));
    };
    for ((before, after), param) in from.values.iter().zip(&to.values).zip(to.kind.params()) {
        set(&param.name, (before != after).then(|| after.to_string()));
    }
    if from.when != to.when {
        set("when", to.when.as_ref().map(|when| format!("{:?}", when.to_string())));
    }
    if from.format != to.format {
        set("format", to.format.map(|format| format.name().to_owned()));
    }
    if from.label != to.label {
        set("label", to.label.as_ref().map(|label| format!("{label:?}")));
    }
    all
}

/// The graph with every quality switch at its most exact. The planner's option `exact` does the formats.
pub(crate) fn most_exact(graph: &Graph) -> Result<Graph, Failure> {
    let mut exact = graph.clone();
    for switch in switches(graph).iter().filter(|switch| matches!(switch.turns, Turns::Parameter(_))) {
        switch.turn(&mut exact, 0);
    }
    verify(&exact).map_err(|why| Failure::user(format!("the most exact values do not go together: {why}")))?;
    Ok(exact)
}

/// Whether the values of each node go together.
pub(crate) fn verify(graph: &Graph) -> Result<(), String> {
    graph
        .nodes
        .iter()
        .try_for_each(|node| node.kind.verify(&node.values).map_err(|why| format!("`{}`: {why}", node.name)))
}

/// The truth, the file as it is, its tiers, and each switch turned on its own.
pub(crate) fn variants(
    path: &Path,
    registry: &Registry,
    options: &PipelineOptions,
    written: &Graph,
) -> Result<Vec<Variant>, Failure> {
    let variant = |name: &str, kind, graph| Variant { name: name.to_owned(), kind, graph };
    let name = options.tier.as_ref().map_or("as written".to_owned(), |tier| format!("as written, tier {tier}"));
    let mut all = vec![
        variant("truth", VariantKind::Truth, most_exact(written)?),
        variant(&name, VariantKind::Written, written.clone()),
    ];
    for tier in tier_names(path)? {
        let options = PipelineOptions { tier: Some(tier.clone()), ..options.clone() };
        let (graph, _) = check_file(path, registry, &options)?;
        all.push(variant(&format!("tier {tier}"), VariantKind::Tier, graph));
    }
    let (parameters, formats): (Vec<_>, Vec<_>) =
        switches(written).into_iter().partition(|switch| matches!(switch.turns, Turns::Parameter(_)));
    for (kind, switches) in [(VariantKind::Switch, parameters), (VariantKind::Format, formats)] {
        all.extend(switches.iter().flat_map(|switch| turned(switch, kind, written)));
    }
    Ok(all)
}

/// The variants that one switch makes: each of its values but the written one, if it goes with the others.
fn turned(switch: &Switch, kind: VariantKind, written: &Graph) -> Vec<Variant> {
    let others = switch.choices.iter().enumerate().filter(|(_, choice)| **choice != switch.written);
    let variant = |(at, choice): (usize, &Choice)| {
        let mut graph = written.clone();
        switch.turn(&mut graph, at);
        verify(&graph).ok()?;
        Some(Variant { name: format!("{}={}", switch.key, choice.text()?), kind, graph })
    };
    others.filter_map(variant).collect()
}
