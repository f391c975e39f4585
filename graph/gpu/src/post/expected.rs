//! Frames that the host expects: their plans are made in advance, while the present one renders.

use afterimage_graph::image::Size;
use afterimage_plan::HostInputs;

use super::plan_state::{Creation, PlanState, UncachedPlan};

/// Plans are cached for these frames at a few facts.
pub(super) const MAX_EXPECTED: usize = 16;

/// A frame that a host expects.
#[derive(Clone)]
pub(super) enum ExpectedFrame {
    /// As the present one, but with images of this size.
    Size(Size),
    /// With these inputs.
    Inputs(Box<HostInputs>),
}

pub(super) struct ExpectedPlan {
    frame: ExpectedFrame,
    pub(super) state: PlanState<UncachedPlan>,
}

/// The plans of frames that a host expects. One is created at a time.
#[derive(Default)]
pub(super) struct ExpectedPlans(Vec<ExpectedPlan>);

impl ExpectedPlans {
    /// Replaces the expected sizes.
    pub(super) fn set_sizes(&mut self, sizes: &[Size]) {
        self.0.retain(|plan| matches!(plan.frame, ExpectedFrame::Inputs(_)));
        self.0.extend(sizes.iter().map(|size| ExpectedPlan::queued(ExpectedFrame::Size(*size))));
    }

    /// Replaces the expected frames that are more than a size.
    pub(super) fn set_frames(&mut self, frames: impl IntoIterator<Item = HostInputs>) {
        self.0.retain(|plan| matches!(plan.frame, ExpectedFrame::Size(_)));
        self.0.extend(frames.into_iter().map(|inputs| ExpectedPlan::queued(ExpectedFrame::Inputs(Box::new(inputs)))));
    }

    /// The same frames for another view or device.
    pub(super) fn without_plans(&self) -> Self {
        Self(self.0.iter().map(|plan| ExpectedPlan::queued(plan.frame.clone())).collect())
    }

    /// Queues all plans again, because the graph, a fact or an option has changed.
    pub(super) fn queue_all(&mut self) {
        for plan in &mut self.0 {
            plan.state.queue();
        }
    }

    /// Whether all plans are made.
    pub(super) fn are_ready(&self) -> bool {
        self.0.iter().all(|plan| matches!(plan.state, PlanState::Ok))
    }

    /// The next queued plan, unless one is being created.
    pub(super) fn next(&mut self) -> Option<&mut ExpectedPlan> {
        if self.0.iter().any(|plan| matches!(plan.state, PlanState::Creating(_))) {
            return None;
        }
        self.0.iter_mut().find(|plan| matches!(plan.state, PlanState::Queued))
    }

    /// Takes the plan that is being created if it is finished.
    pub(super) fn take_finished(&mut self) -> Option<Creation<UncachedPlan>> {
        self.0.iter_mut().find_map(|plan| plan.state.take_finished())
    }
}

impl ExpectedPlan {
    fn queued(frame: ExpectedFrame) -> Self {
        Self { frame, state: PlanState::Queued }
    }

    /// The inputs of the plan; those of the present one are `inputs`.
    pub(super) fn inputs(&self, inputs: &HostInputs) -> HostInputs {
        match &self.frame {
            ExpectedFrame::Size(size) => at_size(inputs, *size),
            ExpectedFrame::Inputs(expected) => (**expected).clone(),
        }
    }
}

/// The host's inputs at another size of the frame: images of the present size have the new one.
pub(super) fn at_size(inputs: &HostInputs, size: Size) -> HostInputs {
    let mut other = HostInputs { size, ..inputs.clone() };
    for image in other.inputs.values_mut() {
        if image.desc.size == inputs.size {
            image.desc.size = size;
        }
    }
    other
}
