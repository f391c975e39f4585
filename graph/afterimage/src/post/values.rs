//! The values that a host sets, and the graphs that have them.

use std::marker::PhantomData;
use std::sync::Arc;

use afterimage_graph::check::{Graph, ParameterId};
use afterimage_graph::value::{Param, ParamType, Type, Value};
use afterimage_plan::PlanCache;
use indexmap::IndexMap;

use super::handles::{Handle, Handles};
use crate::error::PostError;

slotmap::new_key_type! {
    /// A parameter that the host changes, of any type.
    pub struct Control;
}

static CONTROLS: Handles<Control> = Handles::new();

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
    /// The same without its type, for code that treats all parameters alike.
    pub fn control(self) -> Control {
        self.control
    }
}

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

/// The parameters with handles, and the graphs in which their values are set.
pub(super) struct Values {
    /// In the order in which the host asked for them, which is the order in which their values are set.
    entries: IndexMap<Control, Entry>,
    present: LiveGraph,
    /// Graphs before it whose plans still render: values that the host sets are theirs, too.
    replaced: Vec<LiveGraph>,
    pub(super) revision: Revision,
}

/// Revision counters; a plan of an older revision must not replace the active one.
#[derive(Clone, Copy, Default, PartialEq)]
pub(super) struct Revision {
    /// Counts graphs: nodes of an older one do not fit the present one.
    pub(super) graph: u64,
    /// Counts changes of parameters that need plans. A plan of an older revision is activated, but not cached.
    values: u64,
}

#[derive(Clone)]
struct Entry {
    handle: Arc<Handle<Control>>,
    name: String,
    ty: Type,
    /// The value that the host has set.
    value: Option<Value>,
}

/// A graph at the values that the host has set: the present one, or one before it whose plan still renders.
#[derive(Clone)]
pub(super) struct LiveGraph {
    revision: u64,
    plans: PlanCache,
    targets: IndexMap<Control, Target>,
    changes: NodeChanges,
}

/// The graph at the present values of its parameters.
#[derive(Clone, Copy)]
pub(super) struct GraphValues<'a> {
    pub(super) graph: &'a Graph,
    /// See [`Revision::graph`].
    pub(super) revision: u64,
    pub(super) changes: &'a NodeChanges,
}

/// The parameter of a graph that a handle means.
#[derive(Clone)]
enum Target {
    /// This one; the value is that of the file.
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

impl Values {
    pub(super) fn new(graph: Graph) -> Self {
        let (entries, revision) = (IndexMap::new(), Revision::default());
        let present = LiveGraph::new(graph, revision.graph, &entries);
        Self { entries, present, replaced: Vec::new(), revision }
    }

    /// The same handles, values and cached plans for another view.
    pub(super) fn for_view(&self) -> Self {
        let (entries, present) = (self.entries.clone(), self.present.clone());
        Self { entries, present, replaced: Vec::new(), revision: self.revision }
    }

    /// The graph at the present values of its parameters.
    pub(super) fn graph(&self) -> &Graph {
        self.present.plans.graph()
    }

    /// The graph, for another thread.
    pub(super) fn shared_graph(&self) -> Arc<Graph> {
        self.present.plans.shared_graph()
    }

    pub(super) fn changes(&self) -> &NodeChanges {
        &self.present.changes
    }

    /// The cached plans of the present graph.
    pub(super) fn cache(&mut self) -> &mut PlanCache {
        &mut self.present.plans
    }

    /// The values of the graph of that revision, if its plan may render.
    pub(super) fn of_revision(&self, revision: u64) -> Option<GraphValues<'_>> {
        let mut graphs = std::iter::once(&self.present).chain(&self.replaced);
        graphs.find(|graph| graph.revision == revision).map(LiveGraph::values)
    }

    pub(super) fn present(&self) -> GraphValues<'_> {
        self.present.values()
    }

    /// Takes out the replaced graphs of which no plan renders any more.
    pub(super) fn take_unused(&mut self, renders: impl Fn(u64) -> bool) -> Vec<LiveGraph> {
        self.replaced.extract_if(.., |graph| !renders(graph.revision)).collect()
    }

    /// Replaces the graph. Returns `false` if it differs only in values that need no plan, which are taken.
    pub(super) fn replace(&mut self, graph: Graph) -> bool {
        if self.present.take_values(&graph, &self.entries) {
            return false;
        }
        self.revision.graph += 1;
        let next = LiveGraph::new(graph, self.revision.graph, &self.entries);
        let mut replaced = std::mem::replace(&mut self.present, next);
        replaced.plans.clear();
        self.replaced.push(replaced);
        true
    }

    /// Drops all plans: a value of a dynamic parameter does not fit them.
    pub(super) fn drop_plans(&mut self) {
        self.present.plans.clear();
        self.revision.values += 1;
    }

    /// The handle of the parameter that `node.parameter` names, and whether it is new.
    pub(super) fn control(&mut self, name: &str) -> Result<(Control, bool), PostError> {
        let id = self.graph().parameter(name).map_err(PostError::UnknownParameter)?;
        let known = self.present.targets.iter().find(|(_, target)| target.parameter() == Some(id));
        if let Some((control, _)) = known {
            return Ok((*control, false));
        }
        let (handle, ty) = (Arc::new(CONTROLS.add(name)), self.graph().declaration(id).ty);
        let control = handle.key();
        let entry = Entry { handle, name: name.to_owned(), ty, value: None };
        for graph in std::iter::once(&mut self.present).chain(&mut self.replaced) {
            graph.targets.insert(control, target(graph.plans.graph(), &entry));
        }
        self.entries.insert(control, entry);
        Ok((control, true))
    }

    /// The same for a parameter with values of type `T`.
    pub(super) fn parameter<T: ParamType>(&mut self, name: &str) -> Result<(Parameter<T>, bool), PostError> {
        let id = self.graph().parameter(name).map_err(PostError::UnknownParameter)?;
        let ty = self.graph().declaration(id).ty;
        if ty != T::TYPE {
            return Err(PostError::WrongType { name: name.to_owned(), ty: ty.describe() });
        }
        let (control, is_new) = self.control(name)?;
        Ok((Parameter { control, value: PhantomData }, is_new))
    }

    /// Sets a value in all graphs whose plans render or will. Returns whether the change needs a new plan.
    pub(super) fn set(&mut self, control: Control, value: Value) -> Result<bool, PostError> {
        let needs_plan = self.set_present(control, value.clone())?;
        self.replaced.iter_mut().for_each(|graph| graph.follow(control, Some(&value)));
        self.note(control, Some(value));
        Ok(needs_plan)
    }

    /// Sets the value of the pipeline file. Returns whether the change needs a new plan.
    pub(super) fn unset(&mut self, control: Control) -> Result<bool, PostError> {
        let needs_plan = match self.present.written(control).cloned() {
            Some(written) => self.set_present(control, written)?,
            None => self.entry(control).map(|_| false)?,
        };
        self.replaced.iter_mut().for_each(|graph| graph.follow(control, None));
        self.note(control, None);
        Ok(needs_plan)
    }

    fn note(&mut self, control: Control, value: Option<Value>) {
        if let Some(entry) = self.entries.get_mut(&control) {
            entry.value = value;
        }
    }

    fn entry(&self, control: Control) -> Result<&Entry, PostError> {
        self.entries.get(&control).ok_or_else(|| PostError::UnknownHandle(CONTROLS.name(control)))
    }

    /// Sets a value in the present graph, if that has the parameter.
    fn set_present(&mut self, control: Control, value: Value) -> Result<bool, PostError> {
        let name = &self.entry(control)?.name;
        if let Some(ty) = self.present.other_type(control) {
            return Err(PostError::WrongType { name: name.clone(), ty: ty.to_owned() });
        }
        let refused = |why| PostError::Refused { name: self.entries[&control].name.clone(), why };
        let needs_plan = self.present.set(control, value).map_err(refused)?;
        self.revision.values += u64::from(needs_plan);
        Ok(needs_plan)
    }

    /// The value in the graph, or the last one that was set while the graph has no such parameter.
    pub(super) fn value(&self, control: Control) -> Option<&Value> {
        let present = self.present.parameter(control).map(|id| self.graph().value(id));
        present.or(self.entries.get(&control)?.value.as_ref())
    }

    /// The names of the parameters of the graph that the host has set or may set without a plan, and their values.
    pub(super) fn set_values(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.entries.values().filter_map(|entry| {
            let id = self.present.parameter(entry.handle.key())?;
            let is_dynamic = !self.graph().declaration(id).replan;
            (is_dynamic || entry.value.is_some()).then(|| (entry.name.as_str(), self.graph().value(id)))
        })
    }

    /// The names of handles without a parameter in the present graph, and the type that the parameter of that name has.
    pub(super) fn stale_handles(&self) -> impl Iterator<Item = (&str, Option<&str>)> {
        let stale = self.entries.iter().filter(|(control, _)| self.present.parameter(**control).is_none());
        stale.map(|(control, entry)| (entry.name.as_str(), self.present.other_type(*control)))
    }

    /// `true` if a change of the parameter needs a new plan.
    pub(super) fn needs_plan(&self, control: Control) -> bool {
        self.present.parameter(control).is_some_and(|id| self.graph().declaration(id).replan)
    }

    /// The parameters with handles whose changes need no plan.
    pub(super) fn dynamic(&self) -> impl Iterator<Item = ParameterId> {
        self.present.dynamic()
    }
}

impl Target {
    fn parameter(&self) -> Option<ParameterId> {
        match self {
            Self::Parameter(id, _) => Some(*id),
            Self::OtherType(_) | Self::Missing => None,
        }
    }
}

impl LiveGraph {
    /// Finds the parameters of all handles in a graph, and sets the values of the host.
    fn new(graph: Graph, revision: u64, entries: &IndexMap<Control, Entry>) -> Self {
        let plans = PlanCache::new(graph);
        let mut live = Self { revision, plans, targets: IndexMap::new(), changes: NodeChanges::default() };
        for (control, entry) in entries {
            live.targets.insert(*control, target(live.plans.graph(), entry));
            // A value that this graph refuses leaves that of its file.
            if let Some(value) = &entry.value {
                _ = live.set(*control, value.clone());
            }
        }
        live
    }

    fn values(&self) -> GraphValues<'_> {
        GraphValues { graph: self.plans.graph(), revision: self.revision, changes: &self.changes }
    }

    fn parameter(&self, control: Control) -> Option<ParameterId> {
        self.targets.get(&control).and_then(Target::parameter)
    }

    /// The type in words of the parameter that has the name of a handle and another type.
    fn other_type(&self, control: Control) -> Option<&str> {
        match self.targets.get(&control)? {
            Target::OtherType(ty) => Some(ty),
            Target::Parameter(..) | Target::Missing => None,
        }
    }

    /// The value of the file.
    fn written(&self, control: Control) -> Option<&Value> {
        match self.targets.get(&control)? {
            Target::Parameter(_, written) => Some(written),
            Target::OtherType(_) | Target::Missing => None,
        }
    }

    /// Sets a value, if the graph has the parameter. Returns whether the change needs a new plan.
    ///
    /// # Errors
    /// The graph refuses the value, for a reason in a sentence.
    fn set(&mut self, control: Control, value: Value) -> Result<bool, String> {
        let id = self.parameter(control).filter(|id| *self.plans.graph().value(*id) != value);
        let Some(id) = id else { return Ok(false) };
        let needs_plan = self.plans.set(id, value)?;
        if !needs_plan {
            self.changes.add(id.node);
        }
        Ok(needs_plan)
    }

    /// Sets a value in a graph that has been replaced, and whose plan still renders: that of the host, or else that of
    /// the file. Where it needs another plan or is refused, the old one stays until the next plan comes.
    fn follow(&mut self, control: Control, value: Option<&Value>) {
        let is_dynamic = self.parameter(control).is_some_and(|id| !self.plans.graph().declaration(id).replan);
        if let Some(value) = value.or(self.written(control)).filter(|_| is_dynamic).cloned() {
            _ = self.set(control, value);
        }
    }

    fn dynamic(&self) -> impl Iterator<Item = ParameterId> {
        let ids = self.targets.values().filter_map(Target::parameter);
        ids.filter(|id| !self.plans.graph().declaration(*id).replan)
    }

    /// Takes the values of a graph that differs from this one in values of dynamic parameters only. Returns `false` if
    /// it differs in more: then some values may be taken, and the graph must be replaced.
    fn take_values(&mut self, graph: &Graph, entries: &IndexMap<Control, Entry>) -> bool {
        let present = self.plans.graph();
        if !present.has_structure_of(graph) {
            return false;
        }
        let dynamic: Vec<ParameterId> = self.dynamic().collect();
        if graph.parameters().any(|id| !dynamic.contains(&id) && present.value(id) != graph.value(id)) {
            return false;
        }
        for (control, entry) in entries {
            let Some(Target::Parameter(id, written)) = self.targets.get_mut(control) else { continue };
            let value = graph.value(*id).clone();
            written.clone_from(&value);
            if entry.value.is_none() && self.set(*control, value).is_err() {
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
