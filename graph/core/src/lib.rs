//! RON text to a checked graph, and the API for node authors.
//!
//! | you hold | you want | module or crate | verb | result |
//! |---|---|---|---|---|
//! | RON text | structure with locations | [`document`] | [`document::parse`] | a [`Document`](document::Document) |
//! | structure | a valid graph | [`check`] | [`check::check`] | a [`Graph`](check::Graph) |
//! | a graph, sizes, facts | passes, order, barriers, memory, code | `afterimage-plan` | `plan` | a `Plan` |
//! | a plan and a device | pixels in your encoder | `afterimage-gpu` | `Executor::encode` | commands |
//!
//! [`node`] defines what a node kind is, and what it can record. Node authors start with the [`prelude`].
//!
//! # Invariants
//!
//! * This crate does no IO, reads no clock and has no access to a device.
//! * A [`Graph`](check::Graph) can always be planned. Only the host's part can fail: a missing input, or a size that
//!   the device does not support.
//! * No module knows a later one: `document` knows no kinds, and `node` knows no plans.
//! * Equal inputs give equal results: nothing depends on the order of a hash map.
//! * An error of a user is a diagnostic with a location. An error of the framework is a panic with a reason.
//!
//! # Terms
//!
//! | term | meaning |
//! |---|---|
//! | kind, node | a type of node, and one use of it |
//! | port, wire | a named input or output of a kind, and a connection of two of them |
//! | color state | the meaning of an image's numbers; part of a wire's type ([`image::ColorState`]) |
//! | history | an image or a value of an earlier frame |
//! | fact | a statement of the host about the scene |
//! | tier | a named set of overrides: a quality level |
//! | fallback | what readers get from an output of a node that is disabled or skipped |
//! | pass | one dispatch or one draw |

pub mod check;
pub mod document;
pub mod node;

pub use afterimage_base::{caps, color, diagnostic, image, value};
pub use afterimage_wgsl as wgsl;

pub mod prelude {
    //! The names that node authors need.
    pub use crate::node::{
        BufferId, BufferLife, ByNeighbors, ByRows, ColorChange, Fallback, ImageColor, ImageId, Input, InputValue,
        InputValues, Invariants, Node, NodeKind, Output, OutputState, PortType, Recorder, Resource, TypedKind,
    };
    pub use crate::{choices, node_kind};
    pub use afterimage_base::image::{ColorState, Format, ImageDesc, Size};
    pub use afterimage_base::value::{FileValue, ParamType, Value};
    pub use afterimage_wgsl::{Library, Shader};
}
