//! Tables, values and pass times that the host reads back without a wait.

use std::sync::Arc;

use afterimage_gpu::wgpu::CommandEncoder;
use afterimage_gpu::{Executor, GpuError};
use afterimage_plan::Plan;

use super::buffer_copies::{BufferCopies, Reading};
use super::handles::{Handle, Handles};
use super::pass_times::TimedPasses;
use crate::error::PostError;

slotmap::new_key_type! {
    /// A table or value of a node that is read back after every frame.
    pub struct Watch;
}

static WATCHES: Handles<Watch> = Handles::new();

/// All that the host reads back after every frame.
#[derive(Default)]
pub(super) struct Readings {
    /// In the order in which the host asked for them.
    watched: Vec<WatchedBuffer>,
    pub(super) pass_times: TimedPasses,
}

struct WatchedBuffer {
    handle: Arc<Handle<Watch>>,
    /// The label of the buffer, `node.port`.
    label: String,
    copies: BufferCopies,
}

impl Readings {
    /// Reads a buffer back from now on.
    pub(super) fn watch(&mut self, label: &str) -> Watch {
        if let Some(known) = self.watched.iter().find(|watched| watched.label == label) {
            return known.handle.key();
        }
        let handle = Arc::new(WATCHES.add(label));
        let watch = handle.key();
        self.watched.push(WatchedBuffer { handle, label: label.to_owned(), copies: BufferCopies::default() });
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
        let watched = self.watched.iter().find(|watched| watched.handle.key() == watch);
        let watched = watched.ok_or_else(|| PostError::UnknownHandle(WATCHES.name(watch)))?;
        Ok(watched.copies.latest.as_ref())
    }

    /// The same buffers for another view, without readings.
    pub(super) fn for_view(&self) -> Self {
        let watched = self.watched.iter().map(|WatchedBuffer { handle, label, .. }| WatchedBuffer {
            handle: handle.clone(),
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
            if let Some(buffer) = executor.loaded().and_then(|loaded| loaded.buffer(label)) {
                copies.record(&executor.compiler.device, buffer, frame, encoder)?;
            }
        }
        match plan {
            Some(plan) => self.pass_times.record(executor, plan, frame, encoder),
            None => Ok(()),
        }
    }
}
