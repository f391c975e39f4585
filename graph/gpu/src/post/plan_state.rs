//! The life of a plan that is made in the background, from a change to the frame that can use it.

use std::collections::BTreeSet;
use std::sync::Arc;

use afterimage_graph::check::{Facts, Graph, ParameterId};
use afterimage_graph::image::ImageDesc;
use afterimage_plan::{Caps, HostInputs, Options, PlanError, PlanKey, PlanRequest, Planned};
use wgpu::Device;

use super::active::ActivePlan;
use super::error::PostError;
use super::fade::{FadeParts, FadeSkipReason};
use crate::executor::PreparedPlan;
use crate::heap;
use crate::platform::Worker;

/// The life of a plan that is made in the background.
pub(super) enum PlanState<T> {
    /// It is made, or none is needed.
    Ok,
    /// The next frame starts a worker.
    Queued,
    /// A worker plans and compiles.
    Creating(Creation<T>),
}

/// A plan that a worker creates.
pub(super) struct Creation<T> {
    pub(super) revision: Revision,
    /// Whether something has changed meanwhile, so that another plan follows.
    is_outdated: bool,
    pub(super) worker: Worker<Result<T, PostError>>,
}

/// A plan that can be activated.
pub(super) struct CreatedPlan {
    pub(super) active: ActivePlan,
    pub(super) prepared: PreparedPlan,
    /// The plan for the cache, unless it comes from there.
    pub(super) uncached: Option<UncachedPlan>,
    /// What a fade to the plan needs, if changes were to be faded when the worker was started.
    pub(super) fade: Option<Result<FadeParts, FadeSkipReason>>,
}

/// A plan that is not in the cache.
pub(super) struct UncachedPlan {
    pub(super) key: PlanKey,
    pub(super) planned: Arc<Planned>,
}

/// Revision counters; a plan of an older revision must not replace the active one.
#[derive(Clone, Copy, Default, PartialEq)]
pub(super) struct Revision {
    /// Counts graphs: nodes and handles of an older one do not fit the present one.
    pub(super) graph: u64,
    /// Counts changes of parameters that need plans. A plan of an older revision is activated, but not cached.
    pub(super) values: u64,
}

/// A [`PlanRequest`] that can be moved to another thread.
pub(super) struct OwnedPlanRequest {
    pub(super) device: Device,
    pub(super) inputs: HostInputs,
    pub(super) facts: Facts,
    pub(super) caps: Caps,
    pub(super) options: Options,
    pub(super) dynamic: BTreeSet<ParameterId>,
}

impl<T> PlanState<T> {
    /// Queues a plan for what has changed.
    pub(super) fn queue(&mut self) {
        match self {
            Self::Ok => *self = Self::Queued,
            Self::Queued => {}
            Self::Creating(creation) => creation.is_outdated = true,
        }
    }

    /// Starts to create a plan.
    pub(super) fn start(&mut self, revision: Revision, worker: Worker<Result<T, PostError>>) {
        *self = Self::Creating(Creation { revision, is_outdated: false, worker });
    }

    /// Whether something has changed for which no plan was started.
    pub(super) fn is_outdated(&self) -> bool {
        match self {
            Self::Ok => false,
            Self::Queued => true,
            Self::Creating(creation) => creation.is_outdated,
        }
    }

    /// Takes the plan that is being created. The next one is queued if it is outdated.
    pub(super) fn take(&mut self) -> Option<Creation<T>> {
        let next = if self.is_outdated() { Self::Queued } else { Self::Ok };
        match std::mem::replace(self, next) {
            Self::Creating(creation) => Some(creation),
            Self::Ok | Self::Queued => None,
        }
    }
}

impl<T: Send + 'static> PlanState<T> {
    /// Takes the plan that is being created if it is finished.
    pub(super) fn take_finished(&mut self) -> Option<Creation<T>> {
        let is_finished = matches!(self, Self::Creating(creation) if creation.worker.is_finished());
        if is_finished { self.take() } else { None }
    }
}

impl OwnedPlanRequest {
    /// Calls `use_request` with the request for the planner.
    pub(super) fn with<T>(&self, use_request: impl FnOnce(&PlanRequest<'_>) -> T) -> T {
        let requirement = |desc: &ImageDesc| heap::requirement(&self.device, desc);
        use_request(&PlanRequest {
            given: self.inputs.clone(),
            facts: self.facts.clone(),
            caps: self.caps.clone(),
            options: self.options,
            dynamic: self.dynamic.clone(),
            requirement: &requirement,
        })
    }

    pub(super) fn plan(&self, graph: &Graph) -> Result<UncachedPlan, PlanError> {
        self.with(|request| {
            Ok(UncachedPlan { key: PlanKey::new(graph, request), planned: Arc::new(Planned::new(graph, request)?) })
        })
    }
}
