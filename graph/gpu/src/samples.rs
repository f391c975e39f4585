//! Multisampled textures from texels: a device copies nothing into one, so a draw fills it, sample by sample.

use afterimage_graph::image::{ImageDesc, Size};

use crate::error::GpuError;
use crate::full_screen::{FullScreenPipeline, color_pass};
use crate::platform::{submit, watched};
use crate::store;
use crate::texture_format::texture_format;

/// Each sample is the texel of a layer.
const FILL: &str = "
@group(0) @binding(0) var texels: texture_2d_array<f32>;
@vertex fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(vec2f(vec2u(index & 1u, index >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}
@fragment fn fill(@builtin(position) at: vec4f, @builtin(sample_index) index: u32) -> @location(0) vec4f {
    return textureLoad(texels, vec2u(at.xy), index, 0);
}
";

/// True if the device has textures of the description's format with that many samples. wgpu has no query for it on a
/// device, so a small one is made by trial.
fn is_supported(device: &wgpu::Device, desc: ImageDesc) -> bool {
    let small = desc.sized(Size::new(1, 1));
    watched(device, "a multisampled texture", || Ok(store::create(device, small, "samples"))).is_ok()
}

/// A texture whose samples are these: `bytes` has all first samples, then all second ones.
pub(crate) fn upload(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    desc: ImageDesc,
    bytes: &[u8],
) -> Result<wgpu::Texture, GpuError> {
    if !is_supported(device, desc) {
        let counts = [2, 4, 8, 16].into_iter().filter(|samples| is_supported(device, desc.multisampled(*samples)));
        let supported: Vec<String> = counts.map(|samples| samples.to_string()).collect();
        return Err(GpuError::Samples {
            samples: desc.samples,
            format: desc.format.name(),
            supported: if supported.is_empty() { "one only".into() } else { supported.join(" and ") },
        });
    }
    let layers = ImageDesc { samples: 1, ..desc }.with_layers(desc.samples);
    let texels = store::create(device, layers, "samples").texture;
    store::upload(queue, &texels, layers, bytes)?;
    let all =
        wgpu::TextureViewDescriptor { dimension: Some(wgpu::TextureViewDimension::D2Array), ..Default::default() };
    let texels = texels.create_view(&all);
    let result = store::create(device, desc, "multisampled input");
    let source = wgpu::ShaderSource::Wgsl(FILL.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
    let pipeline = FullScreenPipeline {
        label: "samples",
        module: &module,
        vertex: "corner",
        fragment: "fill",
        layout: None,
        format: texture_format(desc.format),
        samples: desc.samples,
        cache: None,
    };
    let pipeline = pipeline.create(device);
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&texels) }],
    });
    submit(device, queue, "the samples of an image", |encoder| {
        let mut pass = color_pass(encoder, None, &result.view, wgpu::LoadOp::Clear(wgpu::Color::BLACK));
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
        Ok::<(), GpuError>(())
    })?;
    Ok(result.texture)
}
