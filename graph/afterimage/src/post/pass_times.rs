//! Times of passes that the host reads without a wait.

use std::sync::{Arc, Weak};

use afterimage_gpu::wgpu::CommandEncoder;
use afterimage_gpu::{Executor, GpuError, LoadedPlan, internal};
use afterimage_plan::Plan;

use super::buffer_copies::BufferCopies;

/// The GPU time of each pass of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTimes {
    /// The number of the frame, as [`Post::frame`](crate::Post::frame) counts them.
    pub frame: u64,
    /// Milliseconds of each pass, in the order of [`Plan::passes`]; what lies between two passes counts for the first.
    pub ms: Vec<f64>,
}

impl PassTimes {
    /// Milliseconds of the whole frame.
    pub fn sum(&self) -> f64 {
        self.ms.iter().sum()
    }
}

/// The times of the plan that renders.
#[derive(Default)]
pub(super) struct TimedPasses {
    copies: BufferCopies,
    plan: Weak<Plan>,
    pub(super) latest: Option<PassTimes>,
}

impl TimedPasses {
    /// Drops the copies of a lost device.
    pub(super) fn reset(&mut self) {
        self.copies.reset();
    }

    /// Takes the times that have arrived, and copies those of the frame that is recorded.
    pub(super) fn record(
        &mut self,
        executor: &Executor,
        plan: &Arc<Plan>,
        frame: u64,
        encoder: &mut CommandEncoder,
    ) -> Result<(), GpuError> {
        let loaded = executor.loaded();
        let Some((timestamps, period_ns)) = loaded.and_then(LoadedPlan::timestamps) else { return Ok(()) };
        if !std::ptr::eq(self.plan.as_ptr(), Arc::as_ptr(plan)) {
            // Copies of the previous plan have other passes.
            *self = Self { plan: Arc::downgrade(plan), ..Self::default() };
        }
        self.copies.collect()?;
        if let Some(reading) = &self.copies.latest {
            let ms = milliseconds(&reading.bytes, period_ns);
            self.latest = Some(PassTimes { frame: reading.frame, ms });
        }
        // A redraw runs some of the passes, whose times are no frame.
        match loaded.is_some_and(|loaded| loaded.passes_redrawn().is_some()) {
            true => Ok(()),
            false => self.copies.record(&executor.compiler.device, timestamps, frame, encoder),
        }
    }
}

/// The times between timestamps.
fn milliseconds(bytes: &[u8], period_ns: f32) -> Vec<f64> {
    let ticks: Vec<u64> = bytes.chunks_exact(size_of::<u64>()).map(bytemuck::pod_read_unaligned).collect();
    internal::between(&ticks, period_ns)
}
