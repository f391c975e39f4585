//! Draws images of a pipeline into the window.

use afterimage_gpu::{Gpu, wgpu};
use bytemuck::{Pod, Zeroable};

use super::device;

/// Placement and appearance of an image: the uniform of `picture.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Placement {
    /// The picture's upper left corner, in physical pixels.
    pub origin: [f32; 2],
    /// Physical pixels that the picture covers.
    pub extent: [f32; 2],
    /// A factor of the numbers.
    pub gain: f32,
    pub bias: f32,
    /// The first column of the other picture, in physical pixels.
    pub wipe: f32,
    /// The factor of a difference.
    pub difference: f32,
    /// The channel that is shown alone, 0 to 3; 4 for all.
    pub channel: u32,
    pub flags: u32,
    /// The slice of a volume.
    pub slice: u32,
    /// The peak luminance of the display, where 1 is SDR white.
    pub peak: f32,
}

pub struct Flags;

impl Flags {
    pub const SMOOTH: u32 = 1;
    /// The values are linear, and are encoded for the window.
    pub const IS_LINEAR: u32 = 2;
    pub const FALSE_COLOR: u32 = 4;
    pub const CLIPPING: u32 = 8;
    /// NaN, infinite and negative pixels are striped.
    pub const FAULTS: u32 = 16;
    /// The other picture is shown beyond the wipe.
    pub const COMPARES: u32 = 32;
    pub const DIFFERS: u32 = 64;
}

#[derive(Clone)]
pub struct Shown<'t> {
    pub image: &'t wgpu::Texture,
    /// The picture that it is compared with.
    pub other: Option<&'t wgpu::Texture>,
    pub placement: Placement,
}

/// The pipelines that draw images.
pub struct Painter {
    gpu: Gpu,
    flat: Pipelines,
    volume: Pipelines,
}

struct Pipelines {
    layout: wgpu::BindGroupLayout,
    draw: wgpu::RenderPipeline,
    grid: wgpu::RenderPipeline,
}

/// The format of the coarse grid that scopes read.
pub(super) const GRID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

impl Painter {
    /// For a target of that format.
    pub fn new(gpu: &Gpu, target: wgpu::TextureFormat) -> Self {
        Self {
            gpu: gpu.clone(),
            flat: Pipelines::new(&gpu.device, target, wgpu::TextureViewDimension::D2),
            volume: Pipelines::new(&gpu.device, target, wgpu::TextureViewDimension::D3),
        }
    }

    /// A draw for a render pass.
    pub fn drawn(&self, shown: &Shown<'_>) -> Drawn {
        let pipelines = self.pipelines(shown.image);
        Drawn { pipeline: pipelines.draw.clone(), group: self.group(pipelines, shown) }
    }

    /// The same for the coarse grid of the scopes.
    pub(super) fn sampled(&self, shown: &Shown<'_>) -> Drawn {
        let pipelines = self.pipelines(shown.image);
        Drawn { pipeline: pipelines.grid.clone(), group: self.group(pipelines, shown) }
    }

    fn pipelines(&self, image: &wgpu::Texture) -> &Pipelines {
        if image.dimension() == wgpu::TextureDimension::D3 { &self.volume } else { &self.flat }
    }

    fn group(&self, pipelines: &Pipelines, shown: &Shown<'_>) -> wgpu::BindGroup {
        let uniform = device::uniform(&self.gpu, "placement", &shown.placement);
        let image = shown.image.create_view(&Default::default());
        let other = shown.other.filter(|other| other.dimension() == wgpu::TextureDimension::D2);
        let other = other.map(|other| other.create_view(&Default::default()));
        let other = other.unwrap_or_else(|| self.nothing());
        self.gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("picture"),
            layout: &pipelines.layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&image) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::TextureView(&other) },
            ],
        })
    }

    /// A picture for the place of the other one where there is none.
    fn nothing(&self) -> wgpu::TextureView {
        let (format, usage) = (wgpu::TextureFormat::Rgba8Unorm, wgpu::TextureUsages::TEXTURE_BINDING);
        let texture = device::image(&self.gpu.device, "no other picture", [1, 1], format, usage);
        texture.create_view(&Default::default())
    }
}

/// An image that is ready to be drawn into a render pass.
#[derive(Clone)]
pub struct Drawn {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
}

impl Drawn {
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

impl Pipelines {
    fn new(gpu: &wgpu::Device, target: wgpu::TextureFormat, shape: wgpu::TextureViewDimension) -> Self {
        let is_volume = shape == wgpu::TextureViewDimension::D3;
        let source = if is_volume { include_str!("volume.wgsl") } else { include_str!("flat.wgsl") };
        let shader = device::module(gpu, "picture", &[include_str!("picture.wgsl"), source]);
        let layout = gpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("picture"),
            entries: &[uniform_entry(), texture_entry(1, shape), texture_entry(2, wgpu::TextureViewDimension::D2)],
        });
        let whole = gpu.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("picture"),
            bind_group_layouts: &[Some(&layout)],
            ..Default::default()
        });
        let draw = device::full_screen(gpu, Some(&whole), &shader, "draw", target);
        let grid = device::full_screen(gpu, Some(&whole), &shader, "sample_grid", GRID_FORMAT);
        Self { layout, draw, grid }
    }
}

fn uniform_entry() -> wgpu::BindGroupLayoutEntry {
    let ty = wgpu::BufferBindingType::Uniform;
    wgpu::BindGroupLayoutEntry {
        binding: 0,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    }
}

fn texture_entry(binding: u32, view_dimension: wgpu::TextureViewDimension) -> wgpu::BindGroupLayoutEntry {
    // Texels are loaded, so images of 32 bits need no filter of the device.
    let sample_type = wgpu::TextureSampleType::Float { filterable: false };
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false },
        count: None,
    }
}
