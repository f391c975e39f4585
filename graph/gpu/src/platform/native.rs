//! Targets with threads.

use std::thread::JoinHandle;

use afterimage_wgsl::limits;

use crate::GpuError;

/// Work on a thread of its own.
pub(crate) struct Worker<T>(JoinHandle<T>);

impl<T: Send + 'static> Worker<T> {
    pub(crate) fn new(work: impl FnOnce() -> T + Send + 'static) -> Self {
        Self(std::thread::spawn(work))
    }

    pub(crate) fn is_finished(&self) -> bool {
        self.0.is_finished()
    }

    /// Waits for the result. A panic of the work goes on here.
    pub(crate) fn join(self) -> T {
        self.0.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

/// Does the same work on several threads, and waits for all of them. wgpu parses shaders there, and its parser
/// recurses.
pub(crate) fn on_threads(threads: usize, work: impl Fn() + Sync) {
    std::thread::scope(|scope| {
        for _ in 0..threads {
            let thread = std::thread::Builder::new().stack_size(limits::STACK_BYTES).spawn_scoped(scope, &work);
            thread.unwrap_or_else(|error| panic!("the system has no more threads: {error}"));
        }
    });
}

/// Calls `make` inside error scopes and returns the device's error if there is one. wgpu's error scopes belong to the
/// calling thread.
pub(crate) fn watched<T>(
    device: &wgpu::Device,
    what: &str,
    make: impl FnOnce() -> Result<T, GpuError>,
) -> Result<T, GpuError> {
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let made = make();
    let refused = pollster::block_on(validation.pop());
    if let Some(error) = pollster::block_on(memory.pop()) {
        return Err(GpuError::OutOfMemory { what: format!("{what} ({error})") });
    }
    match refused {
        Some(error) => Err(GpuError::Refused { what: what.to_owned(), why: error.to_string() }),
        None => made,
    }
}
