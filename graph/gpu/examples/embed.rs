//! A renderer as a host: it has its own device, its own encoder and its own images.
//!
//! `cargo run -p afterimage-gpu --example embed` renders a few frames, changes the plan between them, and prints the
//! colour at the centre.
#![allow(clippy::print_stdout, reason = "an example shows its result")]

use std::error::Error;
use std::sync::Arc;

use afterimage_gpu::{Executor, Frame, Gpu, GpuError, Opening, Preparation, Texels, caps, download, upload};
use afterimage_graph::check::{CheckOptions, Facts, Graph, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::Registry;
use afterimage_plan::{GivenImage, Options, Plan, PlanRequest, plan};

const PIPELINE: &str = include_str!("../../../pipelines/caracal.ron");

/// The part of a renderer that post-processes.
struct Post {
    graph: Graph,
    executor: Executor,
    next: Option<Preparation>,
}

impl Post {
    /// Called once. The capabilities of the device determine which formats and kernels plans use.
    fn new(adapter: &wgpu::Adapter, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Self, Box<dyn Error>> {
        let kinds = Registry::new(&[afterimage_nodes::ALL])?;
        let (graph, _warnings) = check(&parse("caracal.ron", PIPELINE)?, &kinds, &CheckOptions::default())?;
        let executor = Executor::with_caps(device, queue, caps(adapter, device));
        Ok(Self { graph, executor, next: None })
    }

    /// Called when a fact, a parameter or the pipeline changes. The new plan is compiled while frames continue, and a
    /// later frame swaps it in. What is equal in both plans is kept.
    fn change(&mut self, size: Size, facts: Facts) -> Result<(), Box<dyn Error>> {
        self.next = Some(self.executor.prepare(self.plan(size, facts)?));
        Ok(())
    }

    /// Called at the start and after a resize. No frame can use the old plan, so this waits for the new one.
    fn resize(&mut self, size: Size, facts: Facts) -> Result<(), Box<dyn Error>> {
        self.next = None;
        let plan = self.plan(size, facts)?;
        Ok(self.executor.load(plan)?)
    }

    fn plan(&self, size: Size, facts: Facts) -> Result<Arc<Plan>, Box<dyn Error>> {
        let scene = GivenImage { desc: ImageDesc::new(size), finite: false };
        let executor = &self.executor;
        let request = PlanRequest {
            size,
            inputs: [("scene".to_owned(), scene)].into(),
            facts,
            caps: executor.caps().clone(),
            options: Options::default(),
            dynamic: Default::default(),
            requirement: &|desc| executor.requirement(desc),
        };
        Ok(Arc::new(plan(&self.graph, &request)?))
    }

    /// Called in every frame; records into the renderer's encoder.
    fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        scene: &wgpu::TextureView,
        screen: &wgpu::TextureView,
        (time, dt): (f32, f32),
    ) -> Result<(), GpuError> {
        if let Some(next) = self.next.take_if(|next| next.is_ready()) {
            self.executor.swap(next)?;
        }
        let (inputs, outputs) = (&[("scene", scene)], &[("display", screen)]);
        self.executor.encode(encoder, &Frame { inputs, outputs, time, dt, reset: false })
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // A renderer has its own device.
    let Gpu { adapter, device, queue, .. } = Gpu::open(&Opening::default())?;
    let size = Size::new(64, 64);
    let scene = upload(&device, &queue, &grey(size, 0.18))?;
    let screen = screen(&device, size);

    let mut post = Post::new(&adapter, &device, &queue)?;
    post.resize(size, Facts::default())?;
    let (scene_view, screen_view) = (scene.create_view(&Default::default()), screen.create_view(&Default::default()));
    for frame in 0..4_u8 {
        let mut encoder = device.create_command_encoder(&Default::default());
        post.draw(&mut encoder, &scene_view, &screen_view, (f32::from(frame) / 60.0, 1.0 / 60.0))?;
        queue.submit([encoder.finish()]);
        if frame == 0 {
            let mut facts = Facts::default();
            facts.set("emissive", false);
            post.change(size, facts)?;
        }
    }

    let pixels = download(&device, &queue, &screen)?.to_floats();
    println!("middle grey becomes {:?} on the display", pixels[pixels.len() / 2]);
    Ok(())
}

/// The renderer's image: one luminance everywhere.
fn grey(size: Size, light: f32) -> Texels {
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
