//! Step 2: what no output and no history needs does not run.

use std::collections::BTreeSet;

use crate::specialize::{Skipped, SpecializedGraph, WireSource};
use crate::{PlanBuilder, PlanError};
use afterimage_graph::check::{Graph, Source};
use afterimage_graph::node::{BufferLife, Resource};

/// Which nodes and which of their outputs somebody needs.
pub(crate) struct LiveNodes {
    /// For each node and output port.
    pub(crate) wanted: Vec<Vec<bool>>,
    pub(crate) skipped: Vec<Skipped>,
}

impl LiveNodes {
    /// Whether any output of the node is wanted.
    pub(crate) fn node(&self, index: usize) -> bool {
        self.wanted[index].iter().any(|wanted| *wanted)
    }
}

pub(crate) fn cull(graph: &Graph, special: &SpecializedGraph) -> Result<LiveNodes, PlanError> {
    let mut wanted: Vec<Vec<bool>> = graph.nodes.iter().map(|n| vec![false; n.kind.outputs().len()]).collect();
    let mut stack = Vec::new();
    for output in &graph.outputs {
        match special.resolve(Some(output.source)) {
            WireSource::From(Source::Node { node, output, .. }) => stack.push((node, output)),
            WireSource::From(Source::Input(_)) | WireSource::Zero => {}
            WireSource::Absent => return Err(PlanError::NothingToShow(output.name.clone())),
        }
    }
    while let Some((node, output)) = stack.pop() {
        let first_visit = !wanted[node].iter().any(|wanted| *wanted);
        wanted[node][output] = true;
        if !first_visit {
            continue;
        }
        for wire in &graph.nodes[node].wires {
            if let WireSource::From(Source::Node { node, output, .. }) = special.resolve(*wire) {
                stack.push((node, output));
            }
        }
    }
    let unread = |(index, _): &(usize, _)| special.runs[*index] && !wanted[*index].iter().any(|w| *w);
    let skipped = graph
        .nodes
        .iter()
        .enumerate()
        .filter(unread)
        .map(|(_, node)| Skipped { node: node.name.clone(), why: "nobody needs it".into() });
    Ok(LiveNodes { skipped: skipped.collect(), wanted })
}

/// Takes out passes that write nothing which is read later, remembered or shown: a node may record more than its present readers need.
pub(crate) fn prune(draft: &mut PlanBuilder) {
    let kept = draft.kept();
    let buffers = &draft.recording.buffers;
    let mut read: BTreeSet<Resource> = BTreeSet::new();
    let mut needed = Vec::new();
    for pass in draft.recording.passes.iter().rev() {
        let matters = |resource: &Resource| match resource {
            Resource::Image(image) => read.contains(resource) || kept.contains(image),
            Resource::Buffer(buffer) => {
                read.contains(resource) || buffers[buffer.0 as usize].life == BufferLife::Persistent
            }
        };
        let matters = pass.writes().iter().any(matters);
        needed.push(matters);
        if matters {
            read.extend(pass.reads());
        }
    }
    draft.recording.passes.retain(|_| needed.pop().unwrap_or(true));
}
