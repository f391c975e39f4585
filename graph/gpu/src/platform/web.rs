//! The web: one thread, and nothing may wait.

use crate::error::GpuError;
use crate::platform::TaskPool;

/// Work that is done at once.
pub(crate) struct Worker<T>(T);

impl<T> Worker<T> {
    pub(crate) fn new(_pool: Option<&TaskPool>, work: impl FnOnce() -> T) -> Self {
        Self(work())
    }

    pub(crate) fn is_finished(&self) -> bool {
        true
    }

    #[allow(clippy::unnecessary_wraps, reason = "threads may drop work")]
    pub(crate) fn join(self) -> Result<T, GpuError> {
        Ok(self.0)
    }
}

/// Does the work on the one thread that there is.
///
/// # Errors
/// None.
pub(crate) fn on_threads(_pool: Option<&TaskPool>, _count: usize, work: impl Fn()) -> Result<(), GpuError> {
    work();
    Ok(())
}

/// Calls `make`. WebGPU reports errors later, so they go to the error handler of the device.
pub(crate) fn watched<T>(
    _device: &wgpu::Device,
    _what: &str,
    make: impl FnOnce() -> Result<T, GpuError>,
) -> Result<T, GpuError> {
    make()
}

/// Calls a function of wgpu.
pub(crate) fn caught<T>(_what: &str, call: impl FnOnce() -> T) -> Result<T, GpuError> {
    Ok(call())
}

/// As [`watched`].
pub(crate) fn scoped<T, E: From<GpuError>>(
    _device: &wgpu::Device,
    _what: &str,
    make: impl FnOnce() -> Result<T, E>,
) -> Result<T, E> {
    make()
}

/// As [`watched`].
pub(crate) fn without_memory(
    _device: &wgpu::Device,
    _what: &str,
    make: impl FnOnce() -> Result<(), GpuError>,
) -> Result<(), GpuError> {
    make()
}
