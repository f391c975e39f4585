//! Places in the graph that a user looks at.

use afterimage_graph::image::ImageDesc;

/// A place in the graph that the user looks at.
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
    /// Size and format.
    pub desc: ImageDesc,
}
