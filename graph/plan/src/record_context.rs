//! The arguments of [`record_node`](crate::record::record_node) besides the parameters of the node.

use afterimage_base::caps::Caps;
use afterimage_base::image::{Format, Size};
use afterimage_graph::node::{ImageColor, InputValue, OutputUse};

use crate::request::PlanRequest;

/// The arguments of recording a node, besides its parameters.
#[derive(Clone, Debug)]
pub(crate) struct NodeContext {
    pub(crate) name: String,
    pub(crate) dynamic: Vec<usize>,
    pub(crate) format: Option<Format>,
    pub(crate) values: Vec<InputValue>,
    pub(crate) inputs: Vec<Option<ImageColor>>,
    pub(crate) outputs: Vec<Option<ImageColor>>,
    pub(crate) used_outputs: Vec<OutputUse>,
}

/// The arguments of recording that all nodes share.
#[derive(Clone, Debug)]
pub(crate) struct FrameContext {
    pub(crate) size: Size,
    pub(crate) caps: Caps,
    pub(crate) exact: bool,
}

impl FrameContext {
    pub(crate) fn new(request: &PlanRequest<'_>) -> Self {
        Self { size: request.given.size, caps: request.caps.clone(), exact: request.options.exact }
    }
}
