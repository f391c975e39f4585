//! GPU post-processing on wgpu: exposure, bloom, depth of field, tone mapping and the like, as pipelines in text files.
//!
//! A host gives its device, its images and its command encoder. A [`Post`] is one pipeline on that device.
//!
//! ```no_run
//! use afterimage::{Frame, Gpu, Post, wgpu};
//!
//! # fn run(adapter: &wgpu::Adapter, device: &wgpu::Device, queue: &wgpu::Queue, encoder: &mut wgpu::CommandEncoder,
//! #     scene: wgpu::TextureView, screen: wgpu::TextureView, dt: f32) -> Result<(), afterimage::Error> {
//! // Once: the host's device, and a file or the name of a built-in pipeline.
//! let gpu = Gpu::new(adapter, device, queue);
//! let mut post = Post::open(&gpu, "look.ron")?;
//! let strength = post.parameter::<f32>("lit.strength")?;
//! post.set_tier("low")?;
//!
//! // In every frame: the host's images by the names of the pipeline's inputs and outputs.
//! post.set(strength, 0.3)?;
//! let (inputs, outputs) = (&[("scene", &scene)], &[("display", &screen)]);
//! post.encode(encoder, &Frame { inputs, outputs, dt, ..Frame::default() })?;
//!
//! // Now and then: whether the files have changed.
//! post.reload_if_changed()?;
//! # Ok(())
//! # }
//! ```
//!
//! | to | see |
//! |---|---|
//! | open text, node kinds in folders or in Rust, files elsewhere | [`Source`] |
//! | build a pipeline in code | [`Pipeline`] |
//! | resize | [`Frame::inputs`]: the size is that of the images |
//! | plan and compile before the first frame | [`prepare`](Post::prepare) |
//! | continue after a lost device | [`Post::rebuild`], when `encode` or the device's callback has reported it |
//! | list parameters with units, domains and documentation | [`parameters`](Post::parameters) |
//! | state facts, fade between pipelines, read meters back, render a second view | [`Post`] |
//! | know what images may be; give cameras, rectangles, factors | [`Frame`] |
//! | choose a tier by its time and error | [`Post::tiers`], [`Post::claim`] |
//! | hold a budget in milliseconds | [`Post::govern`] |
//! | open a device without a renderer | [`Gpu::open`] |
//! | write a node kind | [`node`] |
//! | load files asynchronously | [`host::Snapshot`] |
//! | write a frame for the report of a bug: feature `offline` | `Post::capture` |
//! | render images in memory, without a renderer: feature `offline` | `offline::Offline` |
//! | see plans, compilation, loading and recording as spans: feature `tracing` | the crate `tracing` |
//!
//! The types of these signatures are in [`host`], and `wgpu` is that of the crate. Nothing here waits for the device
//! but the first frame of a size.

// rustdoc asks whether types that hold a GPU are `Sync`, which goes through more than 128 types of wgpu.
#![recursion_limit = "256"]

#[cfg(all(feature = "offline", not(target_family = "wasm")))]
mod capture;
mod error;
mod files;
mod governor;
mod kinds;
#[cfg(all(feature = "offline", not(target_family = "wasm")))]
pub mod offline;
mod pipeline;
mod post;
#[cfg(all(feature = "offline", not(target_family = "wasm")))]
mod session;
mod snapshot;
mod source;

pub use afterimage_gpu::{Frame, FrameKind, Gpu, Opening, wgpu};
pub use error::Error;
pub use pipeline::Pipeline;
pub use post::Post;
pub use source::Source;

pub mod host {
    //! The types of the signatures for hosts.
    pub use afterimage_gpu::{
        DrawTargets, ErrorLog, Executor, GpuError, HostDraw, Preparation, Rectangle, Task, TaskPool, Texels, caps,
        texture_format, upload, upload_bytes, wanted_features,
    };
    #[cfg(not(target_family = "wasm"))]
    pub use afterimage_gpu::{FrameStep, Readback, download};
    pub use afterimage_graph::check::{Fact, FactKind, Facts, Graph, GraphInput, GraphNode, GraphOutput, ParameterId};
    pub use afterimage_graph::diagnostic::{Diagnostic, Diagnostics, Label, Location, Severity};
    pub use afterimage_graph::document::Claim;
    pub use afterimage_graph::image::{ColorState, Format, ImageDesc, Size};
    pub use afterimage_graph::node::{BlockData, Camera, Matrix, NodeKind, Registry, RegistryError};
    pub use afterimage_graph::value::{ChoiceName, FileValue, Param, ParamType, Quality, Type, Value, When};
    /// The types of parameters of built-in kinds, such as `Curve`.
    pub use afterimage_nodes as kinds;
    pub use afterimage_pipelines::{PIPELINES, TABLES};
    pub use afterimage_plan::{HostInputs, Options, Plan, PlanError};

    pub use crate::error::PostError;
    pub use crate::governor::{GovernedTier, Governor, Shortfall, TierChange, TierChangeReason, TierLimits};
    #[doc(hidden)] // For the program.
    pub use crate::kinds::{KindFiles, LIBRARY, is_kind, kind_folders, kinds_in};
    pub use crate::post::{Control, ExpectedFrame, HostImage, Parameter, ParameterInfo, PassTimes, Reading, Watch};
    pub use crate::snapshot::Snapshot;
    #[doc(hidden)] // For the program.
    pub use crate::source::{built_in, built_in_hint};
}

pub mod node {
    //! For authors of node kinds.
    //!
    //! A kind declares its parameters and its ports, and records passes. Its shader is a function without bindings.
    //! [`Source::kinds`](crate::Source::kinds) gives a table of kinds to a host.
    //!
    //! ```
    //! use afterimage::node::*;
    //!
    //! static SHADER: Shader = Shader::new(
    //!     "darken.wgsl",
    //!     "struct Darken { amount: f32 }\n\
    //!      fn darken(source: vec4f, params: Darken) -> vec4f {\n\
    //!          return vec4f(source.rgb * (1.0 - params.amount), 1.0);\n\
    //!      }",
    //! );
    //!
    //! node_kind! {
    //!     /// Darkens the image.
    //!     pub struct Darken {
    //!         /// The share of light that is taken away.
    //!         pub amount: f32 = 0.5 => within(0.0..=1.0), neutral(0.0);
    //!     }
    //!
    //!     const INPUTS: &'static [Input] = &[Input::image("source", "The image.")];
    //!     const OUTPUTS: &'static [Output] =
    //!         &[Output::image("result", OutputState::same("source"), "The darkened image.").or_input("source")];
    //! }
    //!
    //! impl Node for Darken {
    //!     fn is_identity(&self, _: &InputValues) -> bool {
    //!         self.amount == 0.0
    //!     }
    //!
    //!     fn record(&self, pass: &mut Recorder<'_>) {
    //!         let source = pass.image("source");
    //!         let desc = pass.desc(source);
    //!         pass.function(&SHADER, "darken").write("result", desc);
    //!     }
    //! }
    //!
    //! let kinds = [NodeKind::of::<Darken>()];
    //! contract(&kinds).expect("ports, parameters and documentation fit");
    //! let source = afterimage::Source::from("look.ron").kinds(&kinds);
    //! # drop(source);
    //! ```
    pub use afterimage_graph::node::*;
    pub use afterimage_graph::prelude::*;
    pub use afterimage_graph::{image, value, wgsl};
    /// Looks whether what kinds record is valid: every pass, and every shader module.
    pub use afterimage_plan::contract as recorded_contract;
}
