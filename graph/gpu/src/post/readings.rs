//! Tables, values and pass times that the host reads back without a wait.

use std::sync::Arc;

use afterimage_plan::Plan;
use wgpu::CommandEncoder;

use super::buffer_copies::{BufferCopies, Reading};
use super::pass_times::TimedPasses;
use crate::error::GpuError;
use crate::executor::Executor;

/// A table or value of a node that is read back after every frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Watch(usize);

/// All that the host reads back after every frame.
#[derive(Default)]
pub(super) struct Readings {
    watched: Vec<WatchedBuffer>,
    pub(super) pass_times: TimedPasses,
}

struct WatchedBuffer {
    /// The label of the buffer, `node.port`.
    label: String,
    copies: BufferCopies,
}

impl Readings {
    /// Reads a buffer back from now on.
    pub(super) fn watch(&mut self, label: &str) -> Watch {
        if let Some(known) = self.watched.iter().position(|watched| watched.label == label) {
            return Watch(known);
        }
        self.watched.push(WatchedBuffer { label: label.to_owned(), copies: BufferCopies::default() });
        Watch(self.watched.len() - 1)
    }

    /// The labels of the buffers that are read back.
    pub(super) fn labels(&self) -> impl Iterator<Item = &str> {
        self.watched.iter().map(|watched| watched.label.as_str())
    }

    /// The newest reading of a buffer.
    pub(super) fn latest(&self, watch: Watch) -> Option<&Reading> {
        self.watched[watch.0].copies.latest.as_ref()
    }

    /// The same buffers for another view, without readings.
    pub(super) fn for_view(&self) -> Self {
        let mut readings = Self::default();
        for watched in &self.watched {
            readings.watch(&watched.label);
        }
        readings
    }

    /// Drops the copies of a lost device; the newest readings stay.
    pub(super) fn reset(&mut self) {
        for watched in &mut self.watched {
            watched.copies.reset();
        }
        self.pass_times.reset();
    }

    /// Takes the copies that have arrived, and copies the buffers at the end of a frame.
    pub(super) fn record(
        &mut self,
        executor: &Executor,
        plan: Option<&Arc<Plan>>,
        frame: u64,
        encoder: &mut CommandEncoder,
    ) -> Result<(), GpuError> {
        for WatchedBuffer { label, copies } in &mut self.watched {
            copies.collect()?;
            if let Some(buffer) = executor.buffer(label) {
                copies.record(executor.device(), buffer, frame, encoder)?;
            }
        }
        match plan {
            Some(plan) => self.pass_times.record(executor, plan, frame, encoder),
            None => Ok(()),
        }
    }
}
