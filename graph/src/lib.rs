//! Text to plan.
pub mod check;
pub mod diagnostic;
pub mod document;
pub mod image;
pub mod node;
pub mod plan;
pub mod shader;
pub mod value;
pub mod prelude {
    //! What node authors need.
    pub use crate::image::{Format, ImageDesc, Size, State};
    pub use crate::node::{
        Arrival, Arrivals, BufferId, BufferLife, Gives, ImageId, Input, Node, NodeKind, Output, Params, PortType, Recorder,
        Resource, StandIn,
    };
    pub use crate::shader::Shader;
    pub use crate::value::{FileValue, ParamType, Value};
    pub use crate::{choices, params};
}
