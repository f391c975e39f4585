//! The images of a frame.

use afterimage_gpu::wgpu::TextureView;
use afterimage_graph::node::BlockData;

/// What the inputs of a pipeline get in a frame, by their names.
#[derive(Clone, Default)]
pub struct FrameImages {
    pub images: Vec<(String, TextureView)>,
    /// The cameras.
    pub blocks: Vec<(String, BlockData)>,
}
