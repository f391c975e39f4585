//! The same work by the same published method, written by hand with wgpu: of single kinds, and of `lynx.ron`. Textures
//! and bind groups are made once, and each step is a dispatch of its own.

mod chain;
mod depth_of_field;
mod gtao;
pub(crate) mod lynx;
mod taa;

use afterimage_gpu::{Gpu, InputImage};
use afterimage_graph::check::GraphNode;
use afterimage_graph::node::Camera;
use afterimage_graph::value::Value;

pub(crate) use chain::Chain;

/// The baseline of a node that is alone in a graph with these images, which have one size; `None` if its kind has none,
/// or not for its parameters.
pub(crate) fn chain(gpu: &Gpu, node: &GraphNode, images: &[InputImage], camera: &Camera) -> Option<Chain> {
    match node.kind().name() {
        "Gtao" => gtao::chain(gpu, node, images, camera),
        "DepthOfField" => depth_of_field::chain(gpu, node, images),
        "Taa" => taa::chain(gpu, node, images, camera),
        _ => None,
    }
}

/// A number among the parameters of a node.
fn number(node: &GraphNode, name: &str) -> Option<f32> {
    match node.instance.value(name)? {
        Value::Float(number) => Some(*number as f32),
        Value::Int(number) => Some(*number as f32),
        _ => None,
    }
}
