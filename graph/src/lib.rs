//! Text to plan: what a post-processing pipeline does on a GPU, worked out without one.
//!
//! | you hold | you want | room | verb | you get |
//! |---|---|---|---|---|
//! | RON text | structure that knows its places | [`document`] | [`document::parse`] | a [`Document`](document::Document) |
//! | structure | a graph that makes sense | [`check`] | [`check::check`] | a [`Graph`](check::Graph) |
//! | a graph, sizes and facts | passes, order, barriers, memory | [`plan`] | [`plan::plan`] | a [`Plan`](plan::Plan) |
//! | a plan and a device | pixels in your encoder | the crate `afterimage-gpu` | `Executor::encode` | commands |
//!
//! Beside this line of rooms lie [`node`], what a kind of node is and says; [`shader`], how kernel functions become modules; [`value`] and
//! [`image`], what parameters and wires hold; and [`diagnostic`], how mistakes are told. Node authors begin with the [`prelude`].
//!
//! # Invariants
//!
//! * This crate reads no files, asks no clock and cannot name a type of a device.
//! * A graph that comes out of the check can be planned; what then still fails is the host's part: an input that is missing, a size too large.
//! * A plan runs on every device whose [`Caps`](plan::Caps) it was made for, and [`plan::verify`], which shares no code with the planner, proves it.
//! * No step knows the step after it.
//! * Equal inputs give equal plans: nothing depends on the order of a hash map.
//! * A user's mistake is a diagnostic with a place, ours is a panic with a reason, and nothing is silent.
//!
//! # Words
//!
//! | word | means |
//! |---|---|
//! | kind, node | a type of node, and one use of it |
//! | port, wire | where something goes in or comes out, and what connects two of them |
//! | state | what the numbers of an image mean; part of a wire's type ([`image::ColorState`]) |
//! | pass | one dispatch or one draw |
//! | image, slot | an image of the plan, and the texture in which images of equal description take turns |
//! | batch | passes that need no barrier between them |
//! | transition, hand-over | a change of use between two batches, and the moment at which memory goes from one image to the next |
//! | history | an image or a value that outlives the frame |
//! | fact | what the host says of the scene |
//! | tier | a named set of changes: a quality level |
//! | bypass, stand-in | what takes the place of a node that is off, or of one that changes nothing at its present values |

pub mod check;
pub mod document;
pub mod node;

pub use afterimage_base::{caps, diagnostic, image, value};
pub use afterimage_wgsl as wgsl;

pub mod prelude {
    //! What node authors need.
    pub use crate::node::{
        Arrival, Arrivals, BufferId, BufferLife, ByCells, ByRows, Fallback, ImageId, Input, Node, NodeKind, Output,
        OutputState, Params, PortType, Recorder, Resource,
    };
    pub use crate::{choices, params};
    pub use afterimage_base::image::{ColorState, Format, ImageDesc, Size};
    pub use afterimage_base::value::{FileValue, ParamType, Value};
    pub use afterimage_wgsl::{Library, Shader};
}
