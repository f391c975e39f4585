//! What nodes record with, besides their parameters.

use afterimage_base::caps::Caps;
use afterimage_base::image::{Format, Size};
use afterimage_graph::node::{ImageColor, InputValue, OutputUse};

use crate::request::PlanRequest;

/// What a node records with, besides its parameters.
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

/// What all nodes record with.
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
