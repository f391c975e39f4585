//! The copy bandwidth of the device, which the bandwidth of passes is compared with.

use afterimage_gpu::wgpu::{BufferUsages, ShaderSource, TextureUsages};
use afterimage_gpu::{Clock, Gpu, TimedCommands, wgpu};
use afterimage_graph::image::Size;

use crate::LabError;

/// The copied image: larger than any cache.
const LARGE: Size = Size { width: 7680, height: 4320, depth: 1 };
/// The copied image on a processor, which is slow and has small caches.
const SMALL: Size = Size { width: 1920, height: 1080, depth: 1 };
const SAMPLES: u32 = 15;

/// Gigabytes per second, reads and writes both counted: the higher of a compute shader that copies half-float colors
/// and of a buffer copy.
///
/// # Errors
/// Errors of the device.
pub fn bandwidth(gpu: &Gpu, clock: &Clock) -> Result<f64, LabError> {
    let size = if gpu.is_processor() { SMALL } else { LARGE };
    let side = |length: u32| length.min(gpu.caps.max_side);
    let size = Size::new(side(size.width), side(size.height));
    Ok(by_shader(gpu, clock, size)?.max(by_buffers(gpu, clock, size)?))
}

fn gigabytes_per_second(bytes: u64, milliseconds: f64) -> f64 {
    2.0 * bytes as f64 * 1e-6 / milliseconds
}

fn by_shader(gpu: &Gpu, clock: &Clock, size: Size) -> Result<f64, LabError> {
    let source = ShaderSource::Wgsl(include_str!("copy.wgsl").into());
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("copy"), source });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("copy"),
        layout: None,
        module: &module,
        entry_point: Some("copy"),
        compilation_options: Default::default(),
        cache: None,
    });
    let texture = wgpu::TextureDescriptor {
        label: Some("copied"),
        size: wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::STORAGE_BINDING,
        view_formats: &[],
    };
    let [from, to] = [(); 2].map(|()| gpu.device.create_texture(&texture).create_view(&Default::default()));
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&from) },
            wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&to) },
        ],
    });
    let copy: TimedCommands<'_> = Box::new(|encoder| {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(size.width.div_ceil(16), size.height.div_ceil(16), 1);
        drop(pass);
        Ok(())
    });
    let time = clock.medians(SAMPLES, &mut [copy])?[0].ms();
    Ok(gigabytes_per_second(u64::from(size.width) * u64::from(size.height) * 8, time))
}

fn by_buffers(gpu: &Gpu, clock: &Clock, size: Size) -> Result<f64, LabError> {
    let bytes = u64::from(size.width) * u64::from(size.height) * 8;
    let bytes = bytes.min(gpu.device.limits().max_buffer_size) / 16 * 16;
    let buffer = |usage| {
        gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("copied"),
            size: bytes,
            usage,
            mapped_at_creation: false,
        })
    };
    let (from, to) = (buffer(BufferUsages::COPY_SRC), buffer(BufferUsages::COPY_DST));
    let copy: TimedCommands<'_> = Box::new(|encoder| {
        encoder.copy_buffer_to_buffer(&from, 0, &to, 0, bytes);
        Ok(())
    });
    let time = clock.medians(SAMPLES, &mut [copy])?[0].ms();
    Ok(gigabytes_per_second(bytes, time))
}
