//! The device of pipelines that are rendered offline.

use std::sync::{Mutex, PoisonError};

use afterimage_gpu::{Gpu, GpuError, Opening};

/// The device that all pipelines share, and the name by which it was asked for.
static GPU: Mutex<Option<(Option<String>, Gpu)>> = Mutex::new(None);

/// The device of that name, opened once.
pub(super) fn open(adapter: Option<&str>) -> Result<Gpu, GpuError> {
    let mut known = GPU.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, gpu)) = known.as_ref().filter(|(name, _)| name.as_deref() == adapter) {
        return Ok(gpu.clone());
    }
    let mut gpu = Gpu::open(&Opening { adapter: adapter.map(str::to_owned), ..Opening::default() })?;
    // As the program does: lavapipe runs draws faster.
    gpu.caps.prefer_fragment = gpu.is_processor();
    *known = Some((adapter.map(str::to_owned), gpu.clone()));
    Ok(gpu)
}

/// The next frame of any pipeline opens a device again.
pub(super) fn forget() {
    *GPU.lock().unwrap_or_else(PoisonError::into_inner) = None;
}
