//! A plan that renders, and its uniforms.

use std::ops::Range;
use std::sync::Arc;

use afterimage_gpu::Executor;
use afterimage_plan::{DynamicNodes, HostInputs, NeedsPlan, Plan, Planned};

use super::values::GraphValues;

/// A plan that renders: the newest one, or the previous one during a fade.
pub(super) struct ActivePlan {
    /// The revision of its graph.
    revision: u64,
    /// The host's images that it is made for.
    pub(super) inputs: HostInputs,
    pub(super) plan: Arc<Plan>,
    dynamic: DynamicNodes,
    /// The bytes of the plan's uniform buffer at the present values.
    pub(super) uniforms: Vec<u8>,
    /// The version of the node changes that the bytes have.
    version: u64,
    /// The range of bytes that the executor does not have yet.
    unwritten: Option<Range<usize>>,
}

impl ActivePlan {
    /// A plan with its uniforms at these values. Where they need another plan, the first frame finds that out again.
    pub(super) fn new(inputs: HostInputs, planned: &Planned, values: GraphValues<'_>) -> Self {
        let (plan, dynamic) = (planned.plan.clone(), planned.dynamic.clone());
        let uniforms = plan.uniform_buffer();
        let mut active =
            Self { revision: values.revision, inputs, plan, dynamic, uniforms, version: 0, unwritten: None };
        if active.update(values) == Err(NeedsPlan) {
            active.version = 0;
        }
        active.unwritten = None;
        active
    }

    /// The revision of the graph that it is a plan of.
    pub(super) fn revision(&self) -> u64 {
        self.revision
    }

    /// Records the nodes whose values have changed again. `values` are those of the graph of this plan.
    ///
    /// # Errors
    /// A node needs another plan. Its values stay as they are, and those of all others are taken.
    pub(super) fn update(&mut self, values: GraphValues<'_>) -> Result<(), NeedsPlan> {
        let changed = values.changes.since(self.version);
        self.version = values.changes.version();
        let Self { dynamic, uniforms, unwritten, .. } = self;
        let mut write = |offset: u64, new: &[u8]| {
            let range = offset as usize..offset as usize + new.len();
            if uniforms[range.clone()] != *new {
                uniforms[range.clone()].copy_from_slice(new);
                let before = unwritten.take().unwrap_or(range.clone());
                *unwritten = Some(before.start.min(range.start)..before.end.max(range.end));
            }
        };
        let mut all_fit = Ok(());
        for (node, _) in changed {
            all_fit = dynamic.uniforms(*node, &values.graph.nodes[*node].instance, &mut write).and(all_fit);
        }
        all_fit
    }

    /// Writes the uniforms that the executor of this plan does not have yet, in one range.
    pub(super) fn write(&mut self, executor: &mut Executor) {
        if let Some(range) = self.unwritten.take() {
            let loaded = executor.loaded_mut();
            loaded
                .into_iter()
                .for_each(|loaded| loaded.set_uniforms(range.start as u64, &self.uniforms[range.clone()]));
        }
    }
}
