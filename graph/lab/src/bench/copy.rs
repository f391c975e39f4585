//! The copy bandwidth of the device, which the bandwidth of passes is compared with.

use afterimage_gpu::wgpu::{BufferUsages, ShaderSource, TextureUsages};
use afterimage_gpu::{Clock, Gpu, TimedCommands, wgpu};

use crate::LabError;

/// The copied image: larger than any cache.
const LARGE: [u32; 2] = [7680, 4320];
/// The copied image on a processor, which is slow and has small caches.
const SMALL: [u32; 2] = [1920, 1056];
const SAMPLES: u32 = 15;
/// Bytes of a texel of the image and of a vector of the buffer.
const TEXEL: u64 = 8;
const VECTOR: u64 = 16;
/// Sides of the image are multiples of this, and buffers have a multiple of this many vectors, so that every invocation
/// of every shape copies.
const SIDE: u32 = 32;
const VECTORS: u64 = 1024;

/// The fastest copy of the device.
#[derive(Clone, Copy, Debug)]
pub struct CopyBandwidth {
    /// Gigabytes per second, reads and writes both counted.
    pub gbps: f64,
    /// The shape of the copy that reached it.
    pub shape: &'static str,
}

/// Measures the bandwidth of copies by shaders, in several shapes, and by commands.
///
/// # Errors
/// Errors of the device.
pub fn bandwidth(gpu: &Gpu, clock: &Clock) -> Result<CopyBandwidth, LabError> {
    let sides = if gpu.is_processor() { SMALL } else { LARGE };
    let [width, height] = sides.map(|side| side.min(gpu.caps.max_side) / SIDE * SIDE);
    let bench = CopyBench::new(gpu, width, height);
    let shapes: [(&str, u64, TimedCommands<'_>); 6] = [
        ("texels_1", bench.image_bytes(), bench.shader("texels_1", [width / 16, height / 16])),
        ("texels_4", bench.image_bytes(), bench.shader("texels_4", [width / 32, height / 32])),
        ("vectors_1", bench.buffer_bytes, bench.shader("vectors_1", groups(bench.vectors(), 1))),
        ("vectors_4", bench.buffer_bytes, bench.shader("vectors_4", groups(bench.vectors(), 4))),
        ("buffers", bench.buffer_bytes, bench.buffer_command()),
        ("textures", bench.image_bytes(), bench.texture_command()),
    ];
    let mut best = CopyBandwidth { gbps: 0.0, shape: "" };
    for (shape, bytes, copy) in shapes {
        let time = clock.medians(SAMPLES, &mut [copy])?[0].ms();
        let gbps = 2.0 * bytes as f64 * 1e-6 / time;
        if gbps > best.gbps {
            best = CopyBandwidth { gbps, shape };
        }
    }
    Ok(best)
}

/// The workgroups of 256 invocations for so many vectors, in two dimensions: one alone may not have enough.
fn groups(vectors: u64, each: u64) -> [u32; 2] {
    let all = (vectors / (256 * each)) as u32;
    let rows = all.div_ceil(32768);
    [all.div_ceil(rows), rows]
}

/// The copied resource and the shader or command that copies it.
struct CopyBench<'g> {
    gpu: &'g Gpu,
    module: wgpu::ShaderModule,
    images: [wgpu::Texture; 2],
    buffers: [wgpu::Buffer; 2],
    buffer_bytes: u64,
}

impl<'g> CopyBench<'g> {
    fn new(gpu: &'g Gpu, width: u32, height: u32) -> Self {
        let source = ShaderSource::Wgsl(include_str!("copy.wgsl").into());
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("copy"), source });
        let image = |usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("copied"),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba16Float,
                usage,
                view_formats: &[],
            })
        };
        let limits = gpu.device.limits();
        let most = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        let bytes = (u64::from(width) * u64::from(height) * TEXEL).min(most);
        let buffer_bytes = bytes / (VECTOR * VECTORS) * VECTOR * VECTORS;
        let buffer = |usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("copied"),
                size: buffer_bytes,
                usage: BufferUsages::STORAGE | usage,
                mapped_at_creation: false,
            })
        };
        let images = [
            image(TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC),
            image(TextureUsages::STORAGE_BINDING | TextureUsages::COPY_DST),
        ];
        let buffers = [buffer(BufferUsages::COPY_SRC), buffer(BufferUsages::COPY_DST)];
        Self { gpu, module, images, buffers, buffer_bytes }
    }

    fn image_bytes(&self) -> u64 {
        u64::from(self.images[0].width()) * u64::from(self.images[0].height()) * TEXEL
    }

    fn vectors(&self) -> u64 {
        self.buffer_bytes / VECTOR
    }

    /// A copy by an entry point of the module, which binds either the images or the buffers.
    fn shader(&self, entry: &str, [columns, rows]: [u32; 2]) -> TimedCommands<'_> {
        let pipeline = self.gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: None,
            module: &self.module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            cache: None,
        });
        let views = self.images.each_ref().map(|image| image.create_view(&Default::default()));
        let [from, to] = &self.buffers;
        let resources = if entry.starts_with("texels") {
            [(0, wgpu::BindingResource::TextureView(&views[0])), (1, wgpu::BindingResource::TextureView(&views[1]))]
        } else {
            [(2, from.as_entire_binding()), (3, to.as_entire_binding())]
        };
        let group = self.gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &resources.map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }),
        });
        Box::new(move |encoder| {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(columns, rows, 1);
            Ok(())
        })
    }

    fn buffer_command(&self) -> TimedCommands<'_> {
        Box::new(|encoder| {
            encoder.copy_buffer_to_buffer(&self.buffers[0], 0, &self.buffers[1], 0, self.buffer_bytes);
            Ok(())
        })
    }

    fn texture_command(&self) -> TimedCommands<'_> {
        Box::new(|encoder| {
            let [from, to] = self.images.each_ref().map(|image| image.as_image_copy());
            encoder.copy_texture_to_texture(from, to, self.images[0].size());
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_workgroups_of_a_buffer_cover_it_within_the_limits_of_a_dimension() {
        for (vectors, each) in [(1024, 1), (1024, 4), (16_588_800, 1), (16_588_800, 4), (1 << 30, 1)] {
            let [columns, rows] = groups(vectors, each);
            assert!(u64::from(columns) * u64::from(rows) * 256 * each >= vectors, "{vectors} of {each}");
            assert!(columns < 65536 && rows < 65536, "{columns} x {rows}");
        }
    }
}
