//! The graph of a host, and what else its plans are made of except for images.

use std::sync::Arc;

use afterimage_graph::check::{Fact, Facts, Graph};
use afterimage_graph::value::{ParamType, Value};
use afterimage_plan::{HostInputs, Options, PlanCache, PlanError, Planned};

use super::active::GraphValues;
use super::controls::{Control, Controls, Parameter};
use super::error::PostError;
use super::plan_state::{CreatedPlan, OwnedPlanRequest, PlanState, Revision, UncachedPlan};
use crate::executor::Executor;

/// A graph with its facts, options and parameters. What changes one of them queues the next plan where it needs one.
pub(super) struct HostGraph {
    plans: PlanCache,
    facts: Facts,
    options: Options,
    controls: Controls,
    pub(super) revision: Revision,
    /// The plan that follows the active one; `Ok` if that is for the present graph, facts and options.
    pub(super) next_plan: PlanState<CreatedPlan>,
}

impl HostGraph {
    pub(super) fn new(graph: Graph) -> Self {
        Self {
            plans: PlanCache::new(graph),
            facts: Facts::default(),
            options: Options::default(),
            controls: Controls::default(),
            revision: Revision::default(),
            next_plan: PlanState::Queued,
        }
    }

    /// The same graph and cached plans for another view.
    pub(super) fn for_view(&self) -> Self {
        Self {
            plans: self.plans.clone(),
            facts: self.facts.clone(),
            options: self.options,
            controls: self.controls.clone(),
            revision: Revision::default(),
            next_plan: PlanState::Queued,
        }
    }

    /// The graph at the present values of its parameters.
    pub(super) fn graph(&self) -> &Graph {
        self.plans.graph()
    }

    /// The graph, for another thread.
    pub(super) fn shared(&self) -> Arc<Graph> {
        self.plans.shared_graph()
    }

    pub(super) fn controls(&self) -> &Controls {
        &self.controls
    }

    pub(super) fn values(&self) -> GraphValues<'_> {
        GraphValues { graph: self.graph(), revision: self.revision.graph, changes: &self.controls.changes }
    }

    pub(super) fn facts(&self) -> &Facts {
        &self.facts
    }

    pub(super) fn set_fact(&mut self, name: String, fact: Fact) {
        self.facts.set(name, fact);
        self.next_plan.queue();
    }

    pub(super) fn set_facts(&mut self, facts: Facts) {
        if self.facts != facts {
            self.facts = facts;
            self.next_plan.queue();
        }
    }

    pub(super) fn set_options(&mut self, options: Options) {
        self.options = options;
        self.next_plan.queue();
    }

    /// Replaces the graph, unless it differs only in values that need no plan.
    pub(super) fn change(&mut self, graph: Graph) {
        if self.controls.take_values(&mut self.plans, &graph) {
            return;
        }
        self.plans = PlanCache::new(graph);
        self.revision.graph += 1;
        self.controls.move_to(&mut self.plans);
        self.next_plan.queue();
    }

    /// The handle of the parameter that `node.parameter` names. A new one needs a plan in which it is dynamic.
    pub(super) fn control(&mut self, name: &str) -> Result<Control, PostError> {
        let handles = self.controls.count();
        let control = self.controls.control(self.plans.graph(), name)?;
        if self.controls.count() > handles {
            self.next_plan.queue();
        }
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

    pub(super) fn set_value(&mut self, control: Control, value: Value) -> Result<(), PostError> {
        if self.controls.set(&mut self.plans, control, value)? {
            self.revision.values += 1;
            self.next_plan.queue();
        }
        Ok(())
    }

    /// Sets the value in the pipeline file.
    pub(super) fn unset(&mut self, control: Control) -> Result<(), PostError> {
        if self.controls.unset(&mut self.plans, control)? {
            self.revision.values += 1;
            self.next_plan.queue();
        }
        Ok(())
    }

    /// Drops all plans and queues the next one: a value of a dynamic parameter does not fit them.
    pub(super) fn replan(&mut self) {
        self.plans.clear();
        self.revision.values += 1;
        self.next_plan.queue();
    }

    /// What a plan for these inputs is made of.
    pub(super) fn plan_request(&self, executor: &Executor, inputs: HostInputs) -> OwnedPlanRequest {
        OwnedPlanRequest {
            device: executor.device().clone(),
            inputs,
            facts: self.facts.clone(),
            caps: executor.caps().clone(),
            options: self.options,
            dynamic: self.controls.dynamic(self.graph()).collect(),
        }
    }

    /// The plan for these inputs, from the cache or new.
    pub(super) fn plan(&mut self, executor: &Executor, inputs: HostInputs) -> Result<Arc<Planned>, PlanError> {
        span!("afterimage::plan");
        self.plan_request(executor, inputs).with(|request| self.plans.planned(request))
    }

    /// The plan of a request, if it is in the cache.
    pub(super) fn cached(&mut self, request: &OwnedPlanRequest) -> Option<Arc<Planned>> {
        request.with(|request| self.plans.known(request))
    }

    /// Caches a plan of this revision, unless that is an older one. Returns the plan that is dropped for it.
    pub(super) fn keep(&mut self, plan: UncachedPlan, revision: Revision) -> Option<Arc<Planned>> {
        if revision == self.revision { self.plans.keep(plan.key, plan.planned) } else { None }
    }
}
