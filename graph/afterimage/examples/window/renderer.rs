//! The renderer: a pass of its own that draws a scene, and the pipeline behind it.

use std::error::Error;
use std::io::Write as _;

use afterimage::Post;
use afterimage::host::PostError;
use afterimage_gpu::{Frame, Gpu, Opening, Rectangle, download, wgpu};
use afterimage_graph::check::{CheckOptions, Graph, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::Registry;

const PIPELINE: &str = include_str!("../../../../pipelines/lynx.ron");
const TIERS: [&str; 2] = ["high", "low"];

const SCENE: &str = "
@group(0) @binding(0) var<uniform> time: vec4f;
struct Corner { @builtin(position) position: vec4f, @location(0) uv: vec2f, @location(1) @interpolate(flat) half: u32 }
@vertex
fn corner(@builtin(vertex_index) index: u32, @builtin(instance_index) half: u32) -> Corner {
    let uv = vec2f(f32(2u * (index & 1u)), f32(index & 2u));
    return Corner(vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0), uv, half);
}
// A sky, and a sun that moves.
@fragment
fn scene(at: Corner) -> @location(0) vec4f {
    let sun = vec2f(0.5 + 0.3 * cos(time.x + 2.0 * f32(at.half)), 0.4 + 0.2 * sin(time.x));
    let light = 40.0 * smoothstep(0.07, 0.06, distance(at.uv, sun));
    return vec4f(mix(vec3f(0.05, 0.12, 0.3), vec3f(0.3, 0.2, 0.1), at.uv.y) + light * vec3f(1.0, 0.8, 0.5), 1.0);
}";

pub(crate) struct Renderer {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    scene: Scene,
    /// The pipeline of the whole screen, or of both halves.
    views: Vec<Post>,
    tier: usize,
}

impl Renderer {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, Box<dyn Error>> {
        let views = vec![Post::new(gpu, graph(TIERS[0])?)];
        Ok(Self {
            scene: Scene::new(&gpu.device),
            device: gpu.device.clone(),
            queue: gpu.queue.clone(),
            views,
            tier: 0,
        })
    }

    /// Goes on on another device.
    pub(crate) fn rebuild(&mut self, gpu: &Gpu) {
        (self.device, self.queue, self.scene) = (gpu.device.clone(), gpu.queue.clone(), Scene::new(&gpu.device));
        self.views.iter_mut().for_each(|view| view.rebuild(gpu));
    }

    /// One view becomes two, or two become one.
    pub(crate) fn split(&mut self) {
        match self.views.as_slice() {
            [only] => self.views.push(only.clone_for_view()),
            _ => self.views.truncate(1),
        }
    }

    /// The next tier: its plans come in from the background.
    pub(crate) fn change_tier(&mut self) -> Result<(), Box<dyn Error>> {
        self.tier = (self.tier + 1) % TIERS.len();
        for view in &mut self.views {
            view.change(graph(TIERS[self.tier])?);
        }
        Ok(())
    }

    /// Draws the scene and runs the pipeline, in one encoder.
    pub(crate) fn frame(&mut self, screen: &wgpu::TextureView, time: f32) -> Result<(), PostError> {
        let size = (screen.texture().width(), screen.texture().height());
        let halves = halves(size, self.views.len());
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.scene.draw(&self.device, &self.queue, &mut encoder, (size, time), &halves);
        let scene = self.scene.view.as_ref().expect("it was drawn");
        for (view, half) in self.views.iter_mut().zip(&halves) {
            let frame = Frame {
                inputs: &[("scene", scene)],
                outputs: &[("display", screen)],
                rectangles: &[("scene", *half), ("display", *half)],
                time: time.into(),
                dt: 1.0 / 60.0,
                ..Frame::default()
            };
            view.encode(&mut encoder, &frame)?;
        }
        self.queue.submit([encoder.finish()]);
        Ok(())
    }
}

/// The rectangles of that many views side by side.
fn halves((width, height): (u32, u32), views: usize) -> Vec<Rectangle> {
    let share = (width / views as u32).max(1);
    (0..views as u32).map(|view| Rectangle { x: view * share, y: 0, width: share, height }).collect()
}

fn graph(tier: &str) -> Result<Graph, Box<dyn Error>> {
    let kinds = Registry::new(&[afterimage_nodes::ALL])?;
    let options = CheckOptions { tier: Some(tier.to_owned()), ..CheckOptions::default() };
    Ok(check(&parse("lynx.ron", PIPELINE)?, &kinds, &options)?.0)
}

/// The renderer's own pass.
struct Scene {
    pipeline: wgpu::RenderPipeline,
    time: wgpu::Buffer,
    group: wgpu::BindGroup,
    view: Option<wgpu::TextureView>,
}

impl Scene {
    fn new(device: &wgpu::Device) -> Self {
        let source = wgpu::ShaderSource::Wgsl(SCENE.into());
        let module = &device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("scene"), source });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("scene"),
            layout: None,
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("corner"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some("scene"),
                compilation_options: Default::default(),
                targets: &[Some(wgpu::TextureFormat::Rgba16Float.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let descriptor = wgpu::BufferDescriptor { label: Some("time"), size: 16, usage, mapped_at_creation: false };
        let time = device.create_buffer(&descriptor);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: time.as_entire_binding() }],
        });
        Self { pipeline, time, group, view: None }
    }

    fn draw(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        (size, time): ((u32, u32), f32),
        halves: &[Rectangle],
    ) {
        let has_size = |view: &wgpu::TextureView| (view.texture().width(), view.texture().height()) == size;
        let view = self.view.take_if(|view| has_size(view)).unwrap_or_else(|| target(device, size));
        queue.write_buffer(&self.time, 0, &[time, 0.0, 0.0, 0.0].map(f32::to_le_bytes).concat());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("scene"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations::default(),
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        for (number, half) in (0..).zip(halves) {
            pass.set_viewport(half.x as f32, half.y as f32, half.width as f32, half.height as f32, 0.0, 1.0);
            pass.draw(0..3, number..number + 1);
        }
        drop(pass);
        self.view = Some(view);
    }
}

fn target(device: &wgpu::Device, (width, height): (u32, u32)) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("scene"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Writes the still picture without a window, as a portable pixel map.
pub(crate) fn write_picture(path: &str, (width, height): (u32, u32)) -> Result<(), Box<dyn Error>> {
    let gpu = Gpu::open(&Opening::default())?;
    let mut renderer = Renderer::new(&gpu)?;
    let screen = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("screen"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    renderer.frame(&screen.create_view(&wgpu::TextureViewDescriptor::default()), 1.0)?;
    let texels = download(&gpu.device, &gpu.queue, &screen)?;
    let mut file = std::fs::File::create(path)?;
    write!(file, "P6\n{width} {height}\n255\n")?;
    let colors: Vec<u8> = texels.bytes.as_chunks::<4>().0.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
    file.write_all(&colors)?;
    Ok(())
}
