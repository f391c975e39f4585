//! Temporal anti-aliasing: one pass.

use afterimage_gpu::wgpu::{self, TextureFormat};
use afterimage_gpu::{Gpu, InputImage};
use afterimage_graph::check::GraphNode;
use afterimage_graph::node::Camera;
use afterimage_graph::value::Value;
use glam::DMat4;

use super::chain::{Bound, Chain, between, image, size_of, uniform, unprojection};
use super::number;
use crate::raw::module;

pub(super) fn chain(gpu: &Gpu, node: &GraphNode, images: &[InputImage], camera: &Camera) -> Option<Chain> {
    let read = ["source", "history", "depth", "previous_depth", "motion"];
    let views: Vec<_> = read.iter().map(|input| image(images, input)).collect::<Option<_>>()?;
    let is = |name: &str, choice| node.instance.value(name) == Some(&Value::Choice(choice));
    if !is("filtering", "Bicubic") || !is("unit", "Uv") {
        return None;
    }
    let mut numbers = reprojection(camera).to_vec();
    numbers.extend(unprojection(camera));
    numbers.extend(camera.jitter);
    numbers.extend(camera.previous_jitter);
    for name in ["blend", "moving", "variance", "depth_threshold", "white"] {
        numbers.push(number(node, name)?);
    }
    let settings = uniform(gpu, &numbers);
    let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    });
    let module = module(gpu, include_str!("taa.wgsl"));
    let result = between(gpu, size_of(views[0]), TextureFormat::Rgba16Float);
    let mut bindings = vec![(0, Bound::Buffer(&settings)), (1, Bound::Sampler(&sampler))];
    bindings.extend((2..).zip(views.into_iter().map(Bound::Image)));
    bindings.push((7, Bound::Image(&result)));
    let mut chain = Chain::new(result.clone());
    chain.add(gpu, &module, "resolve", &bindings);
    Some(chain)
}

/// The row of the matrix from the camera's space to that of the frame before that gives z there.
fn reprojection(camera: &Camera) -> [f32; 4] {
    let matrix = |columns: [[f32; 4]; 4]| DMat4::from_cols_array_2d(&columns.map(|column| column.map(f64::from)));
    let there = matrix(camera.previous_view) * matrix(camera.view).inverse();
    there.row(2).as_vec4().to_array()
}
