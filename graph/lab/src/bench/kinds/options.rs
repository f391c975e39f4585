//! What is measured, and how.

use afterimage_graph::check::Graph;
use afterimage_graph::image::Size;
use afterimage_graph::node::Camera;
use afterimage_plan::Options;

/// How kinds are measured.
pub struct KindsOptions<'a> {
    /// Sizes of frames.
    pub sizes: Vec<Size>,
    /// Samples of each median.
    pub samples: u32,
    /// The planner's options.
    pub options: Options,
    /// The camera of the built-in scene, from a graph that holds it, for a size.
    pub camera: &'a dyn Fn(&Graph, Size) -> Option<Camera>,
}
