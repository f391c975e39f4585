//! Targets with threads that may wait.

use std::panic::AssertUnwindSafe;

use crate::error::GpuError;

/// wgpu says which of both to the callback of the host alone.
const DESTROYED: &str = "it was destroyed, or its driver has given it up";

/// Calls `make` inside error scopes and returns the device's error if there is one, also that it was lost before or
/// meanwhile. wgpu's error scopes belong to the calling thread.
pub fn watched<T>(
    device: &wgpu::Device,
    what: &str,
    make: impl FnOnce() -> Result<T, GpuError>,
) -> Result<T, GpuError> {
    scoped(device, what, || {
        let made = make();
        // wgpu reports a lost device to the host's callback only, and gives invalid objects.
        if is_lost(device) { Err(GpuError::lost(&DESTROYED)) } else { made }
    })
}

/// As [`watched`], for commands whose results are read later: that reports a lost device as well.
pub fn scoped<T, E: From<GpuError>>(
    device: &wgpu::Device,
    what: &str,
    make: impl FnOnce() -> Result<T, E>,
) -> Result<T, E> {
    let (made, memory, refused) = with_errors(device, make);
    match (made, memory, refused) {
        (_, Some(error), _) => Err(GpuError::OutOfMemory { what: format!("{what} ({error})") }.into()),
        (Err(error), None, _) => Err(error),
        (Ok(_), None, Some(_)) if is_lost(device) => Err(GpuError::lost(&DESTROYED).into()),
        (Ok(_), None, Some(error)) => Err(GpuError::Refused { what: what.to_owned(), why: error.to_string() }.into()),
        (Ok(made), None, None) => Ok(made),
    }
}

/// As [`scoped`], for calls that need memory and are right otherwise: one scope is enough, since hosts set parameters
/// in every frame.
pub(crate) fn without_memory(
    device: &wgpu::Device,
    what: &str,
    make: impl FnOnce() -> Result<(), GpuError>,
) -> Result<(), GpuError> {
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let made = make();
    match pollster::block_on(memory.pop()) {
        Some(error) => Err(GpuError::OutOfMemory { what: format!("{what} ({error})") }),
        None => made,
    }
}

/// The result of `make`, and what the device reports: that memory is missing, and any other error.
fn with_errors<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> (T, Option<wgpu::Error>, Option<wgpu::Error>) {
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let internal = device.push_error_scope(wgpu::ErrorFilter::Internal);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let made = make();
    let [validation, internal, memory] = [validation, internal, memory].map(|scope| pollster::block_on(scope.pop()));
    (made, memory, validation.or(internal))
}

/// True if the device gives no memory any more, not even a few bytes.
fn is_lost(device: &wgpu::Device) -> bool {
    let refuses_buffer = || {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("a check of the device"),
            size: wgpu::COPY_BUFFER_ALIGNMENT,
            usage: wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: true,
        });
        buffer.get_mapped_range_mut(..).is_err()
    };
    with_errors(device, refuses_buffer).0
}

/// Calls a function of wgpu 30 that panics for some errors of a driver: the end of a wait or of an encoder.
pub fn caught<T>(what: &str, call: impl FnOnce() -> T) -> Result<T, GpuError> {
    std::panic::catch_unwind(AssertUnwindSafe(call)).map_err(|panic| {
        let text = panic.downcast_ref::<String>().map_or("wgpu gives no reason", String::as_str);
        match text.contains("OUT_OF_") {
            true => GpuError::OutOfMemory { what: format!("{what} ({text})") },
            false => GpuError::lost(&text),
        }
    })
}

/// Waits for a submission, or for all.
pub(crate) fn wait(device: &wgpu::Device, submission_index: Option<wgpu::SubmissionIndex>) -> Result<(), GpuError> {
    let wait = wgpu::PollType::Wait { submission_index, timeout: None };
    match caught("a wait", || device.poll(wait))? {
        Ok(_) => Ok(()),
        Err(wgpu::PollError::Timeout) => Err(GpuError::TimedOut),
        Err(error) => Err(GpuError::lost(&error)),
    }
}
