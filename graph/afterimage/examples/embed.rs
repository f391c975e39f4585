//! A renderer as a host: it has its own device, its own encoder and its own images.
//!
//! `cargo run -p afterimage --example embed` renders a few frames, changes a parameter in each and a fact between
//! them, and prints the color at the center. `-- 1.5 1920 1080 20` renders for 20 more seconds with a budget of 1.5 ms
//! at that size, and prints each change of tier.
#![allow(clippy::print_stdout, reason = "an example shows its result")]

use std::env;
use std::error::Error;
use std::time::{Duration, Instant};

use afterimage::host::{ExpectedFrame, HostImage, Size, Texels, download, upload};
use afterimage::{Frame, FrameKind, Gpu, Opening, Post, wgpu};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<f64> = env::args().skip(1).map(|argument| argument.parse()).collect::<Result<_, _>>()?;
    let [budget, width, height, seconds] = *arguments.first_chunk().unwrap_or(&[0.0, 64.0, 64.0, 0.0]);
    // A renderer has its own device: `Gpu::new(&adapter, &device, &queue)`.
    let gpu = Gpu::open(&Opening::default())?;
    let (device, queue) = (&gpu.device, &gpu.queue);
    let size = Size::new(width as u32, height as u32);
    let scene = upload(device, queue, &gray(size, 0.18))?.create_view(&Default::default());
    let screen = screen(device, size);
    let screen_view = screen.create_view(&Default::default());

    // Once: the name of a built-in pipeline, or a file.
    let mut post = Post::open(&gpu, "caracal")?;
    let strength = post.parameter::<f32>("lit.strength")?;

    // Its plan is made and compiled in the background: a renderer draws a loading screen meanwhile.
    let image = |format| HostImage::new(size.width, size.height, format);
    let inputs = &[("scene", image(wgpu::TextureFormat::Rgba16Float))];
    let outputs = &[("display", image(wgpu::TextureFormat::Rgba8Unorm))];
    post.prepare(&[ExpectedFrame { inputs, outputs, ..ExpectedFrame::default() }])?;
    while !post.is_prepared()? {
        std::thread::sleep(Duration::from_millis(1));
    }

    for frame in 0..4_u8 {
        // A parameter with a handle needs no plan. It holds from the next frame on.
        post.set(strength, 0.1 * f32::from(frame))?;
        if frame == 2 {
            // Another plan is made while frames continue, and a later frame swaps it in. What is equal is kept.
            post.set_fact("emissive", false);
        }
        let mut encoder = device.create_command_encoder(&Default::default());
        let (inputs, outputs) = (&[("scene", &scene)], &[("display", &screen_view)]);
        let time = f64::from(frame) / 60.0;
        post.encode(
            &mut encoder,
            &Frame { inputs, outputs, time, dt: 1.0 / 60.0, kind: FrameKind::cut_if(frame == 0), ..Frame::default() },
        )?;
        queue.submit([encoder.finish()]);
    }

    // The tiers follow a budget, from the worst picture to the best. What they cost is learned.
    post.govern(budget, &["high", "ultra"])?;
    let (begin, mut before, mut last) = (Instant::now(), 0.0, None);
    while begin.elapsed() < Duration::from_secs_f64(seconds) {
        let time = begin.elapsed().as_secs_f64();
        let mut encoder = device.create_command_encoder(&Default::default());
        let (inputs, outputs) = (&[("scene", &scene)], &[("display", &screen_view)]);
        post.encode(&mut encoder, &Frame { inputs, outputs, time, dt: (time - before) as f32, ..Frame::default() })?;
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely())?;
        before = time;
        if post.tier_change() != last.as_ref() {
            last = post.tier_change().cloned();
            last.iter().for_each(|change| println!("{time:.2} s: {change}"));
        }
    }

    let pixels = download(device, queue, &screen)?.to_floats();
    println!("middle gray becomes {:?} on the display", pixels[pixels.len() / 2]);
    Ok(())
}

/// The renderer's image: one luminance everywhere.
fn gray(size: Size, light: f32) -> Texels {
    Texels::from_floats_as_half(size.width, size.height, &vec![[light, light, light, 1.0]; size.texels() as usize])
}

/// A render target that is not a storage texture, like the images of a swap chain.
fn screen(device: &wgpu::Device, size: Size) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("screen"),
        size: wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}
