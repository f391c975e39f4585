//! GPU time of every pass, by timestamps inside the one compute pass.

use crate::buffer::buffer;
use crate::error::GpuError;
use crate::platform::watched;
#[cfg(not(target_family = "wasm"))]
use crate::stream::map;

/// Timestamps around the passes of one frame.
pub(crate) struct Timing {
    pub(crate) queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
    count: u32,
    period_ns: f32,
}

impl Timing {
    /// Timestamps for `passes` passes; `None` where the device has no timestamps inside passes.
    ///
    /// # Errors
    /// The device is lost or has no memory for them.
    pub(crate) fn watched(device: &wgpu::Device, queue: &wgpu::Queue, passes: u32) -> Result<Option<Self>, GpuError> {
        watched(device, "the times of passes", || Ok(Self::new(device, queue, passes)))
    }

    /// As [`watched`](Self::watched), where the caller watches.
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue, passes: u32) -> Option<Self> {
        let needed = wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        if !device.features().contains(needed) {
            return None;
        }
        let count = passes + 1;
        let queries = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("pass times"),
            ty: wgpu::QueryType::Timestamp,
            count,
        });
        let buffer = |usage| buffer(device, "pass times", u64::from(count) * 8, usage);
        let resolved = buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
        let readable = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        Some(Self { queries, resolved, readable, count, period_ns: queue.get_timestamp_period() })
    }

    /// Copies the timestamps to where the host can read them.
    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..self.count, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readable, 0, u64::from(self.count) * 8);
    }

    /// Milliseconds of each pass of the frame submitted last. Waits for it.
    ///
    /// # Errors
    /// The device is lost.
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn read(&self, device: &wgpu::Device) -> Result<Vec<f64>, GpuError> {
        map(device, &self.readable, wgpu::MapMode::Read)?;
        let ticks: Vec<u64> = {
            let bytes = self.readable.slice(..).get_mapped_range().map_err(|error| GpuError::lost(&error))?;
            bytes.chunks_exact(8).map(|b| u64::from_le_bytes(b.try_into().expect("chunks of eight"))).collect()
        };
        self.readable.unmap();
        Ok(between(&ticks, self.period_ns))
    }

    /// The buffer with the timestamps of the frame that is recorded, and the nanoseconds of a tick.
    pub(crate) fn timestamps(&self) -> (&wgpu::Buffer, f32) {
        (&self.resolved, self.period_ns)
    }
}

/// Milliseconds between each two timestamps.
pub fn between(ticks: &[u64], period_ns: f32) -> Vec<f64> {
    let ms = |pair: &[u64]| pair[1].saturating_sub(pair[0]) as f64 * f64::from(period_ns) * 1e-6;
    ticks.windows(2).map(ms).collect()
}
