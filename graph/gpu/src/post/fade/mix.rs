//! The mix of two images into the host's view during a fade.

use wgpu::{BindGroup, CommandEncoder, Device, RenderPipeline, Texture, TextureFormat, TextureView};

use crate::executor::{Executor, Rectangle};
use crate::full_screen::FullScreenPipeline;
use crate::store::part_view;

/// Each texel of the view: of the old image and of the new one, by the share of frames that have passed.
const MIX: &str = "
@group(0) @binding(0) var before: texture_2d<f32>;
@group(0) @binding(1) var after: texture_2d<f32>;

struct Corner {
    @builtin(position) at: vec4f,
    @location(0) uv: vec2f,
    @location(1) @interpolate(flat) weight: f32,
}

@vertex fn corner(@builtin(vertex_index) index: u32, @builtin(instance_index) share: u32) -> Corner {
    let at = vec2f(vec2u(index & 1u, index >> 1u)) * 4.0 - 1.0;
    // The number of the frame, and the number of frames behind it.
    let weight = f32(share >> 16u) / f32(share & 0xffffu);
    return Corner(vec4f(at, 0.0, 1.0), vec2f(0.5, -0.5) * at + 0.5, weight);
}

@fragment fn mixed(corner: Corner) -> @location(0) vec4f {
    let at = vec2u(corner.uv * vec2f(textureDimensions(after)));
    return mix(textureLoad(before, at, 0), textureLoad(after, at, 0), corner.weight);
}
";

/// What a fade needs; it is prepared with the new plan.
pub(in crate::post) struct FadeParts {
    /// The executor that continues the old plan.
    pub(in crate::post) fork: Executor,
    pub(in crate::post) mixer: Mixer,
}

/// The pipeline that mixes into views of a format.
pub(in crate::post) struct Mixer {
    pub(in crate::post) format: TextureFormat,
    pipeline: RenderPipeline,
}

/// Where a mix is drawn.
pub(in crate::post) struct Target<'a> {
    pub(in crate::post) view: &'a TextureView,
    pub(in crate::post) rectangle: Option<Rectangle>,
}

impl Mixer {
    pub(in crate::post) fn new(device: &Device, format: TextureFormat) -> Self {
        let source = wgpu::ShaderSource::Wgsl(MIX.into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("fade"), source });
        let pipeline = FullScreenPipeline {
            label: "fade",
            module: &module,
            vertex: "corner",
            fragment: "mixed",
            layout: None,
            format,
            samples: 1,
            cache: None,
        };
        Self { format, pipeline: pipeline.create(device) }
    }

    /// The bind group of two images of equal size.
    pub(in crate::post) fn bind_group(&self, device: &Device, before: &Texture, after: &Texture) -> BindGroup {
        let [before, after] = [before, after].map(|texture| part_view(texture, 0, 0));
        let [before, after] = [&before, &after].map(wgpu::BindingResource::TextureView);
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("fade"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: before },
                wgpu::BindGroupEntry { binding: 1, resource: after },
            ],
        })
    }

    /// Records the mix of frame `number` of a fade, with the weight `number / (frames + 1)` of the new image.
    pub(in crate::post) fn record(
        &self,
        encoder: &mut CommandEncoder,
        images: &BindGroup,
        target: &Target<'_>,
        number: u16,
        frames: u16,
    ) {
        // What is around a rectangle stays.
        let load = target.rectangle.map_or(wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), |_| wgpu::LoadOp::Load);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("afterimage fade"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target.view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        if let Some(Rectangle { x, y, width, height }) = target.rectangle {
            pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
            pass.set_scissor_rect(x, y, width, height);
        }
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, images, &[]);
        let share = u32::from(number) << 16 | (u32::from(frames) + 1);
        pass.draw(0..3, share..share + 1);
    }
}
