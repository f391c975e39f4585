//! The device's own copy bandwidth: the yardstick of every pass.

use afterimage_gpu::Gpu;
use afterimage_graph::image::Size;
use wgpu::{BufferUsages, TextureUsages};

use super::clock::Stopwatch;
use super::plain::{compute_pipeline, group, module, target};
use crate::failure::Failure;

/// The image that is copied: so large that no cache holds it.
const LARGE: Size = Size { width: 7680, height: 4320, depth: 1 };
/// A processor copies that too slowly to wait for, and its caches are small.
const SMALL: Size = Size { width: 1920, height: 1080, depth: 1 };
const RUNS: u32 = 15;

/// Gigabytes a second, read and written ones counted both: the better of a compute shader that copies half-float colours and of a buffer copy.
pub(crate) fn bandwidth(gpu: &Gpu, stopwatch: &Stopwatch<'_>) -> Result<f64, Failure> {
    let size = if gpu.is_processor() { SMALL } else { LARGE };
    let side = |length: u32| length.min(gpu.caps.max_side);
    let size = Size::new(side(size.width), side(size.height));
    Ok(by_shader(gpu, stopwatch, size)?.max(by_buffers(gpu, stopwatch, size)?))
}

fn gigabytes_a_second(bytes: u64, milliseconds: f64) -> f64 {
    2.0 * bytes as f64 * 1e-6 / milliseconds
}

fn by_shader(gpu: &Gpu, stopwatch: &Stopwatch<'_>, size: Size) -> Result<f64, Failure> {
    let format = wgpu::TextureFormat::Rgba16Float;
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::STORAGE_BINDING;
    let (from, to) = (target(gpu, size, format, usage), target(gpu, size, format, usage));
    let entry = |binding, view| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) };
    let pipeline = compute_pipeline(gpu, &module(gpu, include_str!("copy.wgsl")), "copy");
    let group = group(gpu, &pipeline.get_bind_group_layout(0), &[entry(0, &from), entry(1, &to)]);
    let time = stopwatch.median(RUNS, |encoder| {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(size.width.div_ceil(16), size.height.div_ceil(16), 1);
        Ok(())
    })?;
    Ok(gigabytes_a_second(u64::from(size.width) * u64::from(size.height) * 8, time))
}

fn by_buffers(gpu: &Gpu, stopwatch: &Stopwatch<'_>, size: Size) -> Result<f64, Failure> {
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
    let time = stopwatch.median(RUNS, |encoder| {
        encoder.copy_buffer_to_buffer(&from, 0, &to, 0, bytes);
        Ok(())
    })?;
    Ok(gigabytes_a_second(bytes, time))
}
