//! Nodes that no output and no history needs do not run.

use super::wires::{SpecializedGraph, WireSource};
use crate::error::PlanError;
use crate::plan::Skipped;
use afterimage_graph::check::{Graph, Source};

/// Marks the outputs that are needed, and skips the nodes without any.
pub(super) fn mark_used_outputs(graph: &Graph, specialized: &mut SpecializedGraph) -> Result<(), PlanError> {
    let mut used_outputs: Vec<Vec<bool>> = graph.nodes.iter().map(|n| vec![false; n.kind().outputs().len()]).collect();
    let mut stack = shown(graph, specialized)?;
    while let Some((node, output)) = stack.pop() {
        let first_visit = !used_outputs[node].iter().any(|used| *used);
        used_outputs[node][output] = true;
        if !first_visit {
            continue;
        }
        for wire in &graph.nodes[node].wires {
            if let WireSource::From(Source::Node { node, output, .. }) = specialized.resolve(*wire) {
                stack.push((node, output));
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
