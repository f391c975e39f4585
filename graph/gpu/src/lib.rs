//! Plan to pixels: the API for hosts, and the only crate of the framework that uses wgpu.
//!
//! A host with its own renderer creates an [`Executor`] on its own device. [`Executor::load`] makes the textures and
//! pipelines of a [`Plan`](afterimage_plan::Plan), and [`Executor::encode`] records a frame of it into the host's
//! encoder. While the plan renders, [`Executor::prepare`] compiles another one, and [`Executor::swap`] exchanges them
//! between two frames.
//!
//! A program without a renderer opens a device with [`Gpu::open`], or uses a [`Session`], which adds plans, uploads and
//! read-back. [`Clock`] measures frames.

mod buffer;
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
pub use error::{GpuError, SessionError};
pub use executor::{Executor, Frame, Preparation};
pub use session::{FrameInputs, FrameStep, InputImage, Runtime, Session, input_image};
pub use stream::{Feed, Readback, download};
pub use transfer::{Texels, upload, upload_bytes};
pub use wgpu;
