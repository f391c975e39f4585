//! A host with a device of its own that resizes its window and changes the quality tier.
//!
//! `cargo run -p afterimage --example resize` renders a frame at two sizes and two tiers, and prints the passes and
//! the memory of each plan.
#![allow(clippy::print_stdout, reason = "an example shows its result")]

use std::error::Error;

use afterimage::host::{GpuError, Size, Texels, download, upload};
use afterimage::{Frame, Gpu, Post, wgpu};

/// A device as a renderer opens it. The framework adds no requirement: `Gpu::new` finds out what the device can do.
async fn open() -> Result<Gpu, Box<dyn Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await?;
    let (device, queue) = adapter.request_device(&wgpu::DeviceDescriptor::default()).await?;
    Ok(Gpu::new(&adapter, &device, &queue))
}

/// The renderer's image: a ramp from black to twenty times white, a half float per channel.
fn scene(device: &wgpu::Device, queue: &wgpu::Queue, size: Size) -> Result<wgpu::TextureView, GpuError> {
    let ramp = |index: u32| 20.0 * (index % size.width) as f32 / size.width as f32;
    let pixels: Vec<[f32; 4]> = (0..size.width * size.height).map(|index| [ramp(index); 4]).collect();
    let texels = Texels::from_floats_as_half(size.width, size.height, &pixels);
    Ok(upload(device, queue, &texels)?.create_view(&Default::default()))
}

fn main() -> Result<(), Box<dyn Error>> {
    let gpu = pollster::block_on(open())?;
    let (device, queue) = (&gpu.device, &gpu.queue);
    let mut post = Post::open(&gpu, "lynx")?;
    post.assume_finite("scene");
    for tier in ["high", "low"] {
        // The pipelines that both tiers use stay compiled.
        post.set_tier(tier)?;
        for size in [Size::new(640, 360), Size::new(960, 540)] {
            let scene = scene(device, queue, size)?;
            post.finish_changes()?;
            let mut encoder = device.create_command_encoder(&Default::default());
            // Another size makes another plan here, and plans are kept: only what is new makes one.
            post.encode(&mut encoder, &Frame { inputs: &[("scene", &scene)], reset: true, ..Frame::default() })?;
            queue.submit([encoder.finish()]);

            let plan = post.plan().expect("a frame was recorded");
            let (passes, bytes) = (plan.passes.len(), plan.memory.placed);
            let shown = download(device, queue, post.output("display"))?.to_floats();
            let middle = shown[shown.len() / 2 + size.width as usize / 2];
            println!("{tier:4} {}x{}: {passes} passes, {bytes} bytes, center {middle:.3?}", size.width, size.height);
        }
    }
    Ok(())
}
