//! A host with a device of its own that resizes its window and changes the quality tier.
//!
//! `cargo run -p afterimage-gpu --example resize` renders a frame at two sizes and two tiers, and prints the passes and
//! the memory of each plan.
#![allow(clippy::print_stdout, reason = "an example shows its result")]

use std::error::Error;

use afterimage_gpu::{Executor, Frame, GpuError, InputImage, Runtime, Texels, caps, download, upload};
use afterimage_graph::check::{CheckOptions, Facts, Graph, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;
use afterimage_plan::Options;

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
fn scene(device: &wgpu::Device, queue: &wgpu::Queue, size: Size) -> Result<InputImage, GpuError> {
    let ramp = |index: u32| 20.0 * (index % size.width) as f32 / size.width as f32;
    let pixels: Vec<[f32; 4]> = (0..size.width * size.height).map(|index| [ramp(index); 4]).collect();
    let texels = Texels::from_floats_as_half(size.width, size.height, &pixels);
    let view = upload(device, queue, &texels)?.create_view(&Default::default());
    Ok(InputImage { input: "scene".into(), view, desc: texels.desc, finite: true })
}

fn main() -> Result<(), Box<dyn Error>> {
    let (adapter, device, queue) = pollster::block_on(open())?;
    let executor = Executor::with_caps(&device, &queue, caps(&adapter, &device));
    let mut runtime = Runtime::new(executor, graph("high")?, Facts::default(), Options::default());
    for tier in ["high", "low"] {
        // The pipelines that both tiers use stay compiled.
        runtime.change(graph(tier)?, Options::default());
        for size in [Size::new(640, 360), Size::new(960, 540)] {
            let scene = scene(&device, &queue, size)?;
            // Plans are cached: only a size, a fact or a tier that is new makes one.
            let plan = runtime.load(size, std::slice::from_ref(&scene))?;
            let (passes, bytes) = (plan.passes.len(), plan.memory.placed);

            let mut encoder = device.create_command_encoder(&Default::default());
            let frame = Frame { inputs: &[("scene", &scene.view)], reset: true, ..Frame::default() };
            runtime.executor().encode(&mut encoder, &frame)?;
            queue.submit([encoder.finish()]);

            let shown = download(&device, &queue, runtime.output("display"))?.to_floats();
            let middle = shown[shown.len() / 2 + size.width as usize / 2];
            println!("{tier:4} {}x{}: {passes} passes, {bytes} bytes, centre {middle:.3?}", size.width, size.height);
        }
    }
    Ok(())
}
