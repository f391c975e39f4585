//! The plans of a pipeline: the active one, the next one, and those of announced frames.

use std::collections::BTreeSet;
use std::sync::{Arc, Weak};

use afterimage_gpu::internal::{PreparedPlan, Worker, requirement};
use afterimage_gpu::wgpu::Device;
use afterimage_gpu::{Executor, GpuError, span};
use afterimage_graph::check::{Facts, Graph, ParameterId};
use afterimage_graph::image::ImageDesc;
use afterimage_plan::{Caps, HostInputs, Options, Plan, PlanError, PlanKey, PlanRequest, Planned};

use super::active::ActivePlan;
use super::announced::AnnouncedFrame;
use super::bindings::HostBindings;
use super::fade::{Fade, FadeParts};
use super::values::{GraphValues, Revision, Values};
use crate::error::PostError;

/// All plans of a pipeline, and their inputs beside the graph and the images.
pub(super) struct Plans {
    pub(super) facts: Facts,
    pub(super) options: Options,
    /// The plan that renders.
    pub(super) active: Option<ActivePlan>,
    /// Set by a change for which no plan was begun.
    is_queued: bool,
    /// The next plan, which a worker makes.
    next: Option<Job<NextPlan>>,
    announced: Vec<AnnouncedPlan>,
    /// The plan of the announced frame at that index for these inputs, which a worker makes.
    ahead: Option<(usize, HostInputs, Job<NewPlan>)>,
    /// Counts changes of the inputs of plans.
    version: u64,
}

/// The work of a worker for a graph of that revision.
pub(super) struct Job<T> {
    pub(super) revision: Revision,
    pub(super) worker: Worker<Result<T, PostError>>,
}

/// A plan that can be activated.
pub(super) struct NextPlan {
    pub(super) active: ActivePlan,
    pub(super) prepared: PreparedPlan,
    pub(super) new: NewPlan,
    /// The parts of a fade to the plan, if changes were to be faded when the worker was started.
    pub(super) fade: Option<Result<FadeParts, GpuError>>,
}

/// A plan, and its key if it is not in the cache.
pub(super) struct NewPlan {
    planned: Arc<Planned>,
    key: Option<PlanKey>,
}

/// The plan of a frame that is announced.
struct AnnouncedPlan {
    frame: AnnouncedFrame,
    /// The version for which it is made or being made.
    version: Option<u64>,
    /// The plan that is compiled for the formats of the frame.
    compiled: Weak<Plan>,
}

/// A [`PlanRequest`] for any thread, and its plan if that is in the cache.
struct OwnedRequest {
    device: Device,
    inputs: HostInputs,
    facts: Facts,
    caps: Caps,
    options: Options,
    dynamic: BTreeSet<ParameterId>,
    cached: Option<Arc<Planned>>,
}

impl<T: Send + 'static> Job<T> {
    fn is_finished(&self) -> bool {
        self.worker.is_finished()
    }
}

impl Plans {
    pub(super) fn new() -> Self {
        Self {
            facts: Facts::default(),
            options: Options::default(),
            active: None,
            is_queued: true,
            next: None,
            announced: Vec::new(),
            ahead: None,
            version: 0,
        }
    }

    /// The same facts, options and announced frames for another view or device.
    pub(super) fn without_plans(&self) -> Self {
        let mut plans = Self { facts: self.facts.clone(), options: self.options, ..Self::new() };
        plans.announce(self.announced.iter().map(|plan| plan.frame.clone()));
        plans
    }

    /// Queues the next plan.
    pub(super) fn queue(&mut self) {
        self.note_change();
        self.is_queued = true;
    }

    /// Notes a possible change of the inputs of plans, for the next frame to check.
    pub(super) fn note_change(&mut self) {
        self.version += 1;
    }

    /// `true` while a plan is being made, and if one will be at the next frame.
    pub(super) fn is_changing(&self) -> bool {
        self.is_queued || self.next.is_some()
    }

    fn request(&self, executor: &Executor, values: &Values, inputs: HostInputs) -> OwnedRequest {
        OwnedRequest {
            device: executor.compiler.device.clone(),
            inputs,
            facts: self.facts.clone(),
            caps: executor.caps().clone(),
            options: self.options,
            dynamic: values.dynamic().collect(),
            cached: None,
        }
    }

    /// The request, with its plan if that is in the cache.
    fn cached_request(&self, executor: &Executor, values: &mut Values, inputs: HostInputs) -> OwnedRequest {
        let mut request = self.request(executor, values, inputs);
        request.cached = request.with(|request| values.cache().known(request));
        request
    }

    /// The plan for these inputs, from the cache or new.
    pub(super) fn plan(
        &self,
        executor: &Executor,
        values: &mut Values,
        inputs: HostInputs,
    ) -> Result<Arc<Planned>, PlanError> {
        span!("afterimage::plan");
        self.request(executor, values, inputs).with(|request| values.cache().planned(request))
    }

    /// Makes a plan for these inputs with other capabilities and options.
    #[cfg(all(feature = "offline", not(target_family = "wasm")))]
    pub(super) fn plan_with(
        &self,
        executor: &Executor,
        values: &Values,
        inputs: HostInputs,
        change: impl FnOnce(&mut Caps, &mut Options),
    ) -> Result<Plan, PlanError> {
        let mut request = self.request(executor, values, inputs);
        change(&mut request.caps, &mut request.options);
        request.with(|request| afterimage_plan::plan(values.graph(), request))
    }

    /// Drops the next plan if it is being made, and queues it again.
    pub(super) fn cancel_next(&mut self) {
        self.is_queued |= self.next.take().is_some();
    }

    /// Drops the next plan: the active one is for all that has changed.
    pub(super) fn forget_next(&mut self) {
        (self.is_queued, self.next) = (false, None);
    }

    /// Takes the next plan from its worker, also if that is not finished.
    pub(super) fn take_next(&mut self) -> Option<Job<NextPlan>> {
        self.next.take()
    }

    /// The same if the worker is finished.
    pub(super) fn take_finished(&mut self) -> Option<Job<NextPlan>> {
        self.next.take_if(|job| job.is_finished())
    }

    /// Starts to make the plan that is queued, unless the active one is the same or another one is being made.
    pub(super) fn start_next(&mut self, executor: &Executor, values: &mut Values, fade: &Fade) {
        if !self.is_queued || self.next.is_some() {
            return;
        }
        self.is_queued = false;
        let Some(active) = &self.active else { return };
        let request = self.cached_request(executor, values, active.inputs.clone());
        if request.cached.as_ref().is_some_and(|cached| Arc::ptr_eq(&cached.plan, &active.plan)) {
            return;
        }
        let (graph, revision, changes) = (values.shared_graph(), values.revision, values.changes().clone());
        let (compile, prepare_fade) = (executor.compilation(), fade.preparation(executor, active));
        let worker = Worker::new(executor.compiler.pool.as_ref(), move || {
            span!("afterimage::prepare");
            let new = request.planned(&graph)?;
            let values = GraphValues { graph: &graph, revision: revision.graph, changes: &changes };
            let active = ActivePlan::new(request.inputs, &new.planned, values);
            let prepared = compile(active.plan.clone(), active.uniforms.clone())?;
            Ok(NextPlan { active, prepared, new, fade: prepare_fade.map(|prepare| prepare()) })
        });
        self.next = Some(Job { revision, worker });
    }

    /// Announces frames in the place of those before.
    pub(super) fn announce(&mut self, frames: impl IntoIterator<Item = AnnouncedFrame>) {
        let plan = |frame| AnnouncedPlan { frame, version: None, compiled: Weak::new() };
        (self.announced, self.ahead) = (frames.into_iter().map(plan).collect(), None);
    }

    /// `true` once the plans of all announced frames are made.
    pub(super) fn are_prepared(&self) -> bool {
        self.ahead.is_none() && self.announced.iter().all(|plan| plan.version == Some(self.version))
    }

    /// Caches the plan of an announced frame if it is finished, or waits for that of these inputs.
    ///
    /// # Errors
    /// The plan cannot be made.
    pub(super) fn take_ahead(
        &mut self,
        executor: &Executor,
        values: &mut Values,
        wanted: Option<&HostInputs>,
    ) -> Result<(), PostError> {
        let is_due = |job: &mut (usize, HostInputs, Job<NewPlan>)| wanted == Some(&job.1) || job.2.is_finished();
        if let Some((frame, _, job)) = self.ahead.take_if(is_due) {
            let new = job.worker.join().map_err(PostError::from).flatten()?;
            self.announced[frame].compiled = Arc::downgrade(&new.planned.plan);
            new.keep(executor, values, job.revision);
        }
        Ok(())
    }

    /// Starts to make the plan of the next announced frame, unless the next plan, which comes first, or another one is
    /// being made.
    pub(super) fn start_ahead(&mut self, executor: &Executor, values: &mut Values, bindings: &HostBindings) {
        let version = self.version;
        while self.ahead.is_none()
            && (self.active.is_none() || !self.is_changing())
            && let Some(index) = self.announced.iter().position(|plan| plan.version != Some(version))
        {
            self.announced[index].version = Some(version);
            let AnnouncedPlan { frame, compiled, .. } = &self.announced[index];
            // Another pipeline may have other inputs: its first frame says so.
            let Ok(inputs) = bindings.inputs(values.graph(), frame) else { continue };
            let request = self.cached_request(executor, values, inputs.clone());
            let is_compiled = |cached: &Arc<Planned>| std::ptr::eq(compiled.as_ptr(), Arc::as_ptr(&cached.plan));
            if request.cached.as_ref().is_some_and(is_compiled) {
                continue;
            }
            let (graph, compile) = (values.shared_graph(), executor.compiler.ahead(frame.drawn()));
            let worker = Worker::new(executor.compiler.pool.as_ref(), move || {
                span!("afterimage::prepare");
                let new = request.planned(&graph)?;
                compile(&new.planned.plan)?;
                Ok(new)
            });
            self.ahead = Some((index, inputs, Job { revision: values.revision, worker }));
        }
    }
}

impl NewPlan {
    /// Caches the plan if it is new, and of the present revision.
    pub(super) fn keep(self, executor: &Executor, values: &mut Values, revision: Revision) {
        let Some(key) = self.key.filter(|_| revision == values.revision) else { return };
        if let Some(evicted) = values.cache().keep(key, self.planned) {
            executor.compiler.drop_later(evicted);
        }
    }
}

impl OwnedRequest {
    /// Calls `use_request` with the request for the planner.
    fn with<T>(&self, use_request: impl FnOnce(&PlanRequest<'_>) -> T) -> T {
        let requirement = |desc: &ImageDesc| requirement(&self.device, desc);
        use_request(&PlanRequest {
            given: self.inputs.clone(),
            facts: self.facts.clone(),
            caps: self.caps.clone(),
            options: self.options,
            dynamic: self.dynamic.clone(),
            requirement: &requirement,
        })
    }

    fn planned(&self, graph: &Graph) -> Result<NewPlan, PlanError> {
        if let Some(planned) = &self.cached {
            return Ok(NewPlan { planned: planned.clone(), key: None });
        }
        self.with(|request| {
            let planned = Arc::new(Planned::new(graph, request)?);
            Ok(NewPlan { planned, key: Some(PlanKey::new(graph, request)) })
        })
    }
}
