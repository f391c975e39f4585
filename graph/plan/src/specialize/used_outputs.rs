//! Nodes that no output and no history needs do not run.

use super::specialized_graph::{SpecializedGraph, WireSource};
use crate::error::PlanError;
use crate::plan::Skipped;
use afterimage_graph::check::{Graph, Source};
use afterimage_graph::node::OutputUse;

/// Marks the outputs that are needed, and skips the nodes without any.
pub(super) fn mark_used_outputs(graph: &Graph, specialized: &mut SpecializedGraph) -> Result<(), PlanError> {
    let nodes = graph.nodes.iter();
    let mut used_outputs: Vec<_> = nodes.map(|n| vec![OutputUse::Unused; n.kind().outputs().len()]).collect();
    let mut stack: Vec<_> =
        shown(graph, specialized)?.into_iter().map(|(node, output)| (node, output, OutputUse::Whole)).collect();
    while let Some((node, output, how)) = stack.pop() {
        let first_visit = used_outputs[node].iter().all(|used| *used == OutputUse::Unused);
        used_outputs[node][output] = used_outputs[node][output].max(how);
        if !first_visit {
            continue;
        }
        for (port, wire) in graph.nodes[node].kind().inputs().iter().zip(&graph.nodes[node].wires) {
            if let WireSource::From(Source::Node { node, output, .. }) = specialized.resolve(*wire) {
                stack.push((node, output, if port.only_x { OutputUse::OnlyX } else { OutputUse::Whole }));
            }
        }
    }
    specialized.used_outputs = used_outputs;
    for (index, node) in graph.nodes.iter().enumerate() {
        if specialized.runs[index] && !specialized.is_live(index) {
            specialized.skipped.push(Skipped { node: node.name.clone(), why: "nobody needs it".into() });
        }
    }
    Ok(())
}

/// The nodes and ports that the outputs of the pipeline show.
fn shown(graph: &Graph, specialized: &SpecializedGraph) -> Result<Vec<(usize, usize)>, PlanError> {
    let mut shown = Vec::new();
    for output in &graph.outputs {
        match specialized.resolve(Some(output.source)) {
            WireSource::From(Source::Node { node, output, .. }) => shown.push((node, output)),
            WireSource::From(Source::Input(_)) | WireSource::Zero => {}
            WireSource::Absent => return Err(PlanError::NothingToShow(output.name.clone())),
        }
    }
    Ok(shown)
}
