//! One plan for each distinct request, kept while there is space.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::dynamic_nodes::DynamicNodes;
use crate::error::PlanError;
use crate::options::Options;
use crate::plan::Plan;
use crate::planner::plan_dynamic;
use crate::request::{HostInputs, PlanRequest};
use afterimage_base::caps::Caps;
use afterimage_base::value::Value;
use afterimage_graph::check::{Facts, Graph, ParameterId};

/// Plans that are kept: the answers of a few conditions at two or three sizes.
const MAX_PLANS: usize = 32;

/// A plan, and what it takes to change its dynamic parameters.
#[derive(Clone)]
pub struct Planned {
    pub plan: Arc<Plan>,
    /// Its nodes with dynamic parameters.
    pub dynamic: DynamicNodes,
}

impl Planned {
    /// Plans a graph.
    ///
    /// # Errors
    /// As [`plan`](crate::plan()).
    pub fn new(graph: &Graph, request: &PlanRequest<'_>) -> Result<Self, PlanError> {
        let (plan, dynamic) = plan_dynamic(graph, request)?;
        Ok(Self { plan: Arc::new(plan), dynamic })
    }
}

/// A graph and its plans, each made once.
///
/// Facts matter only through conditions, so a fact that changes in every frame needs no new plan until the answer of
/// some `when` changes. The least recently used plan is dropped for a new one. All requests must have the same device's
/// [`requirement`](PlanRequest::requirement).
#[derive(Clone)]
pub struct PlanCache {
    graph: Arc<Graph>,
    /// The one used last is at the end.
    plans: Vec<(Arc<PlanKey>, Arc<Planned>)>,
}

/// The parts of a request that a plan depends on.
pub struct PlanKey {
    given: HostInputs,
    /// What each node's condition states.
    answers: Vec<bool>,
    caps: Caps,
    options: Options,
    dynamic: BTreeSet<ParameterId>,
}

impl PlanKey {
    /// Those of a request for a graph.
    pub fn new(graph: &Graph, request: &PlanRequest<'_>) -> Self {
        Self {
            given: request.given.clone(),
            answers: answers(graph, &request.facts).collect(),
            caps: request.caps.clone(),
            options: request.options,
            dynamic: request.dynamic.clone(),
        }
    }

    /// Whether the request depends on the same.
    fn is_of(&self, graph: &Graph, request: &PlanRequest<'_>) -> bool {
        // All fields by name, so that a new one cannot be forgotten.
        let Self { given, answers: known, caps, options, dynamic } = self;
        known.iter().copied().eq(answers(graph, &request.facts))
            && *options == request.options
            && *given == request.given
            && *dynamic == request.dynamic
            && *caps == request.caps
    }
}

fn answers(graph: &Graph, facts: &Facts) -> impl Iterator<Item = bool> {
    let conditions = graph.nodes.iter().filter_map(|node| node.when.as_ref());
    conditions.map(|condition| condition.holds(facts))
}

impl PlanCache {
    pub fn new(graph: Graph) -> Self {
        Self { graph: Arc::new(graph), plans: Vec::new() }
    }

    pub fn graph(&self) -> &Graph {
        &self.graph
    }

    /// The graph, for another thread.
    pub fn shared_graph(&self) -> Arc<Graph> {
        self.graph.clone()
    }

    /// Sets a parameter of the graph. Plans in which it is dynamic stay good, but for their uniforms; if its change
    /// needs a new plan, all plans are dropped, and the result is `true`.
    ///
    /// # Errors
    /// The value is outside of the domain, or does not go with the other values of the node: why, in a sentence.
    /// Nothing has changed then.
    pub fn set(&mut self, parameter: ParameterId, value: Value) -> Result<bool, String> {
        let declaration = self.graph.declaration(parameter);
        declaration.accepts(&value)?;
        let needs_plan = declaration.replan;
        let instance = &mut Arc::make_mut(&mut self.graph).nodes[parameter.node].instance;
        let old = instance.set(parameter.index, value);
        if let Err(why) = instance.verify() {
            instance.set(parameter.index, old);
            return Err(why);
        }
        if needs_plan {
            self.clear();
        }
        Ok(needs_plan)
    }

    pub fn clear(&mut self) {
        self.plans.clear();
    }

    /// The plan for this request: the same `Arc` as before where nothing has changed that matters to it.
    ///
    /// # Errors
    /// As [`plan`](crate::plan()).
    pub fn plan(&mut self, request: &PlanRequest<'_>) -> Result<Arc<Plan>, PlanError> {
        Ok(self.planned(request)?.plan.clone())
    }

    /// The same, with what it takes to change its dynamic parameters.
    ///
    /// # Errors
    /// As [`plan`](crate::plan()).
    pub fn planned(&mut self, request: &PlanRequest<'_>) -> Result<Arc<Planned>, PlanError> {
        if let Some(known) = self.known(request) {
            return Ok(known);
        }
        let planned = Arc::new(Planned::new(&self.graph, request)?);
        self.keep(PlanKey::new(&self.graph, request), planned.clone());
        Ok(planned)
    }

    /// The plan for this request, if there is one.
    pub fn known(&mut self, request: &PlanRequest<'_>) -> Option<Arc<Planned>> {
        let at = self.plans.iter().position(|(known, _)| known.is_of(&self.graph, request))?;
        self.plans[at..].rotate_left(1);
        self.plans.last().map(|(_, planned)| planned.clone())
    }

    /// Keeps a plan that was made elsewhere, for the graph of this cache, which has no plan for the request yet.
    /// Returns the plan that is dropped for it, because that may take long.
    pub fn keep(&mut self, key: PlanKey, planned: Arc<Planned>) -> Option<Arc<Planned>> {
        self.plans.push((Arc::new(key), planned));
        (self.plans.len() > MAX_PLANS).then(|| self.plans.remove(0).1)
    }
}
