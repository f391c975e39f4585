//! The smallest host that has all of it: a look with bloom and a curve, a slider, a quality switch, other sizes, and
//! commands in the renderer's own frame.
//!
//! `cargo run -p afterimage --example look` renders two tiers at two sizes, and prints the passes and the memory of
//! each plan. [`Look`] is what a renderer adds; the rest stands for the renderer. `graph/docs/measurements/look.csv`
//! compares it with the same in other systems.
#![allow(clippy::print_stdout, reason = "an example shows its result")]

use afterimage::host::{GpuError, Parameter, Size, Texels, download, upload};
use afterimage::{Error, Frame, Gpu, Post, wgpu};

struct Look {
    post: Post,
    strength: Parameter<f32>,
}

impl Look {
    /// A file, or the name of a built-in pipeline.
    fn open(gpu: &Gpu, source: &str) -> Result<Self, Error> {
        let mut post = Post::open(gpu, source)?;
        let strength = post.parameter("lit.strength")?;
        Ok(Self { post, strength })
    }

    fn set_strength(&mut self, strength: f32) -> Result<(), Error> {
        Ok(self.post.set(self.strength, strength)?)
    }

    fn set_quality(&mut self, tier: &str) -> Result<(), Error> {
        self.post.set_tier(tier)
    }

    /// The size is that of the images.
    fn draw(
        &mut self,
        scene: &wgpu::TextureView,
        screen: &wgpu::TextureView,
        dt: f32,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), Error> {
        let (inputs, outputs) = (&[("scene", scene)], &[("display", screen)]);
        Ok(self.post.encode(encoder, &Frame { inputs, outputs, dt, ..Frame::default() })?)
    }
}

/// A device as a renderer opens it. The framework adds no requirement: `Gpu::new` finds out what the device can do.
async fn open() -> Result<Gpu, Box<dyn std::error::Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await?;
    let (device, queue) = adapter.request_device(&wgpu::DeviceDescriptor::default()).await?;
    Ok(Gpu::new(&adapter, &device, &queue))
}

/// The renderer's image: a ramp from black to twenty times white, a half float per channel.
fn scene(gpu: &Gpu, size: Size) -> Result<wgpu::TextureView, GpuError> {
    let ramp = |index: u32| 20.0 * (index % size.width) as f32 / size.width as f32;
    let pixels: Vec<[f32; 4]> = (0..size.width * size.height).map(|index| [ramp(index); 4]).collect();
    let texels = Texels::from_floats_as_half(size.width, size.height, &pixels);
    Ok(upload(&gpu.device, &gpu.queue, &texels)?.create_view(&Default::default()))
}

/// The renderer's window.
fn screen(gpu: &Gpu, size: Size) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
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

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let gpu = pollster::block_on(open())?;
    let mut look = Look::open(&gpu, "lynx")?;
    for tier in ["high", "low"] {
        look.set_quality(tier)?;
        for size in [Size::new(640, 360), Size::new(960, 540)] {
            let (scene, screen) = (scene(&gpu, size)?, screen(&gpu, size));
            // The tier is made in the background, and the old one renders meanwhile: a renderer does not wait.
            look.post.finish_changes()?;
            for strength in [0.0, 0.3] {
                look.set_strength(strength)?;
                let mut encoder = gpu.device.create_command_encoder(&Default::default());
                look.draw(&scene, &screen.create_view(&Default::default()), 1.0 / 60.0, &mut encoder)?;
                gpu.queue.submit([encoder.finish()]);
                let shown = download(&gpu.device, &gpu.queue, &screen)?.to_floats();
                let dark = shown[shown.len() / 2 + size.width as usize / 24];
                let plan = look.post.plan().expect("a frame was recorded");
                let (passes, bytes) = (plan.passes.len(), plan.memory.placed);
                println!(
                    "{tier:4} {}x{}, strength {strength}: {passes} passes, {bytes} bytes, a dark pixel {dark:.3?}",
                    size.width, size.height
                );
            }
        }
    }
    Ok(())
}
