//! Plans: the one that renders, and the one that is being made.

use std::collections::BTreeSet;
use std::sync::Arc;

use afterimage_graph::check::{Facts, Graph, ParameterId};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_plan::{Caps, DynamicNodes, HostInputs, Options, Plan, PlanError, PlanKey, PlanRequest, Planned};
use wgpu::Device;

use super::error::PostError;
use super::fade_skip_reason::FadeSkipReason;
use super::mix::FadeParts;
use super::uniforms::Uniforms;
use crate::executor::Prepared;
use crate::heap;
use crate::platform::Worker;

/// What a plan is wanted for: a [`PlanRequest`] that can go to another thread.
pub(super) struct OwnedPlanRequest {
    pub(super) given: HostInputs,
    pub(super) facts: Facts,
    pub(super) caps: Caps,
    pub(super) options: Options,
    pub(super) dynamic: BTreeSet<ParameterId>,
}

impl OwnedPlanRequest {
    /// Calls `use_request` with the request for a device, and returns the wish again.
    pub(super) fn on<T>(self, device: &Device, use_request: impl FnOnce(&PlanRequest<'_>) -> T) -> (T, Self) {
        let Self { given, facts, caps, options, dynamic } = self;
        let requirement = &|desc: &ImageDesc| heap::requirement(device, desc);
        let request = PlanRequest { given, facts, caps, options, dynamic, requirement };
        let result = use_request(&request);
        let PlanRequest { given, facts, caps, options, dynamic, requirement: _ } = request;
        (result, Self { given, facts, caps, options, dynamic })
    }

    /// Makes the plan.
    pub(super) fn planned(self, device: &Device, graph: &Graph) -> Result<(UncachedPlan, Self), PlanError> {
        let (planned, wish) = self.on(device, |request| {
            Ok(UncachedPlan { key: PlanKey::new(graph, request), planned: Arc::new(Planned::new(graph, request)?) })
        });
        Ok((planned?, wish))
    }
}

/// A plan that the cache does not have yet.
pub(super) struct UncachedPlan {
    pub(super) key: PlanKey,
    pub(super) planned: Arc<Planned>,
}

/// What plans are made of, by numbers that grow. A plan that was begun before may come in after a change.
#[derive(Clone, Copy, Default, PartialEq)]
pub(super) struct Revision {
    /// Graphs so far: a plan of another one fits neither nodes nor handles of the present one.
    pub(super) graph: u64,
    /// Changes of parameters that need plans: a plan of before renders, and is not kept for later.
    pub(super) values: u64,
}

/// The plan that renders.
pub(super) struct ActivePlan {
    /// The number of its graph.
    pub(super) graph: u64,
    pub(super) given: HostInputs,
    pub(super) plan: Arc<Plan>,
    pub(super) dynamic: DynamicNodes,
    pub(super) uniforms: Uniforms,
}

/// A plan that is being made and compiled.
pub(super) struct PendingPlan {
    pub(super) age: Revision,
    /// Nodes whose values have changed since it was begun.
    pub(super) changed: Vec<usize>,
    pub(super) worker: Worker<Result<Ready, PostError>>,
}

/// A plan that can come in.
pub(super) struct Ready {
    pub(super) running: ActivePlan,
    pub(super) prepared: Prepared,
    /// The plan for the cache, unless it was known.
    pub(super) new: Option<UncachedPlan>,
    /// What a fade to it needs, if changes were to be faded when it was begun.
    pub(super) parts: Option<Result<FadeParts, FadeSkipReason>>,
}

/// The sizes of frames that a host expects.
#[derive(Default)]
pub(super) struct Sizes {
    pub(super) expected: Vec<Size>,
    /// Those without a plan.
    pub(super) missing: Vec<Size>,
    pub(super) next: Option<NextSize>,
}

/// A plan for an expected size that is being made and compiled.
pub(super) struct NextSize {
    pub(super) age: Revision,
    pub(super) worker: Worker<Result<UncachedPlan, PostError>>,
}

impl Sizes {
    /// The plans of all sizes are to be made again: the graph, a fact or an option is another one.
    pub(super) fn renew(&mut self) {
        self.missing.clone_from(&self.expected);
    }

    pub(super) fn for_another(&self) -> Self {
        Self { expected: self.expected.clone(), missing: self.expected.clone(), next: None }
    }
}
