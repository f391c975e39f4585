//! Warnings about tone curves of light that is multiplied by alpha.

use super::draft::DraftGraph;
use super::reports::Reports;
use super::{Graph, GraphNode, Source};
use afterimage_base::diagnostic::{Diagnostic, quote};
use afterimage_base::image::ColorState;

/// The kind whose results are the colors of things whatever their coverage is, and the kind that undoes it.
const STRAIGHT: &str = "Unpremultiply";
const COVERED: &str = "Premultiply";

impl DraftGraph {
    /// Warns of outputs whose alpha is coverage, after a tone curve of light that is multiplied by it: the curve is not
    /// linear, so half of a color becomes more than half of its result.
    pub(super) fn report_covered_curves(&self, graph: &Graph, reports: &mut Reports) {
        for output in graph.outputs.iter().filter(|output| output.has_coverage) {
            let own = self.outputs.iter().find(|(entry, _)| entry.name.value == output.name);
            let Some(((entry, _), curve)) = own.zip(covered_curve(graph, output.source)) else { continue };
            let message = format!("the tone curve {} gets light that is multiplied by alpha", quote(&curve.name));
            let help = format!(
                "put a node {} before it and {} after it: what is half covered then has the color of the whole",
                quote(STRAIGHT),
                quote(COVERED)
            );
            reports.push(Diagnostic::warning("covered-curve", message).at(&entry.name.location, "").help(help));
        }
    }
}

/// The last tone curve of light multiplied by alpha that an image comes from.
fn covered_curve(graph: &Graph, source: Source) -> Option<&GraphNode> {
    let is_straight = |node: &&GraphNode| [STRAIGHT, COVERED].contains(&node.kind().name());
    let curve = along_first_inputs(graph, source).find(|node| is_curve(node))?;
    let before = along_first_inputs(graph, curve.wires[0]?).find(is_straight);
    before.is_none_or(|node| node.kind().name() == COVERED).then_some(curve)
}

/// The node of an image, that of its first input, and so on.
fn along_first_inputs(graph: &Graph, source: Source) -> impl Iterator<Item = &GraphNode> {
    let node =
        |source: Source| if let Source::Node { node, previous: 0, .. } = source { graph.nodes.get(node) } else { None };
    std::iter::successors(node(source), move |found| node((*found.wires.first()?)?))
}

/// True for what makes light of a display from exposed light.
fn is_curve(node: &GraphNode) -> bool {
    let accepts = node.kind().inputs().first().map(|input| &*input.states);
    accepts == Some(&[ColorState::Exposed]) && node.states.first() == Some(&Some(ColorState::DisplayLinear))
}
