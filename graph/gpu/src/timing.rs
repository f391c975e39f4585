//! Timestamps on the GPU.

use crate::buffer::buffer;
use crate::error::GpuError;
use crate::platform::watched;
#[cfg(not(target_family = "wasm"))]
use crate::stream::read_mapped;

/// Timestamps of one frame, and the buffers through which the host reads them.
pub(crate) struct Timestamps {
    #[cfg(not(target_family = "wasm"))]
    device: wgpu::Device,
    pub(crate) queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
    count: u32,
    period_ns: f32,
}

impl Timestamps {
    /// Timestamps around each of `passes` passes; `None` where the device has none inside passes.
    ///
    /// # Errors
    /// The device is lost or has no memory for them.
    pub(crate) fn of_passes(device: &wgpu::Device, queue: &wgpu::Queue, passes: u32) -> Result<Option<Self>, GpuError> {
        let needed = wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let has_stamps = device.features().contains(needed);
        watched(device, "the times of passes", || Ok(has_stamps.then(|| Self::new(device, queue, passes + 1))))
    }

    /// That many timestamps, for a device that has them. The caller watches for errors.
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue, count: u32) -> Self {
        const LABEL: &str = "timestamps";
        let queries = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some(LABEL),
            ty: wgpu::QueryType::Timestamp,
            count,
        });
        let buffer = |usage| buffer(device, LABEL, u64::from(count) * 8, usage);
        Self {
            #[cfg(not(target_family = "wasm"))]
            device: device.clone(),
            queries,
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            readable: buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
            count,
            period_ns: queue.get_timestamp_period(),
        }
    }

    /// Copies the timestamps to where the host can read them.
    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..self.count, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readable, 0, u64::from(self.count) * 8);
    }

    /// Milliseconds between each two timestamps of the frame submitted last. Waits for it.
    ///
    /// # Errors
    /// The device is lost.
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn read(&self) -> Result<Vec<f64>, GpuError> {
        let ticks: Vec<u64> = read_mapped(&self.device, &self.readable, |bytes| {
            bytes.chunks_exact(8).map(|b| u64::from_le_bytes(b.try_into().expect("chunks of eight"))).collect()
        })?;
        Ok(between(&ticks, self.period_ns))
    }

    /// The buffer with the timestamps of the frame that is recorded, and the nanoseconds of a tick.
    pub(crate) fn resolved(&self) -> (&wgpu::Buffer, f32) {
        (&self.resolved, self.period_ns)
    }
}

/// Milliseconds between each two timestamps.
pub fn between(ticks: &[u64], period_ns: f32) -> Vec<f64> {
    let ms = |pair: &[u64]| pair[1].saturating_sub(pair[0]) as f64 * f64::from(period_ns) * 1e-6;
    ticks.windows(2).map(ms).collect()
}
