//! The images of a frame.

use afterimage_gpu::wgpu::TextureView;
use afterimage_graph::node::BlockData;

/// The images of a frame, by the names of the pipeline's inputs.
#[derive(Clone, Default)]
pub struct FrameImages {
    pub images: Vec<(String, TextureView)>,
    pub blocks: Vec<(String, BlockData)>,
}
