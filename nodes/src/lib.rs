//! The built-in node kinds: one file each, and one table that lists them.
//!
//! To add a kind: write `nodes/src/<kind>.rs` and `shaders/<kind>.wgsl`, and add the two lines below, in alphabetical order.

mod vignette;

use afterimage_graph::node::NodeKind;

pub use vignette::Vignette;

/// Every built-in kind.
pub const ALL: &[NodeKind] = &[NodeKind::of::<Vignette>()];
