//! Parameters that the host changes while a plan renders.

use std::marker::PhantomData;

use afterimage_graph::check::{Graph, ParameterId};
use afterimage_graph::value::{Param, Type, Value};
use afterimage_plan::PlanCache;

use super::error::PostError;

/// A parameter that the host changes, with values of type `T`.
pub struct Parameter<T> {
    control: Control,
    value: PhantomData<fn(T)>,
}

impl<T> Clone for Parameter<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Parameter<T> {}

impl<T> Parameter<T> {
    pub(super) fn new(control: Control) -> Self {
        Self { control, value: PhantomData }
    }

    /// The same without its type, for code that treats all parameters alike.
    pub fn control(self) -> Control {
        self.control
    }
}

/// A parameter that the host changes, of any type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Control(usize);

/// A parameter of a graph.
#[derive(Clone, Debug)]
pub struct ParameterInfo<'p> {
    /// Its name, `node.parameter`.
    pub name: String,
    /// Its type, domain, unit, documentation and more. [`replan`](Param::replan) states whether a change needs a new
    /// plan.
    pub declaration: &'p Param,
    /// Its present value.
    pub value: &'p Value,
}

/// The parameters with handles, and the values that the host has set.
#[derive(Clone, Default)]
pub(super) struct Controls {
    entries: Vec<Entry>,
    /// The nodes of the present graph whose dynamic parameters have changed.
    pub(super) changes: NodeChanges,
}

#[derive(Clone)]
struct Entry {
    name: String,
    ty: Type,
    /// The value that the host has set.
    value: Option<Value>,
    /// The value of the present graph before the host has set one.
    written: Option<Value>,
    /// The parameter in the present graph, if it has one of that name and type.
    id: Option<ParameterId>,
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

impl Controls {
    /// The number of handles.
    pub(super) fn count(&self) -> usize {
        self.entries.len()
    }

    /// The handle of the parameter that `node.parameter` names.
    pub(super) fn control(&mut self, graph: &Graph, name: &str) -> Result<Control, PostError> {
        let id = graph.parameter(name).map_err(PostError::UnknownParameter)?;
        if let Some(known) = self.entries.iter().position(|entry| entry.id == Some(id)) {
            return Ok(Control(known));
        }
        let (ty, written) = (graph.declaration(id).ty, Some(graph.value(id).clone()));
        self.entries.push(Entry { name: name.to_owned(), ty, value: None, written, id: Some(id) });
        Ok(Control(self.entries.len() - 1))
    }

    /// Sets a value in the graph of the cache, if that has the parameter. Returns whether the change needs a new plan.
    pub(super) fn set(&mut self, plans: &mut PlanCache, control: Control, value: Value) -> Result<bool, PostError> {
        let entry = &mut self.entries[control.0];
        let mut needs_plan = false;
        if let Some(id) = entry.id
            && *plans.graph().value(id) != value
        {
            needs_plan =
                plans.set(id, value.clone()).map_err(|why| PostError::Refused { name: entry.name.clone(), why })?;
            if !needs_plan {
                self.changes.add(id.node);
            }
        }
        entry.value = Some(value);
        Ok(needs_plan)
    }

    /// Sets the value in the pipeline file. Returns whether the change needs a new plan.
    pub(super) fn unset(&mut self, plans: &mut PlanCache, control: Control) -> Result<bool, PostError> {
        let needs_plan = match self.entries[control.0].written.clone() {
            Some(written) => self.set(plans, control, written)?,
            None => false,
        };
        self.entries[control.0].value = None;
        Ok(needs_plan)
    }

    /// The value in the graph, or the last one that was set while the graph has no such parameter.
    pub(super) fn value<'a>(&'a self, graph: &'a Graph, control: Control) -> Option<&'a Value> {
        let entry = &self.entries[control.0];
        entry.id.map(|id| graph.value(id)).or(entry.value.as_ref())
    }

    /// The names of the parameters of the graph that the host has set, and their values.
    pub(super) fn set_values<'a>(&'a self, graph: &'a Graph) -> impl Iterator<Item = (&'a str, &'a Value)> {
        let set = self.entries.iter().filter(|entry| entry.value.is_some());
        set.filter_map(|entry| Some((entry.name.as_str(), graph.value(entry.id?))))
    }

    /// Whether a change of the parameter needs a new plan.
    pub(super) fn needs_plan(&self, graph: &Graph, control: Control) -> bool {
        self.entries[control.0].id.is_some_and(|id| graph.declaration(id).replan)
    }

    /// The parameters with handles whose changes need no plan.
    pub(super) fn dynamic(&self, graph: &Graph) -> impl Iterator<Item = ParameterId> {
        let ids = self.entries.iter().filter_map(|entry| entry.id);
        ids.filter(|id| !graph.declaration(*id).replan)
    }

    /// Takes the values of a graph that differs from the present one in values of dynamic parameters only. Returns
    /// `false` if it differs in more: then some values may be taken, and the graph must be replaced.
    pub(super) fn take_values(&mut self, plans: &mut PlanCache, graph: &Graph) -> bool {
        let present = plans.graph();
        if !present.has_structure_of(graph) {
            return false;
        }
        let dynamic: Vec<ParameterId> = self.dynamic(present).collect();
        if graph.parameters().any(|id| !dynamic.contains(&id) && present.value(id) != graph.value(id)) {
            return false;
        }
        for index in 0..self.entries.len() {
            let entry = &mut self.entries[index];
            let Some(written) = entry.id.map(|id| graph.value(id).clone()) else { continue };
            entry.written = Some(written.clone());
            if entry.value.is_none() {
                if self.set(plans, Control(index), written).is_err() {
                    return false;
                }
                self.entries[index].value = None;
            }
        }
        true
    }

    /// Finds the parameters of all handles in a new graph, and sets what the host has set.
    pub(super) fn move_to(&mut self, plans: &mut PlanCache) {
        self.changes.nodes.clear();
        let graph = plans.shared_graph();
        for entry in &mut self.entries {
            entry.id = graph.parameter(&entry.name).ok().filter(|id| graph.declaration(*id).ty == entry.ty);
            entry.written = entry.id.map(|id| graph.value(id).clone());
            // A value that this graph refuses leaves that of its file.
            if let (Some(id), Some(value)) = (entry.id, &entry.value)
                && plans.set(id, value.clone()).is_ok()
            {
                self.changes.add(id.node);
            }
        }
    }
}
