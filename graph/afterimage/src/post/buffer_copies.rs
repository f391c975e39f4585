//! Copies of a buffer that arrive at the host some frames later.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use afterimage_gpu::GpuError;
use afterimage_gpu::internal::{buffer, watched};
use afterimage_gpu::wgpu::{Buffer, BufferUsages, CommandEncoder, Device, MapMode};

/// Copies in flight at once: frames that a device is behind its host, and one to read.
const MAX_COPIES: usize = 4;

/// The contents of a table or value after a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reading {
    /// The number of the frame, as [`Post::frame`](crate::Post::frame) counts them.
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
/// A frame that copies into it is recorded. It is mapped after that was submitted.
const RECORDED: u8 = 1;
/// It can be read.
const MAPPED: u8 = 2;

/// The state of a copy that a recorded frame will set.
struct Recorded(Arc<AtomicU8>);

impl Drop for Recorded {
    /// A frame that is not submitted, or not run by the device, frees the copy.
    fn drop(&mut self) {
        let _ = self.0.compare_exchange(RECORDED, FREE, Ordering::AcqRel, Ordering::Relaxed);
    }
}

impl BufferCopies {
    /// Drops the copies of a lost device; the newest reading stays.
    pub(super) fn reset(&mut self) {
        self.copies.clear();
    }

    /// Reads the copies that are mapped.
    pub(super) fn collect(&mut self) -> Result<(), GpuError> {
        for copy in &self.copies {
            if copy.state.load(Ordering::Acquire) != MAPPED {
                continue;
            }
            let mapped = copy.buffer.get_mapped_range(..).map_err(|error| GpuError::lost(&error))?;
            let reading = Reading { frame: copy.frame, bytes: mapped.to_vec() };
            drop(mapped);
            copy.buffer.unmap();
            copy.state.store(FREE, Ordering::Release);
            if self.latest.as_ref().is_none_or(|latest| latest.frame < reading.frame) {
                self.latest = Some(reading);
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
            copy.map_after(encoder);
        }
        Ok(())
    }
}

impl Copy {
    fn new(device: &Device, bytes: u64) -> Self {
        let buffer = buffer(device, "read-back", bytes, BufferUsages::COPY_DST | BufferUsages::MAP_READ);
        Self { buffer, frame: 0, state: Arc::new(AtomicU8::new(FREE)) }
    }

    fn map_after(&self, encoder: &CommandEncoder) {
        self.state.store(RECORDED, Ordering::Release);
        let recorded = Recorded(self.state.clone());
        encoder.map_buffer_on_submit(&self.buffer, MapMode::Read, .., move |mapped| {
            if mapped.is_ok() {
                recorded.0.store(MAPPED, Ordering::Release);
            }
        });
    }
}
