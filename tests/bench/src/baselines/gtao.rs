//! Ambient occlusion: the search, two means, and the light.

use afterimage_gpu::wgpu::TextureFormat;
use afterimage_gpu::{Gpu, InputImage};
use afterimage_graph::check::GraphNode;
use afterimage_graph::node::Camera;
use afterimage_graph::value::Value;

use super::chain::{Bound, Chain, between, image, pair, size_of, uniform, unprojection};
use super::number;
use crate::raw::module;

pub(super) fn chain(gpu: &Gpu, node: &GraphNode, images: &[InputImage], camera: &Camera) -> Option<Chain> {
    let [scene, depth, normal, albedo] =
        [image(images, "source")?, image(images, "depth")?, image(images, "normal")?, image(images, "albedo")?];
    let is = |name: &str, choice| node.instance.value(name) == Some(&Value::Choice(choice));
    if !is("size", "Full") || !is("space", "View") || number(node, "denoise") != Some(1.0) {
        return None;
    }
    let size = size_of(scene);
    let (width, height) = (size.width as f32, size.height as f32);
    let mut numbers = unprojection(camera).to_vec();
    numbers.extend([0.5 * camera.projection[0][0] * width, -0.5 * camera.projection[1][1] * height]);
    numbers.extend([number(node, "radius")?, number(node, "falloff")?, number(node, "largest")? * height]);
    for name in ["slices", "steps", "amount", "power"] {
        numbers.push(number(node, name)?);
    }
    let settings = uniform(gpu, &numbers);
    let settings = Bound::Buffer(&settings);
    let (format, name) = pair(gpu);
    let module = module(gpu, &include_str!("gtao.wgsl").replace("VISIBILITY", name));
    let found = between(gpu, size, format);
    let across = between(gpu, size, format);
    let lit = between(gpu, size, TextureFormat::Rgba16Float);
    let [found, across] = [Bound::Image(&found), Bound::Image(&across)];
    let [scene, depth, normal, albedo] = [scene, depth, normal, albedo].map(Bound::Image);
    let mut chain = Chain::new(lit.clone());
    chain.add(gpu, &module, "search", &[(0, settings), (1, depth), (2, normal), (6, found)]);
    chain.add(gpu, &module, "across", &[(3, found), (6, across)]);
    chain.add(gpu, &module, "down", &[(3, across), (6, found)]);
    let last = [(0, settings), (3, found), (4, scene), (5, albedo), (7, Bound::Image(&lit))];
    chain.add(gpu, &module, "light", &last);
    Some(chain)
}
