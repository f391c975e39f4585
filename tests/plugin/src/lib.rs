//! An example of a plug-in: a node kind in a crate of its own. It uses the interface that the built-in kinds use.

mod halftone;

use afterimage_graph::node::NodeKind;

pub use halftone::Halftone;

/// The kinds of this crate, for a registry.
pub const ALL: &[NodeKind] = &[NodeKind::of::<Halftone>()];
