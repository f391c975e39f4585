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
        let before = used_outputs[node].iter().copied().max().unwrap_or(OutputUse::Unused);
        used_outputs[node][output] = used_outputs[node][output].max(how);
        // What a node reads depends on whether it runs, and on whether a result is a mean.
        let is_averaged = how == OutputUse::Mean;
        if before == OutputUse::Mean || before != OutputUse::Unused && !is_averaged {
            continue;
        }
        let reader = &graph.nodes[node];
        for (port, wire) in reader.kind().inputs().iter().zip(&reader.wires) {
            if let WireSource::From(Source::Node { node, output, .. }) = specialized.resolve(*wire) {
                let how = match port.only_x {
                    true => OutputUse::OnlyX,
                    false if reader.instance.averages(&port.name, is_averaged) => OutputUse::Mean,
                    false => OutputUse::Whole,
                };
                stack.push((node, output, how));
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
