//! Details of a pass, in vectors that the node's next pass reuses.

use afterimage_base::Shared;
use afterimage_wgsl::UniformValue;

use crate::node::drawing::Subresource;
use crate::node::resource::{ImageId, Resource};

/// Details of a pass around a function.
#[derive(Clone, Debug, Default)]
pub(super) struct FunctionDetails {
    pub(super) reads: Vec<(Shared<str>, ImageId)>,
    pub(super) levels: Vec<(&'static str, Subresource)>,
    /// Computed members of the uniform, besides the parameters.
    pub(super) computed: Vec<(&'static str, UniformValue)>,
    pub(super) defines: Vec<&'static str>,
}

/// Bindings and constants of a module with entry points that are no inputs of the same name.
#[derive(Clone, Debug, Default)]
pub(super) struct Bindings {
    pub(super) bound: Vec<(&'static str, Bound)>,
    /// Computed members of the uniform, besides the parameters.
    pub(super) computed: Vec<(&'static str, UniformValue)>,
    pub(super) constants: Vec<(&'static str, f64)>,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Bound {
    /// A whole image or buffer.
    Resource(Resource),
    /// A mip level of a layer.
    Level(Subresource),
}

#[derive(Debug)]
pub(super) enum Label {
    /// The name of its function or entry point.
    OfKernel,
    Own(String),
    /// True if it is that of the recording before.
    Compared(bool),
}

impl FunctionDetails {
    pub(super) fn clear(&mut self) {
        let Self { reads, levels, computed, defines } = self;
        reads.clear();
        levels.clear();
        computed.clear();
        defines.clear();
    }
}

impl Bindings {
    pub(super) fn clear(&mut self) {
        let Self { bound, computed, constants } = self;
        bound.clear();
        computed.clear();
        constants.clear();
    }
}

impl Label {
    /// Returns whether it is this text, for a kernel of that name.
    pub(super) fn is(&self, text: &str, kernel: &str) -> bool {
        match self {
            Self::OfKernel => text == kernel,
            Self::Own(own) => text == own,
            Self::Compared(is_equal) => *is_equal,
        }
    }

    /// The text, for a kernel of that name.
    pub(super) fn text(self, kernel: &str) -> String {
        match self {
            Self::Own(own) => own,
            Self::OfKernel | Self::Compared(_) => kernel.to_owned(),
        }
    }
}
