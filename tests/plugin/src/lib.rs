//! A third-party node: what a plug-in crate looks like. It uses nothing that the built-in nodes do not use.

mod halftone;

use afterimage_graph::node::NodeKind;

pub use halftone::Halftone;

/// The kinds of this crate.
pub const ALL: &[NodeKind] = &[NodeKind::of::<Halftone>()];
