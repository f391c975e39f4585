//! A plug-in crate with one node kind. It uses the same API as the built-in kinds.

mod halftone;

use afterimage_graph::node::NodeKind;

pub use halftone::Halftone;

/// The kinds of this crate.
pub const ALL: &[NodeKind] = &[NodeKind::of::<Halftone>()];
