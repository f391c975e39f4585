//! One plan for each distinct request, kept while there is space.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::error::PlanError;
use crate::options::Options;
use crate::plan::Plan;
use crate::planner::plan;
use crate::request::{GivenImage, PlanRequest};
use afterimage_base::caps::Caps;
use afterimage_base::image::Size;
use afterimage_graph::check::{Facts, Graph};

/// Plans that are kept: the answers of a few conditions at two or three sizes.
const MOST: usize = 32;

/// A graph and its plans, each made once.
///
/// Facts matter only through conditions, so a fact that changes in every frame needs no new plan until the answer of some
/// `when` changes. The least recently used plan is dropped for a new one. All requests must have the same device's
/// [`requirement`](PlanRequest::requirement).
pub struct PlanCache {
    graph: Graph,
    /// The one used last is at the end.
    plans: Vec<(Key, Arc<Plan>)>,
}

/// The parts of a request that a plan depends on.
#[derive(PartialEq)]
struct Key {
    size: Size,
    inputs: BTreeMap<String, GivenImage>,
    /// What each node's condition says.
    answers: Vec<bool>,
    caps: Caps,
    options: Options,
}

impl PlanCache {
    /// No plans yet.
    pub fn new(graph: Graph) -> Self {
        Self { graph, plans: Vec::new() }
    }

    /// The graph.
    pub fn graph(&self) -> &Graph {
        &self.graph
    }

    /// The plan for this request: the same `Arc` as before where nothing has changed that matters to it.
    pub fn plan(&mut self, request: &PlanRequest<'_>) -> Result<Arc<Plan>, PlanError> {
        let key = Key {
            size: request.size,
            inputs: request.inputs.clone(),
            answers: self.answers(&request.facts),
            caps: request.caps.clone(),
            options: request.options,
        };
        let known = match self.plans.iter().position(|(known, _)| *known == key) {
            Some(at) => self.plans.remove(at),
            None => (key, Arc::new(plan(&self.graph, request)?)),
        };
        let plan = known.1.clone();
        self.plans.push(known);
        if self.plans.len() > MOST {
            self.plans.remove(0);
        }
        Ok(plan)
    }

    fn answers(&self, facts: &Facts) -> Vec<bool> {
        let conditions = self.graph.nodes.iter().filter_map(|node| node.when.as_ref());
        conditions.map(|condition| condition.holds(facts)).collect()
    }
}
