//! Commands on any platform.

use super::{caught, scoped};
use crate::error::GpuError;

/// Records commands and submits them.
pub fn submit<E: From<GpuError>>(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    what: &str,
    record: impl FnOnce(&mut wgpu::CommandEncoder) -> Result<(), E>,
) -> Result<(), E> {
    scoped(device, what, || {
        let mut encoder = device.create_command_encoder(&Default::default());
        record(&mut encoder)?;
        caught(what, || queue.submit([encoder.finish()]))?;
        Ok(())
    })
}
