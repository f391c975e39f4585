//! The uniforms of nodes whose parameters have changed since the plan was loaded.

use std::ops::Range;

use afterimage_graph::check::Graph;
use afterimage_plan::{DynamicNodes, NeedsPlan, Plan};

/// A copy of the plan's uniform buffer, and what the device does not have yet.
pub(super) struct Uniforms {
    pub(super) bytes: Vec<u8>,
    /// Nodes at other values than their bytes.
    changed: Vec<usize>,
    /// Bytes that the device lacks.
    pub(super) unwritten: Option<Range<usize>>,
}

impl Uniforms {
    /// Those of a plan at the values of a graph, for the nodes that may have others than when it was made. Where they
    /// need another plan, the first frame finds it again.
    pub(super) fn at(plan: &Plan, dynamic: &mut DynamicNodes, graph: &Graph, changed: Vec<usize>) -> Self {
        let mut uniforms = Self { bytes: plan.uniform_buffer(), changed, unwritten: None };
        let all = uniforms.changed.clone();
        if uniforms.update(dynamic, graph) == Err(NeedsPlan) {
            uniforms.changed = all;
        }
        uniforms.unwritten = None;
        uniforms
    }

    pub(super) fn change(&mut self, node: usize) {
        if !self.changed.contains(&node) {
            self.changed.push(node);
        }
    }

    /// Records the changed nodes again.
    pub(super) fn update(&mut self, nodes: &mut DynamicNodes, graph: &Graph) -> Result<(), NeedsPlan> {
        let Self { bytes, changed, unwritten } = self;
        let mut write = |offset: u64, new: &[u8]| {
            let place = offset as usize..offset as usize + new.len();
            if bytes[place.clone()] != *new {
                bytes[place.clone()].copy_from_slice(new);
                let before = unwritten.take().unwrap_or(place.clone());
                *unwritten = Some(before.start.min(place.start)..before.end.max(place.end));
            }
        };
        changed.drain(..).try_for_each(|node| nodes.uniforms(node, &graph.nodes[node].instance, &mut write))
    }
}
