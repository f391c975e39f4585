//! Buffers that the host reads when they arrive, without a wait.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use afterimage_gpu::wgpu;

/// A buffer that commands fill, that is mapped after they are submitted, and that is read once it has arrived.
pub(super) struct Readback {
    pub(super) buffer: wgpu::Buffer,
    has_arrived: Arc<AtomicBool>,
    is_requested: bool,
}

impl Readback {
    /// A buffer for that many bytes.
    pub(super) fn new(device: &wgpu::Device, bytes: u64) -> Self {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("reading"),
            size: bytes.max(4),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        Self { buffer, has_arrived: Arc::default(), is_requested: false }
    }

    /// Maps the buffer, once; call it after the commands that fill it are submitted.
    pub(super) fn request(&mut self) {
        if !std::mem::replace(&mut self.is_requested, true) {
            let has_arrived = self.has_arrived.clone();
            self.buffer.map_async(wgpu::MapMode::Read, .., move |mapped| {
                has_arrived.store(mapped.is_ok(), Ordering::Release);
            });
        }
    }

    /// The bytes, if they have arrived.
    pub(super) fn bytes(&self) -> Option<Vec<u8>> {
        if !self.has_arrived.load(Ordering::Acquire) {
            return None;
        }
        Some(self.buffer.get_mapped_range(..).ok()?.to_vec())
    }
}
