//! The built-in node kinds: one file each, and one table that lists them.
//!
//! To add a kind: write `nodes/src/<kind>.rs` and `shaders/<kind>.wgsl`, and add the two lines below, in alphabetical order.

mod composite;
mod downsample;
mod extract;
mod gaussian;
mod upsample;
mod vignette;

use afterimage_graph::node::NodeKind;

pub use composite::{Composite, CompositeBlend};
pub use downsample::{Downsample, DownsampleFilter, Firefly};
pub use extract::{Brightness, Extract, ExtractMethod};
pub use gaussian::{Gaussian, GaussianKernel, GaussianPyramid, GaussianTaps};
pub use upsample::{Upsample, UpsampleBlend, UpsampleFilter};
pub use vignette::Vignette;

/// Every built-in kind.
pub const ALL: &[NodeKind] = &[NodeKind::of::<Composite>(), NodeKind::of::<Downsample>(), NodeKind::of::<Extract>(), NodeKind::of::<Gaussian>(), NodeKind::of::<GaussianPyramid>(), NodeKind::of::<Upsample>(), NodeKind::of::<Vignette>()];
