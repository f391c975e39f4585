//! Tables, values and pass times that the host reads back without a wait.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use afterimage_plan::Plan;
use wgpu::CommandEncoder;

use super::buffer_copies::{BufferCopies, Reading};
use super::error::PostError;
use super::pass_times::TimedPasses;
use crate::error::GpuError;
use crate::executor::Executor;

/// A table or value of a node that is read back after every frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Watch(u64);

impl Watch {
    /// A new one. No two are equal, so that one of another pipeline is known as such.
    fn next() -> Self {
        static WATCHES: AtomicU64 = AtomicU64::new(0);
        Self(WATCHES.fetch_add(1, Ordering::Relaxed))
    }
}

/// All that the host reads back after every frame.
#[derive(Default)]
pub(super) struct Readings {
    watched: Vec<WatchedBuffer>,
    pub(super) pass_times: TimedPasses,
}

struct WatchedBuffer {
    watch: Watch,
    /// The label of the buffer, `node.port`.
    label: String,
    copies: BufferCopies,
}

impl Readings {
    /// Reads a buffer back from now on.
    pub(super) fn watch(&mut self, label: &str) -> Watch {
        if let Some(known) = self.watched.iter().find(|watched| watched.label == label) {
            return known.watch;
        }
        let watch = Watch::next();
        self.watched.push(WatchedBuffer { watch, label: label.to_owned(), copies: BufferCopies::default() });
        watch
    }

    /// The labels of the buffers that are read back.
    pub(super) fn labels(&self) -> impl Iterator<Item = &str> {
        self.watched.iter().map(|watched| watched.label.as_str())
    }

    /// The newest reading of a buffer.
    ///
    /// # Errors
    /// The watch is of another pipeline.
    pub(super) fn latest(&self, watch: Watch) -> Result<Option<&Reading>, PostError> {
        let watched = self.watched.iter().find(|watched| watched.watch == watch);
        watched.map(|watched| watched.copies.latest.as_ref()).ok_or(PostError::UnknownHandle)
    }

    /// The same buffers for another view, without readings.
    pub(super) fn for_view(&self) -> Self {
        let watched = self.watched.iter().map(|WatchedBuffer { watch, label, .. }| WatchedBuffer {
            watch: *watch,
            label: label.clone(),
            copies: BufferCopies::default(),
        });
        Self { watched: watched.collect(), pass_times: TimedPasses::default() }
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
        for WatchedBuffer { label, copies, .. } in &mut self.watched {
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
