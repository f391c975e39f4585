//! Plan to pixels: the only user of wgpu.
//!
//! [`Session`] is the runtime of programs without a renderer: a device, plans, uploads and read-back. [`Clock`] measures
//! frames.
//!
//! [`Gpu::open`] gives programs without a renderer a device; a renderer brings its own to [`Executor::new`].
//! [`Executor::load`] takes a [`Plan`](afterimage_plan::Plan), and [`Executor::encode`] records a frame of it into the
//! host's encoder. While it renders, [`Executor::prepare`] compiles another plan, which [`Executor::swap`] puts in
//! between two frames.

mod cache;
mod clock;
mod device;
mod error;
mod executor;
mod heap;
mod layout;
mod pipelines;
mod session;
mod store;
mod stream;
mod timing;
mod transfer;

pub use clock::{Clock, ClockSource, FrameTime, Recording, median};
pub use device::{ErrorLog, Gpu, Opening, caps, texture_format};
pub use error::GpuError;
pub use executor::{Executor, Frame, Preparation};
pub use session::{FrameInputs, FrameStep, InputImage, Runtime, Session, SessionError, input_image};
pub use stream::{Feed, Readback};
pub use transfer::{Texels, download, upload, upload_bytes};
pub use wgpu;
