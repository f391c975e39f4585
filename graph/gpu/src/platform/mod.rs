//! Differences between targets with threads that may wait, and the web, which has neither.

mod memory;
#[cfg(not(target_family = "wasm"))]
mod native;
mod submit;
#[cfg(not(target_family = "wasm"))]
mod threads;
#[cfg(target_family = "wasm")]
mod web;

/// A task of a host's pool.
pub type Task = Box<dyn FnOnce() + Send>;

/// The task pool of a host: it runs the tasks that it is given on any thread and at any time. A task makes and compiles
/// one plan, which takes milliseconds, or frees what an old plan has left; it waits for nothing. If the pool drops the
/// task of a plan, the plan before renders on, and [`GpuError::TaskDropped`](crate::GpuError::TaskDropped) is reported.
/// A frame that waits for its plan compiles on one thread of the crate, and gives the pool tasks that help it: a task
/// that runs after that is done does nothing.
///
/// The tasks parse shaders by recursion. For the built-in kinds 2 MiB of stack are enough; kinds from folders may need
/// up to [`STACK_BYTES`](afterimage_wgsl::limits::STACK_BYTES). On the web there is no other thread, and the pool is
/// not asked.
pub type TaskPool = std::sync::Arc<dyn Fn(Task) + Send + Sync>;

pub(crate) use memory::{local_memory, used_memory};
#[cfg(not(target_family = "wasm"))]
pub use native::{caught, scoped, watched};
#[cfg(not(target_family = "wasm"))]
pub(crate) use native::{wait, without_memory};
pub use submit::submit;
#[cfg(not(target_family = "wasm"))]
pub use threads::Worker;
#[cfg(not(target_family = "wasm"))]
pub(crate) use threads::on_threads;
#[cfg(target_family = "wasm")]
pub use web::{Worker, caught, scoped, watched};
#[cfg(target_family = "wasm")]
pub(crate) use web::{on_threads, without_memory};
