//! The passes of a plan that run in a frame.

use afterimage_graph::node::{BufferId, Resource};
use afterimage_plan::{Plan, PlannedPass, Refresh, UniformBlock};

/// Chooses the passes that run in a frame, from the plan and from the uniforms that have changed.
pub(crate) struct DuePasses {
    /// For each pass, whether it runs in the frame that is recorded.
    due: Vec<bool>,
    /// For each pass, whether a cached result is computed from what it writes.
    feeds_cached: Vec<bool>,
    /// For each pass, whether no submitted frame is known to have run it on the memory of this plan.
    stale: Vec<bool>,
    /// The uniforms of the last frame.
    seen: Vec<u8>,
    /// True if only passes that depend on a changed uniform run.
    is_redraw: bool,
}

impl DuePasses {
    pub(crate) fn new(plan: &Plan, uniforms: &[u8]) -> Self {
        let count = plan.passes.len();
        let (feeds_cached, seen) = (plan.feeds_cached(), uniforms.to_vec());
        Self { due: vec![false; count], feeds_cached, stale: vec![true; count], seen, is_redraw: false }
    }

    /// Chooses the passes of a frame of that number, after one of the number `before`. Without one, all cached results
    /// are recomputed.
    pub(crate) fn choose(&mut self, plan: &Plan, uniforms: &[u8], number: u32, before: Option<u32>) {
        let dirties_cache = |pass: usize| self.feeds_cached[pass] && self.is_dirty(plan, pass, uniforms);
        let before = before.filter(|_| !(0..self.due.len()).any(dirties_cache));
        for pass in 0..self.due.len() {
            let mut refreshes = plan.passes[pass].refresh.iter();
            self.due[pass] = refreshes.any(|refresh| match refresh {
                Refresh::EachFrame => true,
                Refresh::OnChange => self.is_dirty(plan, pass, uniforms),
                Refresh::Every { .. } | Refresh::Once => before.is_none_or(|before| refresh.is_due(number, before)),
            });
        }
        self.is_redraw = false;
    }

    /// Chooses the passes that depend on a changed uniform, to draw the last frame again. `false` if a block of the
    /// host has changed, on which any pass may depend.
    pub(crate) fn choose_dependents(&mut self, plan: &Plan, uniforms: &[u8]) -> bool {
        if plan.blocks.iter().any(|own| self.differs(uniforms, own.offset, own.block.bytes())) {
            return false;
        }
        let blocks = plan.passes.iter().map(|pass| &pass.uniform);
        let dirty = blocks.map(|block| self.differs(uniforms, block.offset, block.bytes.len())).collect();
        self.due = plan.dependents(dirty);
        self.is_redraw = true;
        true
    }

    /// Chooses these passes and no other.
    pub(crate) fn choose_only(&mut self, passes: &[usize]) {
        self.due.fill(false);
        passes.iter().for_each(|pass| self.due[*pass] = true);
        self.is_redraw = false;
    }

    /// True if a pass runs in the frame.
    pub(crate) fn runs(&self, pass: usize) -> bool {
        self.due[pass]
    }

    /// True if a pass that runs in the frame writes a buffer.
    pub(crate) fn writes(&self, buffer: &WrittenBuffer) -> bool {
        buffer.writers.iter().any(|pass| self.due[*pass])
    }

    /// True if the frame runs a pass that runs after a change of its uniforms.
    pub(crate) fn any_on_change(&self, plan: &Plan) -> bool {
        (0..self.due.len()).any(|pass| self.due[pass] && plan.runs_on_change(pass))
    }

    /// The number of passes that run in a frame which draws the last one again; `None` for other frames.
    pub(crate) fn redrawn(&self) -> Option<usize> {
        self.is_redraw.then(|| self.due.iter().filter(|due| **due).count())
    }

    /// True if the next frame computes results that outlive it because they are stale, or because their uniforms have
    /// changed.
    pub(crate) fn renews_results(&self, plan: &Plan, uniforms: &[u8]) -> bool {
        let outlives = |pass: &usize| self.feeds_cached[*pass] || plan.runs_on_change(*pass);
        (0..self.due.len()).filter(outlives).any(|pass| self.is_dirty(plan, pass, uniforms))
    }

    /// Notes that a frame with these uniforms is recorded.
    pub(crate) fn finish(&mut self, uniforms: &[u8]) {
        self.seen.copy_from_slice(uniforms);
        self.stale.iter_mut().zip(&self.due).for_each(|(stale, due)| *stale &= !due);
    }

    /// Notes uniforms that the host states in each frame: no cached result is recomputed for them.
    pub(crate) fn ignore_change(&mut self, offset: u64, bytes: &[u8]) {
        if self.feeds_cached.contains(&true) {
            self.seen[offset as usize..][..bytes.len()].copy_from_slice(bytes);
        }
    }

    /// Recorded frames may never run: the next one computes all that it needs.
    pub(crate) fn invalidate(&mut self) {
        self.stale.fill(true);
    }

    /// Has the next frame run the passes that run after a change of their uniforms.
    pub(crate) fn force_on_change(&mut self, plan: &Plan) {
        let on_change = (0..self.stale.len()).filter(|pass| plan.runs_on_change(*pass));
        on_change.for_each(|pass| self.stale[pass] = true);
    }

    fn is_dirty(&self, plan: &Plan, pass: usize, uniforms: &[u8]) -> bool {
        let UniformBlock { offset, bytes, .. } = &plan.passes[pass].uniform;
        self.stale[pass] || self.differs(uniforms, *offset, bytes.len())
    }

    /// True if these bytes have changed since the last frame.
    fn differs(&self, uniforms: &[u8], offset: u64, length: usize) -> bool {
        let range = offset as usize..offset as usize + length;
        uniforms[range.clone()] != self.seen[range]
    }
}

/// A buffer of a plan and the passes that write it.
#[derive(Clone)]
pub(crate) struct WrittenBuffer {
    pub(crate) index: usize,
    writers: Vec<usize>,
}

impl WrittenBuffer {
    pub(crate) fn new(plan: &Plan, index: usize) -> Self {
        let buffer = Resource::Buffer(BufferId(index as u32));
        let writes = |(_, planned): &(usize, &PlannedPass)| planned.pass.writes().contains(&buffer);
        let writers = plan.passes.iter().enumerate().filter(writes).map(|(pass, _)| pass).collect();
        Self { index, writers }
    }
}
