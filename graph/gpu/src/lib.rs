//! Plan to pixels: the executor, and the only crate of the framework that uses wgpu. Hosts depend on the crate
//! `afterimage`, which exports what they need of it, and knows graphs.
//!
//! [`Executor::load`] makes the textures and pipelines of a [`Plan`](afterimage_plan::Plan), and [`Executor::encode`]
//! records a frame. While the plan renders, [`Executor::prepare`] compiles another one, and [`Executor::swap`]
//! exchanges them between two frames. [`Gpu::open`] opens a device, and [`Clock`] measures frames.
//!
//! The crate builds for Vulkan, Metal, Direct3D 12 and the web. Images share placed memory only on Vulkan. On the web,
//! where nothing may wait, a device comes from [`Gpu::open_async`], and there is no clock or read-back.
//!
//! With the feature `tracing`, plans, compilation, loading and recording are spans of that crate.

// Whether types that hold a device are `Sync` goes through more than 128 types of wgpu.
#![recursion_limit = "256"]

#[macro_use]
mod trace;

#[cfg(not(target_family = "wasm"))]
mod bands;
mod bind_group;
mod buffer;
mod cache;
#[cfg(not(target_family = "wasm"))]
mod clock;
mod device;
mod draw_state;
mod error;
mod executor;
mod frame_constants;
mod full_screen;
mod heap;
#[cfg(not(target_family = "wasm"))]
mod input_image;
mod kernel_faults;
mod layout;
mod median;
mod pipelines;
mod platform;
mod samples;
mod store;
#[cfg(not(target_family = "wasm"))]
mod stream;
mod texture_format;
#[cfg_attr(target_family = "wasm", allow(dead_code, reason = "on the web nothing may wait for the times"))]
mod timing;
mod transfer;

#[cfg(not(target_family = "wasm"))]
pub use bands::{BandReader, BandStats, BandWriter, BandedFrame, bytes_of_whole_frame, render_in_bands};
#[cfg(not(target_family = "wasm"))]
pub use clock::{Clock, ClockSource, FrameTime, TimedCommands};
pub use device::{ErrorLog, Gpu, Opening, caps, wanted_features};
pub use error::GpuError;
pub use executor::{
    DrawTargets, Executor, Frame, FrameKind, HostDraw, LoadedPlan, Preparation, Rectangle, color_pass_in,
};
pub use full_screen::{FullScreenPipeline, color_pass};
#[cfg(not(target_family = "wasm"))]
pub use input_image::{FrameStep, InputImage, input_image};
pub use kernel_faults::KernelFaults;
pub use median::{MedianEstimate, median};
pub use platform::{Task, TaskPool};
#[cfg(not(target_family = "wasm"))]
pub use stream::{Feed, Readback, download};
pub use texture_format::texture_format;
#[cfg(feature = "tracing")]
#[doc(hidden)] // For the macro of spans.
pub use tracing;
pub use transfer::{Texels, upload, upload_bytes};
pub use wgpu;

#[doc(hidden)]
pub mod internal {
    //! Parts for the crate `afterimage`, which no other crate may use.
    pub use crate::buffer::buffer;
    pub use crate::executor::{Fork, MULTISAMPLED, PreparedPlan, Residency, VOLUME, has_host_draws, view_of};
    pub use crate::heap::requirement;
    pub use crate::platform::{Worker, scoped, watched};
    #[cfg(not(target_family = "wasm"))]
    pub use crate::platform::{caught, submit};
    pub use crate::store::part_view;
    #[cfg(not(target_family = "wasm"))]
    pub use crate::stream::ReadbackBatch;
    pub use crate::texture_format::image_format;
    pub use crate::timing::between;
}
