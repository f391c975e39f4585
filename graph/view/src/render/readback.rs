//! Buffers that the host reads when they arrive, without a wait.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use afterimage_gpu::wgpu;

/// A buffer on its way to the host: filled by commands, asked for after they are submitted, then read.
pub(super) struct Arriving {
    pub(super) buffer: wgpu::Buffer,
    has_arrived: Arc<AtomicBool>,
    is_asked: bool,
}

impl Arriving {
    /// A buffer for that many bytes.
    pub(super) fn new(device: &wgpu::Device, bytes: u64) -> Self {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("reading"),
            size: bytes.max(4),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        Self { buffer, has_arrived: Arc::default(), is_asked: false }
    }

    /// Asks for the bytes once; call it after the commands that fill the buffer are submitted.
    pub(super) fn ask(&mut self) {
        if !std::mem::replace(&mut self.is_asked, true) {
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
