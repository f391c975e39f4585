//! A graph on a device that may belong to somebody else.

use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_plan::{GivenImage, Options, Plan, PlanCache, PlanError, PlanRequest};

use super::frame::InputImage;
use crate::Executor;
use crate::error::SessionError;

/// A plan cache and an executor: the plan follows the images, the facts and the options, and is compiled once.
pub struct Runtime {
    executor: Executor,
    plans: PlanCache,
    facts: Facts,
    options: Options,
    /// The loaded plan as the planner made it. The executor's own may keep the placement of the plan before it.
    loaded: Option<Arc<Plan>>,
}

impl Runtime {
    /// A runtime that plans with the capabilities of the executor.
    pub fn new(executor: Executor, graph: Graph, facts: Facts, options: Options) -> Self {
        Self { executor, plans: PlanCache::new(graph), facts, options, loaded: None }
    }

    /// Replaces the graph and the options; its plans are made anew. What the executor has compiled is kept.
    pub fn change(&mut self, graph: Graph, options: Options) {
        self.plans = PlanCache::new(graph);
        self.options = options;
    }

    /// The executor.
    pub fn executor(&mut self) -> &mut Executor {
        &mut self.executor
    }

    /// The loaded plan.
    pub fn plan(&self) -> Option<&Arc<Plan>> {
        self.loaded.as_ref()
    }

    /// The texture of an output of the last frame.
    ///
    /// # Panics
    /// If the loaded plan has no such output.
    pub fn output(&self, name: &str) -> &wgpu::Texture {
        self.executor.output(name).expect("the executor keeps a texture for each output")
    }

    /// The buffer of a table or value of the loaded plan, by its label.
    pub(super) fn buffer(&self, label: &str) -> Option<&wgpu::Buffer> {
        self.executor.buffer(label)
    }

    /// The plan for these images, without loading it.
    ///
    /// # Errors
    /// The graph cannot be planned at this size.
    pub fn plan_for(&mut self, size: Size, images: &[InputImage]) -> Result<Arc<Plan>, PlanError> {
        let given = |image: &InputImage| (image.input.clone(), GivenImage { desc: image.desc, finite: image.finite });
        self.plan_for_descs(size, images.iter().map(given).collect())
    }

    /// The plan for images of these descriptions, without loading it.
    ///
    /// # Errors
    /// The graph cannot be planned at this size.
    pub fn plan_for_descs(&mut self, size: Size, inputs: BTreeMap<String, GivenImage>) -> Result<Arc<Plan>, PlanError> {
        let executor = &self.executor;
        let requirement = |desc: &ImageDesc| executor.requirement(desc);
        let request = PlanRequest {
            size,
            inputs,
            facts: self.facts.clone(),
            caps: executor.caps().clone(),
            options: self.options,
            requirement: &requirement,
        };
        self.plans.plan(&request)
    }

    /// Makes the plan for these images and loads it if it is not the loaded one.
    ///
    /// # Errors
    /// The graph cannot be planned at this size, or the device refuses the plan.
    pub fn load(&mut self, size: Size, images: &[InputImage]) -> Result<&Arc<Plan>, SessionError> {
        let plan = self.plan_for(size, images)?;
        if self.loaded.as_ref().is_none_or(|loaded| !Arc::ptr_eq(loaded, &plan)) {
            self.executor.load(plan.clone())?;
        }
        Ok(self.loaded.insert(plan))
    }
}
