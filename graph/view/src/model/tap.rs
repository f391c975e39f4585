//! Intermediate results that a user can show.

use afterimage_graph::image::ImageDesc;

/// An intermediate result that is shown instead of the result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tap {
    /// The wire: an input of the pipeline, or `node.port`.
    pub wire: String,
    /// Which of the wire's images: a level of a pyramid, a step of the node, or its history.
    pub index: usize,
    /// The slice of a volume.
    pub slice: u32,
}

impl Tap {
    /// The first image of a wire.
    pub fn new(wire: impl Into<String>) -> Self {
        Self { wire: wire.into(), index: 0, slice: 0 }
    }
}

/// An image that a tap can show.
#[derive(Clone, Debug, PartialEq)]
pub struct TapImage {
    /// Its name in the plan.
    pub name: String,
    pub desc: ImageDesc,
}
