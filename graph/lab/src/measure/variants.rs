//! The reference of a pipeline, and the variants that are compared with it.

use afterimage_graph::check::{Graph, GraphNode};
use afterimage_graph::image::{ColorState, Format};
use afterimage_graph::node::{Bake, PortType};
use afterimage_graph::value::Value;

use crate::LabError;

/// A pipeline to measure, as its file is.
#[derive(Clone, Debug)]
pub struct Pipeline {
    pub name: String,
    /// The graph as written, or at the chosen tier.
    pub written: Graph,
    pub tier: Option<String>,
    /// The other tiers of the file.
    pub tiers: Vec<(String, Graph)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariantKind {
    /// The variant that all others are compared with.
    Reference,
    /// The file as it is.
    Written,
    /// A tier of the file.
    Tier,
    /// One quality switch has another value.
    Switch,
    /// One node's results have another format.
    Format,
}

impl VariantKind {
    /// True if the variant changes one switch or format.
    pub(crate) fn is_switch(self) -> bool {
        matches!(self, Self::Switch | Self::Format)
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Written => "written",
            Self::Tier => "tier",
            Self::Switch => "switch",
            Self::Format => "format",
        }
    }
}

/// One configuration of a pipeline.
#[derive(Clone, Debug)]
pub(crate) struct Variant {
    /// The name in reports: `tier low`, or `mips.filter=Tap9`, as `--set` takes it.
    pub(crate) name: String,
    pub(crate) kind: VariantKind,
    pub(crate) graph: Graph,
}

impl Variant {
    /// True if intermediates are stored in 32 bits.
    pub(crate) fn is_exact(&self) -> bool {
        self.kind == VariantKind::Reference
    }
}

/// The part of a node that a switch changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SwitchTarget {
    /// A parameter, by its index among the node's values.
    Parameter(usize),
    /// The format of the node's results.
    Format,
    /// In one of how many frames the node runs.
    Every,
    /// The table that the node becomes.
    Bake,
}

/// A value that a switch can have.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SwitchValue {
    Value(Value),
    /// Of the format; `None` is the format that the node chooses.
    Format(Option<Format>),
    Every(u32),
    Bake(Bake),
}

/// A quality switch of a pipeline, with the values to try.
#[derive(Clone, Debug)]
pub(crate) struct Switch {
    /// The index of the node in the graph.
    pub(crate) node: usize,
    pub(crate) target: SwitchTarget,
    /// `node.parameter`, as tiers and `--set` name it.
    pub(crate) key: String,
    /// The most accurate first.
    pub(crate) choices: Vec<SwitchValue>,
    /// The value in the file.
    pub(crate) written: SwitchValue,
}

impl SwitchValue {
    /// The value as in a pipeline file; `None` for the format that the node chooses.
    pub(crate) fn text(&self) -> Option<String> {
        match self {
            Self::Value(value) => Some(value.to_string()),
            Self::Format(format) => format.map(|format| format.name().to_owned()),
            Self::Every(every) => Some(every.to_string()),
            Self::Bake(bake) => Some(bake.to_string()),
        }
    }
}

impl Switch {
    /// Keeps only the choices at these indices.
    pub(crate) fn keep(&mut self, indices: &[usize]) {
        self.choices = indices.iter().map(|at| self.choices[*at].clone()).collect();
    }

    /// Sets it in a graph.
    pub(crate) fn apply(&self, graph: &mut Graph, choice: usize) {
        let node = &mut graph.nodes[self.node];
        match (self.target, &self.choices[choice]) {
            (SwitchTarget::Parameter(at), SwitchValue::Value(value)) => drop(node.instance.set(at, value.clone())),
            (SwitchTarget::Format, SwitchValue::Format(format)) => node.format = *format,
            (SwitchTarget::Every, SwitchValue::Every(every)) => node.every = *every,
            (SwitchTarget::Bake, SwitchValue::Bake(bake)) => node.bake = Some(*bake),
            _ => unreachable!("the choices of a switch are of its target"),
        }
    }
}

/// All switches of a graph, in the order of its nodes and their parameters; a node's format comes last.
pub(crate) fn switches(graph: &Graph) -> Vec<Switch> {
    let mut all = Vec::new();
    for (index, node) in graph.nodes.iter().enumerate().filter(|(_, node)| !node.off) {
        all.extend(parameter_switches(index, node));
        all.extend(frame_switch(index, node));
        all.extend(table_switch(index, node));
        all.extend(format_switch(graph, index));
    }
    all
}

fn parameter_switches(index: usize, node: &GraphNode) -> impl Iterator<Item = Switch> + '_ {
    node.kind().params().iter().enumerate().filter_map(move |(at, param)| {
        let quality = param.quality.as_ref()?;
        let mut values = vec![quality.exact.clone()];
        values.extend(quality.cheaper.iter().cloned());
        let written = node.instance.values()[at].clone();
        // A choice that the kind does not list is another picture, which errors are measured against. A number is
        // assumed to be between the most accurate and the cheaper ones.
        if !values.contains(&written) {
            let is_choice = matches!(written, Value::Choice(_));
            values.insert(usize::from(!is_choice), written.clone());
        }
        let choices = values.into_iter().map(SwitchValue::Value).collect();
        let key = format!("{}.{}", node.name, param.name);
        Some(Switch {
            node: index,
            target: SwitchTarget::Parameter(at),
            key,
            choices,
            written: SwitchValue::Value(written),
        })
    })
}

/// The switch of a node that the file does not run in every frame.
fn frame_switch(index: usize, node: &GraphNode) -> Option<Switch> {
    let written = SwitchValue::Every(node.every);
    (node.every > 1).then(|| Switch {
        node: index,
        target: SwitchTarget::Every,
        key: format!("{}.every", node.name),
        choices: vec![SwitchValue::Every(1), written.clone()],
        written,
    })
}

/// The switch of a node that the file makes a table of.
fn table_switch(index: usize, node: &GraphNode) -> Option<Switch> {
    let written = SwitchValue::Bake(node.bake?);
    let mut choices = [Bake::Off, Bake::Auto, Bake::Size(48), Bake::Size(33)].map(SwitchValue::Bake).to_vec();
    if !choices.contains(&written) {
        choices.insert(1, written.clone());
    }
    Some(Switch { node: index, target: SwitchTarget::Bake, key: format!("{}.bake", node.name), choices, written })
}

/// The format switch of a node whose images are not outputs.
fn format_switch(graph: &Graph, index: usize) -> Option<Switch> {
    let node = &graph.nodes[index];
    let makes_images = node.kind().outputs().iter().any(|port| matches!(port.ty, PortType::Image | PortType::Pyramid));
    let is_result = |output: &afterimage_graph::check::GraphOutput| match output.source {
        afterimage_graph::check::Source::Node { node, .. } => node == index,
        afterimage_graph::check::Source::Input(_) => false,
    };
    // The packed format is unsigned and has no alpha: it holds linear color only.
    let is_linear =
        |state: &ColorState| matches!(state, ColorState::Scene | ColorState::Exposed | ColorState::DisplayLinear);
    let are_all_linear = node.states.iter().flatten().all(is_linear);
    if !makes_images || !are_all_linear || graph.outputs.iter().any(is_result) {
        return None;
    }
    let mut formats = vec![Some(Format::Rgba16Float), Some(Format::Rg11b10Ufloat)];
    if !formats.contains(&node.format) {
        formats.insert(0, node.format);
    }
    let choices = formats.into_iter().map(SwitchValue::Format).collect();
    let written = SwitchValue::Format(node.format);
    Some(Switch { node: index, target: SwitchTarget::Format, key: format!("{}.format", node.name), choices, written })
}

/// The entries of a tier that turns `from` into `to`: `"node.parameter": value`. Both graphs have the same nodes and
/// wires.
pub fn changes(from: &Graph, to: &Graph) -> Vec<String> {
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
    for ((before, after), param) in from.instance.values().iter().zip(to.instance.values()).zip(to.kind().params()) {
        set(&param.name, (before != after).then(|| after.to_string()));
    }
    if from.when != to.when {
        set("when", to.when.as_ref().map(|when| format!("{:?}", when.to_string())));
    }
    if from.format != to.format {
        set("format", to.format.map(|format| format.name().to_owned()));
    }
    if from.bake != to.bake {
        set("bake", to.bake.map(|bake| bake.to_string()));
    }
    if from.every != to.every {
        set("every", Some(to.every.to_string()));
    }
    if from.label != to.label {
        set("label", to.label.as_ref().map(|label| format!("{label:?}")));
    }
    all
}

/// Copies of `from`, each with one of the changes that turn it into `to`. A change that is not valid without
/// others has none.
pub(crate) fn single_changes(from: &Graph, to: &Graph) -> Vec<Graph> {
    let mut all = Vec::new();
    for (index, (before, after)) in from.nodes.iter().zip(&to.nodes).enumerate() {
        let mut change = |set: &dyn Fn(&mut GraphNode)| {
            let mut graph = from.clone();
            set(&mut graph.nodes[index]);
            if graph.nodes[index].instance.verify().is_ok() && !changes(from, &graph).is_empty() {
                all.push(graph);
            }
        };
        for (at, value) in after.instance.values().iter().enumerate() {
            if before.instance.values()[at] != *value {
                change(&|node| drop(node.instance.set(at, value.clone())));
            }
        }
        change(&|node| node.off = after.off);
        change(&|node| node.when.clone_from(&after.when));
        change(&|node| node.format = after.format);
        change(&|node| node.bake = after.bake);
        change(&|node| node.every = after.every);
    }
    all
}

/// The graph with every quality switch at its most accurate. Formats are the planner's option `exact`.
pub(crate) fn most_accurate(graph: &Graph) -> Result<Graph, LabError> {
    let mut exact = graph.clone();
    for switch in switches(graph).iter().filter(|switch| matches!(switch.target, SwitchTarget::Parameter(_))) {
        switch.apply(&mut exact, 0);
    }
    verify(&exact)
        .map_err(|why| LabError::request(format!("the most accurate values are not valid together: {why}")))?;
    Ok(exact)
}

/// Checks that the values of each node are valid together.
pub(crate) fn verify(graph: &Graph) -> Result<(), String> {
    graph.nodes.iter().try_for_each(|node| node.instance.verify().map_err(|why| format!("`{}`: {why}", node.name)))
}

/// The reference, the file as it is, its tiers, and each switch changed on its own.
pub(crate) fn variants(pipeline: &Pipeline) -> Result<Vec<Variant>, LabError> {
    let Pipeline { written, tier, tiers, .. } = pipeline;
    let variant = |name: &str, kind, graph| Variant { name: name.to_owned(), kind, graph };
    let name = tier.as_ref().map_or("as written".to_owned(), |tier| format!("as written, tier {tier}"));
    let mut all = vec![
        variant("reference", VariantKind::Reference, most_accurate(written)?),
        variant(&name, VariantKind::Written, written.clone()),
    ];
    let tiers = tiers.iter().map(|(tier, graph)| variant(&format!("tier {tier}"), VariantKind::Tier, graph.clone()));
    all.extend(tiers);
    let (parameters, formats): (Vec<_>, Vec<_>) =
        switches(written).into_iter().partition(|switch| switch.target != SwitchTarget::Format);
    for (kind, switches) in [(VariantKind::Switch, parameters), (VariantKind::Format, formats)] {
        all.extend(switches.iter().flat_map(|switch| switched(switch, kind, written)));
    }
    Ok(all)
}

/// The variants of one switch: each valid value except the written one.
fn switched(switch: &Switch, kind: VariantKind, written: &Graph) -> Vec<Variant> {
    let others = switch.choices.iter().enumerate().filter(|(_, choice)| **choice != switch.written);
    let mut variants = Vec::new();
    for (index, choice) in others {
        let mut graph = written.clone();
        switch.apply(&mut graph, index);
        if let (Ok(()), Some(text)) = (verify(&graph), choice.text()) {
            variants.push(Variant { name: format!("{}={text}", switch.key), kind, graph });
        }
    }
    variants
}
