//! Textures, uniforms, pipelines and passes of the viewer's own drawing.

use afterimage_gpu::{FullScreenPipeline, Gpu, color_pass, wgpu};
use bytemuck::Pod;

/// A pipeline that draws one triangle over a whole target. The vertex entry point of the module is `corner`; without a
/// layout, the module decides it.
pub(super) fn full_screen(
    device: &wgpu::Device,
    layout: Option<&wgpu::PipelineLayout>,
    module: &wgpu::ShaderModule,
    fragment: &str,
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let label = fragment;
    let pipeline =
        FullScreenPipeline { label, module, vertex: "corner", fragment, layout, format, samples: 1, cache: None };
    pipeline.create(device)
}

/// A module of these parts, and of the functions `encode` and `decode` of sRGB.
pub(super) fn module(device: &wgpu::Device, label: &str, parts: &[&str]) -> wgpu::ShaderModule {
    let text = [include_str!("srgb.wgsl"), &parts.concat()].concat();
    let source = wgpu::ShaderSource::Wgsl(text.into());
    device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(label), source })
}

/// A uniform that holds these numbers.
pub(super) fn uniform(gpu: &Gpu, label: &str, numbers: &impl Pod) -> wgpu::Buffer {
    let bytes = bytemuck::bytes_of(numbers);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes.len() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        // A browser whose device is lost refuses buffers that are mapped when they are made.
        mapped_at_creation: false,
    });
    gpu.queue.write_buffer(&buffer, 0, bytes);
    buffer
}

/// An image with one level.
pub(crate) fn image(
    device: &wgpu::Device,
    label: &str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// A pass that draws onto a black target.
pub(crate) fn onto<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: &str,
    view: &wgpu::TextureView,
) -> wgpu::RenderPass<'e> {
    color_pass(encoder, Some(label), view, wgpu::LoadOp::Clear(wgpu::Color::BLACK))
}
