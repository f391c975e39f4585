//! What a `node.ron` declares.

use crate::node::{Input, Output};
use afterimage_base::diagnostic::{Location, Spanned};
use afterimage_base::image::Size;
use afterimage_base::value::Param;

/// A `node.ron`, with the locations that errors in the shader refer to.
pub(super) struct Declaration {
    pub(super) name: Spanned<String>,
    pub(super) doc: String,
    pub(super) inputs: Vec<(Input, Location)>,
    pub(super) outputs: Vec<DeclaredOutput>,
    pub(super) params: Vec<(Param, Location)>,
}

/// An output and how it is made.
pub(super) struct DeclaredOutput {
    pub(super) port: Output,
    pub(super) function: Spanned<String>,
    pub(super) size: SizeRule,
}

/// The size of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SizeRule {
    Same,
    Half,
    Double,
    Fixed(u32, u32),
}

impl SizeRule {
    pub(super) fn of(self, size: Size) -> Size {
        match self {
            Self::Same => size,
            Self::Half => size.half(),
            Self::Double => Size::new(size.width.saturating_mul(2), size.height.saturating_mul(2)),
            Self::Fixed(width, height) => Size::new(width, height),
        }
    }
}
