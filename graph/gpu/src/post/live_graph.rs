//! A graph whose plan renders or will render, at the values that the host sets.

use std::sync::Arc;

use afterimage_graph::check::{Graph, ParameterId};
use afterimage_graph::value::Value;
use afterimage_plan::PlanCache;

use super::controls::{Controls, Entry};

/// A graph at the values that the host has set: the present one, or one before it whose plan still renders.
#[derive(Clone)]
pub(super) struct LiveGraph {
    /// Counts graphs: see [`Revision::graph`](super::plan_state::Revision::graph).
    pub(super) revision: u64,
    pub(super) plans: PlanCache,
    /// For each handle the parameter that it means here.
    targets: Vec<Target>,
    changes: NodeChanges,
}

/// The graph at the present values of its parameters.
#[derive(Clone, Copy)]
pub(super) struct GraphValues<'a> {
    pub(super) graph: &'a Graph,
    /// The revision of the graph: see [`Revision::graph`](super::plan_state::Revision::graph).
    pub(super) revision: u64,
    pub(super) changes: &'a NodeChanges,
}

/// What a handle means in a graph.
#[derive(Clone)]
enum Target {
    /// This parameter, and the value that it has in the file.
    Parameter(ParameterId, Value),
    /// The parameter of that name has another type: in words.
    OtherType(String),
    Missing,
}

/// A log of nodes whose values have changed. Each plan in use updates the uniforms of those that changed after the
/// version that it has.
#[derive(Clone, Default)]
pub(super) struct NodeChanges {
    version: u64,
    /// Each changed node, with the version of its last change, in that order.
    nodes: Vec<(usize, u64)>,
}

impl NodeChanges {
    pub(super) fn version(&self) -> u64 {
        self.version
    }

    /// The nodes that changed after a version.
    pub(super) fn since(&self, version: u64) -> &[(usize, u64)] {
        &self.nodes[self.nodes.partition_point(|(_, changed)| *changed <= version)..]
    }

    fn add(&mut self, node: usize) {
        self.version += 1;
        self.nodes.retain(|(known, _)| *known != node);
        self.nodes.push((node, self.version));
    }
}

impl LiveGraph {
    /// Finds the parameters of all handles in a graph, and sets what the host has set.
    pub(super) fn new(graph: Graph, revision: u64, controls: &Controls) -> Self {
        let plans = PlanCache::new(graph);
        let mut live = Self { revision, plans, targets: Vec::new(), changes: NodeChanges::default() };
        for (index, entry) in controls.entries().iter().enumerate() {
            live.targets.push(target(live.plans.graph(), entry));
            // A value that this graph refuses leaves that of its file.
            if let Some(value) = &entry.value {
                _ = live.set(index, value.clone());
            }
        }
        live
    }

    pub(super) fn graph(&self) -> &Graph {
        self.plans.graph()
    }

    pub(super) fn shared_graph(&self) -> Arc<Graph> {
        self.plans.shared_graph()
    }

    pub(super) fn changes(&self) -> &NodeChanges {
        &self.changes
    }

    pub(super) fn values(&self) -> GraphValues<'_> {
        GraphValues { graph: self.graph(), revision: self.revision, changes: &self.changes }
    }

    /// Adds the parameter of a new handle.
    pub(super) fn add(&mut self, entry: &Entry) {
        self.targets.push(target(self.graph(), entry));
    }

    /// The parameter that a handle means.
    pub(super) fn parameter(&self, index: usize) -> Option<ParameterId> {
        match self.targets.get(index)? {
            Target::Parameter(id, _) => Some(*id),
            Target::OtherType(_) | Target::Missing => None,
        }
    }

    /// The type in words of the parameter that has the name of a handle and another type.
    pub(super) fn other_type(&self, index: usize) -> Option<&str> {
        match self.targets.get(index)? {
            Target::OtherType(ty) => Some(ty),
            Target::Parameter(..) | Target::Missing => None,
        }
    }

    /// The handle of a parameter.
    pub(super) fn handle_of(&self, id: ParameterId) -> Option<usize> {
        (0..self.targets.len()).find(|index| self.parameter(*index) == Some(id))
    }

    /// The value of the file for a handle.
    pub(super) fn written(&self, index: usize) -> Option<&Value> {
        match self.targets.get(index)? {
            Target::Parameter(_, written) => Some(written),
            Target::OtherType(_) | Target::Missing => None,
        }
    }

    /// Sets a value, if the graph has the parameter. Returns whether the change needs a new plan.
    ///
    /// # Errors
    /// The graph refuses the value, for a reason in a sentence.
    pub(super) fn set(&mut self, index: usize, value: Value) -> Result<bool, String> {
        let Some(id) = self.parameter(index).filter(|id| *self.graph().value(*id) != value) else { return Ok(false) };
        let needs_plan = self.plans.set(id, value)?;
        if !needs_plan {
            self.changes.add(id.node);
        }
        Ok(needs_plan)
    }

    /// Sets a value in a graph that has been replaced, and whose plan still renders: that of the host, or else that of
    /// the file. Where it needs another plan or is refused, the old one stays until the next plan comes.
    pub(super) fn follow(&mut self, index: usize, value: Option<&Value>) {
        let is_dynamic = self.parameter(index).is_some_and(|id| !self.graph().declaration(id).replan);
        if let Some(value) = value.or(self.written(index)).filter(|_| is_dynamic).cloned() {
            _ = self.set(index, value);
        }
    }

    /// The parameters with handles whose changes need no plan.
    pub(super) fn dynamic(&self) -> impl Iterator<Item = ParameterId> {
        let ids = (0..self.targets.len()).filter_map(|index| self.parameter(index));
        ids.filter(|id| !self.graph().declaration(*id).replan)
    }

    /// Takes the values of a graph that differs from this one in values of dynamic parameters only. Returns `false` if
    /// it differs in more: then some values may be taken, and the graph must be replaced.
    pub(super) fn take_values(&mut self, graph: &Graph, controls: &Controls) -> bool {
        let present = self.graph();
        if !present.has_structure_of(graph) {
            return false;
        }
        let dynamic: Vec<ParameterId> = self.dynamic().collect();
        if graph.parameters().any(|id| !dynamic.contains(&id) && present.value(id) != graph.value(id)) {
            return false;
        }
        for (index, entry) in controls.entries().iter().enumerate() {
            let Target::Parameter(id, written) = &mut self.targets[index] else { continue };
            let value = graph.value(*id).clone();
            written.clone_from(&value);
            if entry.value.is_none() && self.set(index, value).is_err() {
                return false;
            }
        }
        true
    }
}

fn target(graph: &Graph, entry: &Entry) -> Target {
    match graph.parameter(&entry.name) {
        Ok(id) if graph.declaration(id).ty == entry.ty => Target::Parameter(id, graph.value(id).clone()),
        Ok(id) => Target::OtherType(graph.declaration(id).ty.describe()),
        Err(_) => Target::Missing,
    }
}
