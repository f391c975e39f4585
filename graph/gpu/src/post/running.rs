//! Plans: the one that renders, and the one that is being made.

use std::collections::BTreeSet;
use std::sync::Arc;

use afterimage_graph::check::{Facts, ParameterId};
use afterimage_graph::image::ImageDesc;
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

/// The plan that renders.
pub(super) struct Running {
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
    pub(super) wish: Wish,
    pub(super) worker: Worker<Result<(Planned, Prepared), PostError>>,
}
