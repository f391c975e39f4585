//! The uniforms of a plan, and the copies by which frames change them.

use std::ops::Range;

use wgpu::util::StagingBelt;
use wgpu::{BufferSize, BufferUsages, CommandEncoder, Device};

use crate::buffer::filled_buffer;
use crate::error::GpuError;
use crate::platform::{caught, without_memory};

/// The usages of a buffer with the uniforms of a plan, of which some devices read those of passes as storage.
pub(crate) const UNIFORMS: BufferUsages =
    BufferUsages::UNIFORM.union(BufferUsages::STORAGE).union(BufferUsages::COPY_DST);

/// The uniforms of a plan. A change is copied by the commands of the next frame, so that it comes after the frames that
/// were recorded before, also if these are not submitted yet.
pub(crate) struct Uniforms {
    pub(crate) buffer: wgpu::Buffer,
    /// The values of the next frame.
    bytes: Vec<u8>,
    /// The range that no recorded frame has copied.
    unwritten: Option<Range<usize>>,
}

impl Uniforms {
    pub(crate) fn new(device: &Device, bytes: &[u8]) -> Result<Self, GpuError> {
        let buffer = filled_buffer(device, "uniforms", bytes, UNIFORMS)?;
        Ok(Self { buffer, bytes: bytes.to_vec(), unwritten: None })
    }

    /// Changes bytes from the next frame on. Offset and length are multiples of four.
    pub(crate) fn set(&mut self, offset: u64, bytes: &[u8]) {
        let range = offset as usize..offset as usize + bytes.len();
        let known = &mut self.bytes[range.clone()];
        if known != bytes {
            known.copy_from_slice(bytes);
            let before = self.unwritten.take().unwrap_or(range.clone());
            self.unwritten = Some(before.start.min(range.start)..before.end.max(range.end));
        }
    }

    /// The values of the next frame.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Has the next frame copy all bytes: one that was recorded may not run.
    pub(crate) fn invalidate(&mut self) {
        self.unwritten = Some(0..self.bytes.len());
    }

    /// Copies what has changed since the frame before.
    pub(crate) fn write(
        &mut self,
        device: &Device,
        staging: &mut Staging,
        encoder: &mut CommandEncoder,
    ) -> Result<(), GpuError> {
        let Some(range) = self.unwritten.clone() else { return Ok(()) };
        let bytes = &self.bytes[range.clone()];
        staging.write(device, "the parameters of a frame", encoder, &self.buffer, range.start as u64, bytes)?;
        self.unwritten = None;
        Ok(())
    }
}

/// Bytes on their way to the device, in the order of the encoders that take them.
pub(crate) struct Staging(StagingBelt);

impl Staging {
    /// Bytes of a buffer that several frames share.
    const CHUNK: u64 = 4096;

    pub(crate) fn new(device: &Device) -> Self {
        Self(StagingBelt::new(device.clone(), Self::CHUNK))
    }

    /// Records a copy of these bytes into a buffer. Offset and length are multiples of four.
    ///
    /// # Errors
    /// There is no memory for them; nothing is recorded.
    pub(crate) fn write(
        &mut self,
        device: &Device,
        what: &str,
        encoder: &mut CommandEncoder,
        to: &wgpu::Buffer,
        offset: u64,
        bytes: &[u8],
    ) -> Result<(), GpuError> {
        let Some(size) = BufferSize::new(bytes.len() as u64) else { return Ok(()) };
        let copied = without_memory(device, what, || {
            let staged = self.0.allocate(size, BufferSize::MIN);
            let mut mapped = staged.get_mapped_range_mut().map_err(|error| GpuError::lost(&error))?;
            mapped.copy_from_slice(bytes);
            drop(mapped);
            encoder.copy_buffer_to_buffer(staged.buffer(), staged.offset(), to, offset, size.get());
            caught(what, || self.0.finish_and_recall_on_submit(encoder))
        });
        if copied.is_err() {
            // Its buffer is invalid.
            *self = Self::new(device);
        }
        copied
    }
}
