//! Baselines of single kinds: the same work by the same published method, written by hand with wgpu. Textures and bind
//! groups are made once, and each step is a dispatch of its own.

mod chain;
mod depth_of_field;
mod gtao;
mod taa;

use afterimage_gpu::{Gpu, InputImage};
use afterimage_graph::check::GraphNode;
use afterimage_graph::node::Camera;

pub(super) use chain::Chain;

/// The baseline of a node that is alone in a graph with these images, which have one size; `None` if its kind has none,
/// or not for its parameters.
pub(super) fn chain(gpu: &Gpu, node: &GraphNode, images: &[InputImage], camera: &Camera) -> Option<Chain> {
    match node.kind().name() {
        "Gtao" => gtao::chain(gpu, node, images, camera),
        "DepthOfField" => depth_of_field::chain(gpu, node, images),
        "Taa" => taa::chain(gpu, node, images, camera),
        _ => None,
    }
}
