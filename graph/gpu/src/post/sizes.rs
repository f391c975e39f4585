//! Sizes that the host expects: their plans are made in advance, while the present one renders.

use afterimage_graph::image::Size;
use afterimage_plan::HostInputs;

use super::error::PostError;
use super::pending::{Revision, UncachedPlan};
use crate::platform::Worker;

/// Plans are cached for these sizes at a few facts.
pub(super) const MAX_SIZES: usize = 16;

/// The sizes of frames that a host expects.
#[derive(Default)]
pub(super) struct ExpectedSizes {
    sizes: Vec<Size>,
    /// Those without a plan; the last is the next.
    missing: Vec<Size>,
    creating: Option<(Revision, Worker<Result<UncachedPlan, PostError>>)>,
}

impl ExpectedSizes {
    pub(super) fn set(&mut self, sizes: &[Size]) {
        self.sizes = sizes.to_vec();
        self.queue_all();
    }

    /// The same sizes for another view or device.
    pub(super) fn without_plans(&self) -> Self {
        Self { sizes: self.sizes.clone(), missing: self.sizes.clone(), creating: None }
    }

    /// Queues the plans of all sizes again, because the graph, a fact or an option has changed.
    pub(super) fn queue_all(&mut self) {
        self.missing.clone_from(&self.sizes);
    }

    /// Whether the plans of all sizes are made.
    pub(super) fn are_ready(&self) -> bool {
        self.missing.is_empty() && self.creating.is_none()
    }

    /// The next size without a plan, unless one is being created.
    pub(super) fn next(&mut self) -> Option<Size> {
        if self.creating.is_some() { None } else { self.missing.pop() }
    }

    pub(super) fn start(&mut self, revision: Revision, worker: Worker<Result<UncachedPlan, PostError>>) {
        self.creating = Some((revision, worker));
    }

    /// Takes the plan of a size if it is finished, with the revision that it was made for.
    pub(super) fn take_finished(&mut self) -> Option<(Revision, Result<UncachedPlan, PostError>)> {
        let (revision, worker) = self.creating.take_if(|(_, worker)| worker.is_finished())?;
        Some((revision, worker.join().map_err(PostError::from).and_then(|plan| plan)))
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
