//! Plans: the one that renders, and the one that is being made.

use std::collections::BTreeSet;
use std::sync::Arc;

use afterimage_graph::check::{Facts, ParameterId};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_plan::{Caps, Given, Options, Plan, PlanRequest, Planned};
use wgpu::Device;

use super::error::PostError;
use super::uniforms::Uniforms;
use crate::executor::Prepared;
use crate::heap;
use crate::platform::Worker;

/// What a plan is wanted for: a [`PlanRequest`] that can go to another thread.
#[derive(Clone)]
pub(super) struct Wish {
    pub(super) given: Given,
    pub(super) facts: Facts,
    pub(super) caps: Caps,
    pub(super) options: Options,
    pub(super) dynamic: BTreeSet<ParameterId>,
}

impl Wish {
    /// Calls `use_request` with the request for a device.
    pub(super) fn on<T>(&self, device: &Device, use_request: impl FnOnce(&PlanRequest<'_>) -> T) -> T {
        let Self { given, facts, caps, options, dynamic } = self.clone();
        let requirement = &|desc: &ImageDesc| heap::requirement(device, desc);
        use_request(&PlanRequest { given, facts, caps, options, dynamic, requirement })
    }
}

/// What plans are made of, by numbers that grow. A plan that was begun before may come in after a change.
#[derive(Clone, Copy, Default, PartialEq)]
pub(super) struct Age {
    /// Graphs so far: a plan of another one fits neither nodes nor handles of the present one.
    pub(super) graph: u64,
    /// Changes of parameters that need plans: a plan of before renders, and is not kept for later.
    pub(super) values: u64,
}

/// The plan that renders.
pub(super) struct Running {
    /// The number of its graph.
    pub(super) graph: u64,
    pub(super) given: Given,
    pub(super) planned: Planned,
    pub(super) uniforms: Uniforms,
}

impl Running {
    pub(super) fn plan(&self) -> &Arc<Plan> {
        &self.planned.plan
    }
}

/// A plan that is being made and compiled.
pub(super) struct Next {
    pub(super) age: Age,
    pub(super) wish: Wish,
    pub(super) worker: Worker<Result<(Planned, Prepared), PostError>>,
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
    pub(super) age: Age,
    pub(super) wish: Wish,
    pub(super) worker: Worker<Result<Planned, PostError>>,
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
