//! Tables, values and pass times that the host reads back without a wait.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use afterimage_plan::Plan;
use wgpu::{Buffer, BufferUsages, CommandEncoder, Device, MapMode};

use super::pass_times::TimedPasses;
use crate::buffer::buffer;
use crate::error::GpuError;
use crate::executor::Executor;
use crate::platform::watched;

/// Copies in flight at once: frames that a device is behind its host, and one to read.
const MAX_COPIES: usize = 4;

/// A table or value of a node that is read back after every frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Watch(usize);

/// The contents of a table or value after a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reading {
    /// The number of the frame, as [`Post::frame`](super::Post::frame) counts them.
    pub frame: u64,
    /// The bytes.
    pub bytes: Vec<u8>,
}

impl Reading {
    /// The four numbers of a value; `None` for a table.
    pub fn value(&self) -> Option<[f32; 4]> {
        (self.bytes.len() == size_of::<[f32; 4]>()).then(|| bytemuck::pod_read_unaligned(&self.bytes))
    }
}

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

/// The copies of a buffer in flight, and the newest one that has arrived.
#[derive(Default)]
pub(super) struct BufferCopies {
    copies: Vec<Copy>,
    pub(super) latest: Option<Reading>,
}

struct Copy {
    buffer: Buffer,
    frame: u64,
    state: Arc<AtomicU8>,
}

/// No frame uses it.
const FREE: u8 = 0;
/// A frame that copies into it is recorded.
const RECORDED: u8 = 1;
/// The frame is submitted, and the device will map the copy.
const MAPPING: u8 = 2;
/// It can be read.
const MAPPED: u8 = 3;

impl Readings {
    /// Reads a buffer back from now on.
    pub(super) fn watch(&mut self, label: &str) -> Watch {
        if let Some(known) = self.watched.iter().position(|watched| watched.label == label) {
            return Watch(known);
        }
        self.watched.push(WatchedBuffer { label: label.to_owned(), copies: BufferCopies::default() });
        Watch(self.watched.len() - 1)
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

impl BufferCopies {
    /// Drops the copies of a lost device; the newest reading stays.
    pub(super) fn reset(&mut self) {
        self.copies.clear();
    }

    /// Reads the copies that are mapped, and maps those of the frames that were recorded before.
    pub(super) fn collect(&mut self) -> Result<(), GpuError> {
        for copy in &self.copies {
            match copy.state.load(Ordering::Acquire) {
                RECORDED => copy.map(),
                MAPPED => {
                    let mapped = copy.buffer.get_mapped_range(..).map_err(|error| GpuError::lost(&error))?;
                    let reading = Reading { frame: copy.frame, bytes: mapped.to_vec() };
                    drop(mapped);
                    copy.buffer.unmap();
                    copy.state.store(FREE, Ordering::Release);
                    if self.latest.as_ref().is_none_or(|latest| latest.frame < reading.frame) {
                        self.latest = Some(reading);
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Copies the buffer at the end of a frame, if a copy is free.
    pub(super) fn record(
        &mut self,
        device: &Device,
        source: &Buffer,
        frame: u64,
        encoder: &mut CommandEncoder,
    ) -> Result<(), GpuError> {
        if self.copies.first().is_none_or(|copy| copy.buffer.size() != source.size()) {
            let make = || Ok((0..MAX_COPIES).map(|_| Copy::new(device, source.size())).collect());
            self.copies = watched(device, "a read-back", make)?;
        }
        let is_free = |copy: &&mut Copy| copy.state.load(Ordering::Acquire) == FREE;
        if let Some(copy) = self.copies.iter_mut().find(is_free) {
            encoder.copy_buffer_to_buffer(source, 0, &copy.buffer, 0, None);
            copy.frame = frame;
            copy.state.store(RECORDED, Ordering::Release);
        }
        Ok(())
    }
}

impl Copy {
    fn new(device: &Device, bytes: u64) -> Self {
        let buffer = buffer(device, "read-back", bytes, BufferUsages::COPY_DST | BufferUsages::MAP_READ);
        Self { buffer, frame: 0, state: Arc::new(AtomicU8::new(FREE)) }
    }

    fn map(&self) {
        self.state.store(MAPPING, Ordering::Release);
        let state = self.state.clone();
        // A copy that the device does not map stays out of use: the device is lost.
        self.buffer.map_async(MapMode::Read, .., move |mapped| {
            if mapped.is_ok() {
                state.store(MAPPED, Ordering::Release);
            }
        });
    }
}
