//! Plan to pixels: the API for hosts, and the only crate of the framework that uses wgpu. Hosts depend on the crate
//! `afterimage`, which exports what they need of it, and opens pipelines.
//!
//! A host with its own renderer keeps a [`Post`] for each pipeline: [`Post::encode`] records a frame into the host's
//! encoder, and plans follow the images, the facts and the parameters. Below it is the [`Executor`]: [`Executor::load`]
//! makes the textures and pipelines of a [`Plan`](afterimage_plan::Plan), and [`Executor::encode`] records a frame.
//! While the plan renders, [`Executor::prepare`] compiles another one, and [`Executor::swap`] exchanges them between
//! two frames.
//!
//! A program without a renderer opens a device with [`Gpu::open`], or uses a [`Session`], which adds plans, uploads and
//! read-back. [`Clock`] measures frames.
//!
//! The crate builds for Vulkan, Metal, Direct3D 12 and the web. Images share placed memory only on Vulkan. On the web,
//! where nothing may wait, a device comes from [`Gpu::open_async`], and there is no session, clock or read-back.

// Whether types that hold a device are `Sync` goes through more than 128 types of wgpu.
#![recursion_limit = "256"]

#[macro_use]
mod trace;

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
mod governor;
mod heap;
mod kernel_faults;
mod layout;
mod median;
mod pipelines;
mod platform;
mod post;
mod samples;
#[cfg(not(target_family = "wasm"))]
mod session;
mod store;
#[cfg(not(target_family = "wasm"))]
mod stream;
#[cfg_attr(target_family = "wasm", allow(dead_code, reason = "on the web nothing may wait for the times"))]
mod timing;
mod transfer;

#[cfg(not(target_family = "wasm"))]
pub use clock::{Clock, ClockSource, FrameTime, TimedCommands};
pub use device::{ErrorLog, Gpu, Opening, caps, texture_format, wanted_features};
pub use error::GpuError;
pub use executor::{DrawTargets, Executor, Frame, FrameKind, HostDraw, Preparation, Rectangle};
pub use full_screen::FullScreenPipeline;
pub use governor::{GovernedTier, Governor, TierChange, TierChangeReason};
pub use kernel_faults::KernelFaults;
pub use median::{MedianEstimate, median};
pub use platform::{Task, TaskPool};
pub use post::{
    Control, ExpectedFrame, FadeSkipReason, HostImage, Parameter, ParameterInfo, PassTimes, Post, PostError, Reading,
    TierGraph, Watch,
};
#[cfg(not(target_family = "wasm"))]
pub use session::{
    BandReader, BandWriter, BandsMade, FrameInputs, FrameStep, InputImage, Session, TableErrors, input_image,
};
#[cfg(not(target_family = "wasm"))]
pub use stream::{Feed, Readback, download};
pub use transfer::{Texels, upload, upload_bytes};
pub use wgpu;
