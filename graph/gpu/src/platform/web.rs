//! The web: one thread, and nothing may wait.

use crate::error::GpuError;
use crate::platform::TaskPool;

/// Work that is done at once.
pub struct Worker<T>(T);

impl<T> Worker<T> {
    /// Does the work.
    pub fn new(_pool: Option<&TaskPool>, work: impl FnOnce() -> T) -> Self {
        Self(work())
    }

    /// Always `true`.
    pub fn is_finished(&self) -> bool {
        true
    }

    /// The result.
    ///
    /// # Errors
    /// None.
    #[allow(clippy::unnecessary_wraps, reason = "threads may drop work")]
    pub fn join(self) -> Result<T, GpuError> {
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
pub fn watched<T>(
    _device: &wgpu::Device,
    _what: &str,
    make: impl FnOnce() -> Result<T, GpuError>,
) -> Result<T, GpuError> {
    make()
}

/// Calls a function of wgpu.
pub fn caught<T>(_what: &str, call: impl FnOnce() -> T) -> Result<T, GpuError> {
    Ok(call())
}

/// As [`watched`].
pub fn scoped<T, E: From<GpuError>>(
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
