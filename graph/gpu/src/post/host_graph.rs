//! The graph of a host, and what else its plans are made of except for images.

use std::sync::Arc;

use afterimage_graph::check::{Fact, Facts, Graph};
use afterimage_graph::value::{ParamType, Value};
use afterimage_plan::{HostInputs, Options, PlanError, Planned};

use super::controls::{Control, Controls, Parameter};
use super::error::PostError;
use super::live_graph::{GraphValues, LiveGraph, NodeChanges};
use super::plan_state::{CreatedPlan, OwnedPlanRequest, PlanState, Revision, UncachedPlan};
use crate::executor::Executor;

/// A graph with its facts, options and parameters. What changes one of them queues the next plan where it needs one.
pub(super) struct HostGraph {
    present: LiveGraph,
    /// Graphs before it whose plans still render: values that the host sets are theirs, too.
    replaced: Vec<LiveGraph>,
    facts: Facts,
    options: Options,
    controls: Controls,
    pub(super) revision: Revision,
    /// Counts changes of all that plans are made of.
    version: u64,
    /// The plan that follows the active one; `Ok` if that is for the present graph, facts and options.
    pub(super) next_plan: PlanState<CreatedPlan>,
}

impl HostGraph {
    pub(super) fn new(graph: Graph) -> Self {
        let controls = Controls::default();
        let revision = Revision::default();
        Self {
            present: LiveGraph::new(graph, revision.graph, &controls),
            replaced: Vec::new(),
            facts: Facts::default(),
            options: Options::default(),
            controls,
            revision,
            version: 0,
            next_plan: PlanState::Queued,
        }
    }

    /// The same graph and cached plans for another view.
    pub(super) fn for_view(&self) -> Self {
        Self {
            present: self.present.clone(),
            replaced: Vec::new(),
            facts: self.facts.clone(),
            options: self.options,
            controls: self.controls.clone(),
            revision: self.revision,
            version: self.version,
            next_plan: PlanState::Queued,
        }
    }

    /// Queues the next plan.
    pub(super) fn queue_plan(&mut self) {
        self.note_change();
        self.next_plan.queue();
    }

    /// Notes a change of what plans are made of.
    pub(super) fn note_change(&mut self) {
        self.version += 1;
    }

    /// The number of changes of what plans are made of.
    pub(super) fn version(&self) -> u64 {
        self.version
    }

    /// The graph at the present values of its parameters.
    pub(super) fn graph(&self) -> &Graph {
        self.present.graph()
    }

    /// The graph, for another thread.
    pub(super) fn shared(&self) -> Arc<Graph> {
        self.present.shared_graph()
    }

    /// The nodes of the present graph whose dynamic parameters have changed.
    pub(super) fn changes(&self) -> &NodeChanges {
        self.present.changes()
    }

    pub(super) fn values(&self) -> GraphValues<'_> {
        self.present.values()
    }

    /// The values of the graph of that revision, if its plan may render.
    pub(super) fn values_of(&self, revision: u64) -> Option<GraphValues<'_>> {
        let graphs = std::iter::once(&self.present).chain(&self.replaced);
        graphs.into_iter().find(|graph| graph.revision == revision).map(LiveGraph::values)
    }

    /// Takes out the replaced graphs of which no plan renders any more.
    pub(super) fn take_unused(&mut self, renders: impl Fn(u64) -> bool) -> Vec<LiveGraph> {
        self.replaced.extract_if(.., |graph| !renders(graph.revision)).collect()
    }

    pub(super) fn facts(&self) -> &Facts {
        &self.facts
    }

    pub(super) fn set_fact(&mut self, name: String, fact: Fact) {
        self.facts.set(name, fact);
        self.queue_plan();
    }

    pub(super) fn set_facts(&mut self, facts: Facts) {
        if self.facts != facts {
            self.facts = facts;
            self.queue_plan();
        }
    }

    pub(super) fn set_options(&mut self, options: Options) {
        self.options = options;
        self.queue_plan();
    }

    /// Replaces the graph, unless it differs only in values that need no plan.
    pub(super) fn change(&mut self, graph: Graph) {
        if self.present.take_values(&graph, &self.controls) {
            return;
        }
        self.revision.graph += 1;
        let next = LiveGraph::new(graph, self.revision.graph, &self.controls);
        let mut replaced = std::mem::replace(&mut self.present, next);
        replaced.plans.clear();
        self.replaced.push(replaced);
        self.queue_plan();
    }

    /// The handle of the parameter that `node.parameter` names. A new one needs a plan in which it is dynamic.
    pub(super) fn control(&mut self, name: &str) -> Result<Control, PostError> {
        let id = self.graph().parameter(name).map_err(PostError::UnknownParameter)?;
        if let Some(known) = self.present.handle_of(id) {
            return Ok(self.controls.at(known));
        }
        let control = self.controls.add(name, self.graph().declaration(id).ty);
        if let Some(entry) = self.controls.entries().last() {
            self.present.add(entry);
            self.replaced.iter_mut().for_each(|graph| graph.add(entry));
        }
        self.queue_plan();
        Ok(control)
    }

    /// The same for a parameter with values of type `T`.
    pub(super) fn parameter<T: ParamType>(&mut self, name: &str) -> Result<Parameter<T>, PostError> {
        let id = self.graph().parameter(name).map_err(PostError::UnknownParameter)?;
        let ty = self.graph().declaration(id).ty;
        if ty != T::TYPE {
            return Err(PostError::WrongType { name: name.to_owned(), ty: ty.describe() });
        }
        Ok(Parameter::new(self.control(name)?))
    }

    /// Sets a value in all graphs whose plans render or will.
    pub(super) fn set_value(&mut self, control: Control, value: Value) -> Result<(), PostError> {
        let index = self.controls.index(control)?;
        self.set_at(index, value.clone())?;
        self.replaced.iter_mut().for_each(|graph| graph.follow(index, Some(&value)));
        self.controls.note(index, Some(value));
        Ok(())
    }

    /// Sets the value in the pipeline file.
    pub(super) fn unset(&mut self, control: Control) -> Result<(), PostError> {
        let index = self.controls.index(control)?;
        if let Some(written) = self.present.written(index).cloned() {
            self.set_at(index, written)?;
        }
        self.replaced.iter_mut().for_each(|graph| graph.follow(index, None));
        self.controls.note(index, None);
        Ok(())
    }

    /// Sets a value in the present graph, if that has the parameter.
    fn set_at(&mut self, index: usize, value: Value) -> Result<(), PostError> {
        let name = &self.controls.entries()[index].name;
        if let Some(ty) = self.present.other_type(index) {
            return Err(PostError::WrongType { name: name.clone(), ty: ty.to_owned() });
        }
        let needs_plan =
            self.present.set(index, value).map_err(|why| PostError::Refused { name: name.clone(), why })?;
        if needs_plan {
            self.revision.values += 1;
            self.queue_plan();
        }
        Ok(())
    }

    /// The value in the graph, or the last one that was set while the graph has no such parameter.
    pub(super) fn value(&self, control: Control) -> Option<&Value> {
        let index = self.controls.index(control).ok()?;
        let present = self.present.parameter(index).map(|id| self.graph().value(id));
        present.or(self.controls.entries()[index].value.as_ref())
    }

    /// The names of the parameters of the graph that the host has set or may set without a plan, and their values.
    pub(super) fn set_values(&self) -> impl Iterator<Item = (&str, &Value)> {
        let entries = self.controls.entries().iter().enumerate();
        entries.filter_map(|(index, entry)| {
            let id = self.present.parameter(index)?;
            let is_dynamic = !self.graph().declaration(id).replan;
            (is_dynamic || entry.value.is_some()).then(|| (entry.name.as_str(), self.graph().value(id)))
        })
    }

    /// The names of handles that mean nothing in the present graph, and the type that the parameter of that name has.
    pub(super) fn stale_handles(&self) -> impl Iterator<Item = (&str, Option<&str>)> {
        let entries = self.controls.entries().iter().enumerate();
        let stale = entries.filter(|(index, _)| self.present.parameter(*index).is_none());
        stale.map(|(index, entry)| (entry.name.as_str(), self.present.other_type(index)))
    }

    /// Whether a change of the parameter needs a new plan.
    pub(super) fn needs_plan(&self, control: Control) -> bool {
        let id = self.controls.index(control).ok().and_then(|index| self.present.parameter(index));
        id.is_some_and(|id| self.graph().declaration(id).replan)
    }

    /// Drops all plans and queues the next one: a value of a dynamic parameter does not fit them.
    pub(super) fn replan(&mut self) {
        self.present.plans.clear();
        self.revision.values += 1;
        self.queue_plan();
    }

    /// What a plan for these inputs is made of.
    pub(super) fn plan_request(&self, executor: &Executor, inputs: HostInputs) -> OwnedPlanRequest {
        OwnedPlanRequest {
            device: executor.device().clone(),
            inputs,
            facts: self.facts.clone(),
            caps: executor.caps().clone(),
            options: self.options,
            dynamic: self.present.dynamic().collect(),
        }
    }

    /// The plan for these inputs, from the cache or new.
    pub(super) fn plan(&mut self, executor: &Executor, inputs: HostInputs) -> Result<Arc<Planned>, PlanError> {
        span!("afterimage::plan");
        self.plan_request(executor, inputs).with(|request| self.present.plans.planned(request))
    }

    /// The plan of a request, if it is in the cache.
    pub(super) fn cached(&mut self, request: &OwnedPlanRequest) -> Option<Arc<Planned>> {
        request.with(|request| self.present.plans.known(request))
    }

    /// Caches a plan of this revision, unless that is an older one. Returns the plan that is dropped for it.
    pub(super) fn keep(&mut self, plan: UncachedPlan, revision: Revision) -> Option<Arc<Planned>> {
        if revision == self.revision { self.present.plans.keep(plan.key, plan.planned) } else { None }
    }
}
