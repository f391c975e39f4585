//! State of a check: the graph so far, changes that wait, and diagnostics.

use std::collections::BTreeMap;

use super::draft::DraftGraph;
use super::files::Files;
use super::inherit::UsedFiles;
use super::reports::Reports;
use super::{FactKind, Graph, GraphInput};
use crate::document::Override;
use crate::node::{NodeInstance, Registry};
use afterimage_base::diagnostic::{Diagnostic, Diagnostics, Location};

pub(super) struct GraphBuilder<'a> {
    pub(super) registry: &'a Registry,
    pub(super) used: UsedFiles<'a>,
    pub(super) reports: Reports,
    pub(super) drafted: DraftGraph,
    pub(super) changes: Vec<Change>,
    pub(super) facts: BTreeMap<String, (FactKind, Location)>,
    pub(super) tier: Option<String>,
}

/// Changes to nodes, waiting until all nodes are known.
pub(super) struct Change {
    pub(super) scope: usize,
    pub(super) settings: Vec<Override>,
    /// The tier that they belong to, if they do; those of other tiers than the requested one are only checked.
    pub(super) tier: Option<String>,
}

impl<'a> GraphBuilder<'a> {
    pub(super) fn new(registry: &'a Registry, files: &'a Files<'a>, diagnostics: Diagnostics) -> Self {
        Self {
            registry,
            used: UsedFiles::new(files),
            reports: Reports::new(diagnostics),
            drafted: DraftGraph::default(),
            changes: Vec::new(),
            facts: BTreeMap::new(),
            tier: None,
        }
    }

    pub(super) fn report(&mut self, diagnostic: Diagnostic) {
        self.reports.push(diagnostic);
    }

    /// The graph, if there are no errors.
    pub(super) fn graph(&self, instances: Vec<NodeInstance>) -> Graph {
        let inputs = self.drafted.host_inputs().map(|input| GraphInput {
            name: input.name.value.clone(),
            block: input.block.as_ref().and_then(|name| self.registry.block(&name.value)),
            state: input.state,
            min_channels: input.min_channels,
            optional: input.optional,
            multisampled: input.multisampled,
            volume: input.volume,
            needs_alpha: input.needs_alpha,
            scale: input.scale,
        });
        Graph {
            inputs: inputs.collect(),
            nodes: self
                .drafted
                .nodes
                .iter()
                .zip(instances)
                .map(|(draft, instance)| self.drafted.graph_node(draft, instance))
                .collect(),
            outputs: self
                .drafted
                .outputs
                .iter()
                .filter_map(|(output, wire)| self.drafted.graph_output(output, wire.as_ref()?))
                .collect(),
            wires: self.drafted.same_frame(),
        }
    }
}
