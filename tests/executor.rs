//! The executor as a host uses it: histories, host textures, changes of plan, lost devices, and memory between frames.

mod alike;
mod any_plan;
mod bands;
mod changes;
mod feeds;
mod halves;
mod hazards;
mod held;
mod histories;
mod host;
mod lost;
mod memory;
mod random;
mod reload;
mod stale_memory;

use afterimage_gpu::Gpu;
use afterimage_graph::check::{CheckOptions, Graph, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::{Arg, KernelCall};
use afterimage_wgsl::Shader;

use crate::support::gpu::{Picture, another_device, gpu, registry};

/// The graph of a text at a tier.
fn at_tier(text: &str, tier: Option<&str>) -> Graph {
    let document = parse("test.ron", text).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = CheckOptions { tier: tier.map(str::to_owned), sets: Vec::new(), loader: &NoFiles };
    check(&document, &registry(), &options).unwrap_or_else(|errors| panic!("{errors:?}")).0
}

/// A device without any optional feature.
fn without_features() -> Gpu {
    let gpu = gpu();
    let mut plain = another_device(&gpu, wgpu::Features::empty(), gpu.adapter.limits());
    plain.caps = afterimage_gpu::caps(&plain.adapter, &plain.device);
    plain
}

/// The WebGPU specification guarantees no more.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_device_without_features_has_the_formats_of_every_device() {
    let (caps, every) = (without_features().caps, afterimage_plan::Caps::default());
    assert_eq!([caps.storage, caps.renderable, caps.blendable], [every.storage, every.renderable, every.blendable]);
    assert!(!caps.filter_32_bit && !caps.indirect_first_instance);
}

/// A picture of one gray.
fn flat(width: u32, height: u32, light: f32) -> Picture {
    Picture::new(width, height, |_, _| [light, light, light, 1.0])
}

/// Light with edges and gradients, all of it different from pixel to pixel.
fn lively(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let (u, v) = (x as f32 / width as f32, y as f32 / height as f32);
        let window = if u > 0.6 && v < 0.5 { 20.0 } else { 1.0 };
        [0.1 + u * window, 0.2 + v, 0.3 + (u * 40.0).sin().abs() * v * window, 1.0]
    })
}

/// The one color of a picture of one color.
fn level(picture: &Picture) -> f32 {
    let first = picture.at(0, 0);
    assert!(picture.pixels.iter().all(|pixel| *pixel == first), "the picture is not of one color");
    first[0]
}

fn bits(picture: &Picture) -> Vec<u32> {
    picture.pixels.as_flattened().iter().map(|x| x.to_bits()).collect()
}

/// A kernel that fills its result with NaN.
fn nan_kernel() -> KernelCall {
    static POISON: Shader = Shader::new(
        "poison.wgsl",
        "fn poison(at: Point) -> vec4f { return vec4f(bitcast<f32>(0x7fc00000u + u32(at.pixel.x & 1))); }",
    );
    KernelCall::function("poison", &POISON, "poison", &[("at", Arg::Point)])
}
