//! Depth of field: circles, their largest radius by tiles, and the gather.

use std::f64::consts::PI;

use afterimage_gpu::wgpu::TextureFormat;
use afterimage_gpu::{Gpu, InputImage};
use afterimage_graph::check::GraphNode;
use afterimage_graph::image::Size;

use super::chain::{Bound, Chain, between, image, pair, size_of, uniform};
use super::number;
use crate::raw::module;

pub(super) fn chain(gpu: &Gpu, node: &GraphNode, images: &[InputImage]) -> Option<Chain> {
    let (scene, depth) = (image(images, "source")?, image(images, "depth")?);
    let number = |name: &str| number(node, name);
    // The aperture is round.
    if number("blades")? >= 3.0 {
        return None;
    }
    let size = size_of(scene);
    let height = size.height as f32;
    let (focal, focus) = (number("focal_length")?, number("focus")?);
    let diameter = focal * focal / number("f_stop")? / (1000.0 * focus - focal);
    let strength = 0.5 * number("amount")? * diameter / number("sensor")? * height;
    let longest = number("largest")? * height;
    let tile = (longest.ceil() as u32 + 1).max(8);
    let samples = samples(number("rings")? as u32);
    let mut numbers = vec![focus, strength, longest, f32::from_bits(tile)];
    numbers.extend(samples.as_flattened());
    let settings = uniform(gpu, &numbers);
    let settings = Bound::Buffer(&settings);
    let (format, name) = pair(gpu);
    let source = include_str!("depth_of_field.wgsl").replace("CIRCLE", name);
    let module = module(gpu, &source.replace("SAMPLES", &samples.len().to_string()));
    let few = Size::new(size.width.div_ceil(tile), size.height.div_ceil(tile));
    let [circles, rows, tiles, reaches] =
        [size, Size::new(few.width, size.height), few, few].map(|size| between(gpu, size, format));
    let focused = between(gpu, size, TextureFormat::Rgba16Float);
    let [scene, depth] = [scene, depth].map(Bound::Image);
    let [circles, rows, tiles, reaches] = [&circles, &rows, &tiles, &reaches].map(Bound::Image);
    let mut chain = Chain::new(focused.clone());
    chain.add(gpu, &module, "confuse", &[(0, settings), (1, depth), (5, circles)]);
    chain.add(gpu, &module, "rows", &[(0, settings), (2, circles), (5, rows)]);
    chain.add(gpu, &module, "tiles", &[(0, settings), (2, rows), (5, tiles)]);
    chain.add(gpu, &module, "around", &[(2, tiles), (5, reaches)]);
    let last = [(0, settings), (2, circles), (3, reaches), (4, scene), (6, Bound::Image(&focused))];
    chain.add(gpu, &module, "gather", &last);
    Some(chain)
}

/// The middle, then six samples on the first ring, twelve on the second and so on, in a circle of radius 1: x, y, the
/// distance from the middle, and the area that the sample stands for.
fn samples(rings: u32) -> Vec<[f32; 4]> {
    let radius = |ring: f64| (ring / f64::from(rings)).powf(1.5);
    let area = |ring: f64| PI * radius(ring).powi(2);
    let mut all = vec![[0.0, 0.0, 0.0, area(0.5)]];
    for ring in 1..=rings {
        let (count, distance) = (6 * ring, radius(f64::from(ring)));
        let each = (area(f64::from(ring) + 0.5) - area(f64::from(ring) - 0.5)) / f64::from(count);
        for at in 0..count {
            let turn = (f64::from(at) + 0.5 * f64::from(ring % 2)) / f64::from(count);
            let (sin, cos) = (2.0 * PI * turn).sin_cos();
            all.push([distance * cos, distance * sin, distance, each]);
        }
    }
    all.into_iter().map(|sample| sample.map(|x| x as f32)).collect()
}
