//! A host with a device of its own that resizes its window and changes the quality tier.
//!
//! `cargo run -p afterimage-gpu --example resize` renders a frame at two sizes and two tiers, and prints the passes and
//! the memory of each plan.
#![allow(clippy::print_stdout, reason = "an example shows its result")]

use std::error::Error;

use afterimage_gpu::{Frame, GpuError, Post, Texels, download, upload};
use afterimage_graph::check::{CheckOptions, Graph, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;

const PIPELINE: &str = include_str!("../../../pipelines/lynx.ron");

/// The graph of the pipeline at a tier.
fn graph(tier: &str) -> Result<Graph, Box<dyn Error>> {
    let kinds = Registry::new(&[afterimage_nodes::ALL])?;
    let options = CheckOptions { tier: Some(tier.to_owned()), ..CheckOptions::default() };
    let (graph, _warnings) = check(&parse("lynx.ron", PIPELINE)?, &kinds, &options)?;
    Ok(graph)
}

/// A device as a renderer opens it. The framework adds no requirement: `caps` finds out what the device can do.
async fn open() -> Result<(wgpu::Adapter, wgpu::Device, wgpu::Queue), Box<dyn Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await?;
    let (device, queue) = adapter.request_device(&wgpu::DeviceDescriptor::default()).await?;
    Ok((adapter, device, queue))
}

/// The renderer's image: a ramp from black to twenty times white, a half float per channel.
fn scene(device: &wgpu::Device, queue: &wgpu::Queue, size: Size) -> Result<wgpu::TextureView, GpuError> {
    let ramp = |index: u32| 20.0 * (index % size.width) as f32 / size.width as f32;
    let pixels: Vec<[f32; 4]> = (0..size.width * size.height).map(|index| [ramp(index); 4]).collect();
    let texels = Texels::from_floats_as_half(size.width, size.height, &pixels);
    Ok(upload(device, queue, &texels)?.create_view(&Default::default()))
}

fn main() -> Result<(), Box<dyn Error>> {
    let (adapter, device, queue) = pollster::block_on(open())?;
    let mut post = Post::new(&adapter, &device, &queue, graph("high")?);
    post.assume_finite("scene");
    for tier in ["high", "low"] {
        // The pipelines that both tiers use stay compiled.
        post.change(graph(tier)?);
        for size in [Size::new(640, 360), Size::new(960, 540)] {
            let scene = scene(&device, &queue, size)?;
            post.finish_changes()?;
            let mut encoder = device.create_command_encoder(&Default::default());
            // Another size makes another plan here, and plans are kept: only what is new makes one.
            post.encode(&mut encoder, &Frame { inputs: &[("scene", &scene)], reset: true, ..Frame::default() })?;
            queue.submit([encoder.finish()]);

            let plan = post.plan().expect("a frame was recorded");
            let (passes, bytes) = (plan.passes.len(), plan.memory.placed);
            let shown = download(&device, &queue, post.output("display"))?.to_floats();
            let middle = shown[shown.len() / 2 + size.width as usize / 2];
            println!("{tier:4} {}x{}: {passes} passes, {bytes} bytes, center {middle:.3?}", size.width, size.height);
        }
    }
    Ok(())
}
