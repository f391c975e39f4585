//! One plan for each distinct answer that host and scene give, remembered while there is room.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::{Caps, GivenImage, Options, Plan, PlanError, PlanRequest, plan};
use afterimage_base::image::Size;
use afterimage_graph::check::{Facts, Graph};

/// PlanCache that are remembered: the answers of a few conditions at two or three sizes.
const MOST: usize = 32;

/// A graph and its plans, each made once.
///
/// Facts matter only through the conditions that ask them, so a fact that changes in every frame asks for no new plan until some `when` answers
/// otherwise. The plan that was asked for least recently makes room for a new one. All settings must come with the same device's
/// [`requirement`](PlanRequest::requirement).
pub struct PlanCache {
    graph: Graph,
    /// The one asked for last stands last.
    known: Vec<(Key, Arc<Plan>)>,
}

/// All of a setting that a plan depends on.
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
        Self { graph, known: Vec::new() }
    }

    /// The graph.
    pub fn graph(&self) -> &Graph {
        &self.graph
    }

    /// The plan for this setting: the same `Arc` as before where nothing has changed that matters to it.
    pub fn plan(&mut self, setting: &PlanRequest<'_>) -> Result<Arc<Plan>, PlanError> {
        let key = Key {
            size: setting.size,
            inputs: setting.inputs.clone(),
            answers: self.answers(&setting.facts),
            caps: setting.caps.clone(),
            options: setting.options,
        };
        let known = match self.known.iter().position(|(known, _)| *known == key) {
            Some(at) => self.known.remove(at),
            None => (key, Arc::new(plan(&self.graph, setting)?)),
        };
        let plan = known.1.clone();
        self.known.push(known);
        if self.known.len() > MOST {
            self.known.remove(0);
        }
        Ok(plan)
    }

    fn answers(&self, facts: &Facts) -> Vec<bool> {
        let conditions = self.graph.nodes.iter().filter_map(|node| node.when.as_ref());
        conditions.map(|condition| condition.holds(facts)).collect()
    }
}
