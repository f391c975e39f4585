//! The reference of a pipeline, and the variants that are compared with it.

use afterimage_graph::check::{Graph, GraphOutput, Source};
use afterimage_graph::image::{ColorState, Format};
use afterimage_graph::node::{Bake, PortType};
use afterimage_graph::value::Value;

use super::node_change::NodeChange;
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

/// A quality switch of a pipeline, with the values to try.
#[derive(Clone, Debug)]
pub(crate) struct Switch {
    /// The index of the node in the graph.
    pub(crate) node: usize,
    /// `node.parameter`, as tiers and `--set` name it.
    pub(crate) key: String,
    /// The values of one field of the node; the most accurate first.
    pub(crate) choices: Vec<NodeChange>,
    /// The value in the file.
    pub(crate) written: NodeChange,
}

impl Switch {
    /// A switch of the node at an index, which has the written value.
    fn new(graph: &Graph, node: usize, choices: Vec<NodeChange>, written: NodeChange) -> Self {
        Self { node, key: written.key(&graph.nodes[node]), choices, written }
    }

    /// Keeps only the choices at these indices.
    pub(crate) fn keep(&mut self, indices: &[usize]) {
        self.choices = indices.iter().map(|at| self.choices[*at].clone()).collect();
    }

    /// Sets it in a graph.
    pub(crate) fn apply(&self, graph: &mut Graph, choice: usize) {
        self.choices[choice].apply(&mut graph.nodes[self.node]);
    }

    /// True if it is the format of the node's results.
    pub(crate) fn is_format(&self) -> bool {
        matches!(self.written, NodeChange::Format(_))
    }
}

/// All switches of a graph, in the order of its nodes and their parameters; a node's format comes last.
pub(crate) fn switches(graph: &Graph) -> Vec<Switch> {
    let mut all = Vec::new();
    for (index, node) in graph.nodes.iter().enumerate().filter(|(_, node)| !node.off) {
        all.extend(parameter_switches(graph, index));
        // Of nodes that the file does not run in every frame, and of those that it makes a table of.
        all.extend((node.every > 1).then(|| frame_switch(graph, index)));
        all.extend(node.bake.map(|bake| table_switch(graph, index, bake)));
        all.extend(format_switch(graph, index));
    }
    all
}

fn parameter_switches(graph: &Graph, index: usize) -> impl Iterator<Item = Switch> + '_ {
    let node = &graph.nodes[index];
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
        let choices = values.into_iter().map(|value| NodeChange::Value(at, value)).collect();
        Some(Switch::new(graph, index, choices, NodeChange::Value(at, written)))
    })
}

fn frame_switch(graph: &Graph, index: usize) -> Switch {
    let written = NodeChange::Every(graph.nodes[index].every);
    Switch::new(graph, index, vec![NodeChange::Every(1), written.clone()], written)
}

fn table_switch(graph: &Graph, index: usize, bake: Bake) -> Switch {
    let written = NodeChange::Bake(Some(bake));
    let known = [Bake::Off, Bake::Auto, Bake::Size(48), Bake::Size(33)];
    let mut choices = known.map(|bake| NodeChange::Bake(Some(bake))).to_vec();
    if !choices.contains(&written) {
        choices.insert(1, written.clone());
    }
    Switch::new(graph, index, choices, written)
}

/// The format switch of a node whose images are not outputs.
fn format_switch(graph: &Graph, index: usize) -> Option<Switch> {
    let node = &graph.nodes[index];
    let makes_images = node.kind().outputs().iter().any(|port| matches!(port.ty, PortType::Image | PortType::Pyramid));
    let is_result = |output: &GraphOutput| matches!(output.source, Source::Node { node, .. } if node == index);
    let are_all = |known: &[ColorState]| node.states.iter().flatten().all(|state| known.contains(state));
    if !makes_images || graph.outputs.iter().any(is_result) {
        return None;
    }
    let mut formats = vec![Some(Format::Rgba16Float)];
    // Errors are those of colors, so nothing would tell that alpha is lost.
    let needs_alpha = graph.outputs.iter().any(|output| output.has_coverage);
    // Codes end at 1, which is white on an SDR display. The light of a scene and numbers that are no colors do not.
    let ends_at_white = are_all(&[ColorState::DisplayLinear, ColorState::Encoded]);
    if ends_at_white && !needs_alpha {
        formats.push(Some(Format::Rgb10a2Unorm));
    }
    // The packed floats are unsigned: they hold linear color only.
    if are_all(&[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear]) && !needs_alpha {
        formats.push(Some(Format::Rg11b10Ufloat));
    }
    if ends_at_white {
        formats.push(Some(Format::Rgba8Unorm));
    }
    if formats.len() == 1 {
        return None;
    }
    if !formats.contains(&node.format) {
        formats.insert(0, node.format);
    }
    let choices = formats.into_iter().map(NodeChange::Format).collect();
    Some(Switch::new(graph, index, choices, NodeChange::Format(node.format)))
}

/// The graph with every quality switch at its most accurate. Formats are the planner's option `exact`.
pub(crate) fn most_accurate(graph: &Graph) -> Result<Graph, LabError> {
    let mut exact = graph.clone();
    for switch in switches(graph).iter().filter(|switch| matches!(switch.written, NodeChange::Value(..))) {
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
    let (formats, parameters): (Vec<_>, Vec<_>) = switches(written).into_iter().partition(Switch::is_format);
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
