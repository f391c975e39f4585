//! Dispatches with all their GPU objects.

use afterimage_gpu::wgpu::util::DeviceExt as _;
use afterimage_gpu::wgpu::{self, BindGroupEntry, BindingResource, TextureFormat, TextureUsages, TextureView};
use afterimage_gpu::{Gpu, InputImage, TimedCommands, download};
use afterimage_graph::image::{Format, Size};
use afterimage_graph::node::Camera;
use afterimage_lab::LabError;

use crate::raw::{compute_pipeline, dispatch, group, groups, target};

/// Dispatches, the last of which writes `result`.
pub(crate) struct Chain {
    dispatches: Vec<(wgpu::ComputePipeline, wgpu::BindGroup, [u32; 2])>,
    result: TextureView,
}

impl Chain {
    /// No dispatches yet.
    pub(super) fn new(result: TextureView) -> Self {
        Self { dispatches: Vec::new(), result }
    }

    /// Adds an entry point over as many texels as the last of the bindings has, which is its result.
    pub(super) fn add(&mut self, gpu: &Gpu, module: &wgpu::ShaderModule, entry: &str, bindings: &[(u32, Bound<'_>)]) {
        let pipeline = compute_pipeline(gpu, module, entry);
        let entries: Vec<BindGroupEntry<'_>> = bindings
            .iter()
            .map(|(binding, bound)| BindGroupEntry { binding: *binding, resource: bound.get() })
            .collect();
        let bound = group(gpu, &pipeline.get_bind_group_layout(0), &entries);
        let Some((_, Bound::Image(result))) = bindings.last() else { return };
        let texture = result.texture();
        self.dispatches.push((pipeline, bound, groups(Size::new(texture.width(), texture.height()))));
    }

    /// Its commands.
    pub(crate) fn recording(&self) -> TimedCommands<'_> {
        Box::new(|encoder| {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            for (pipeline, group, groups) in &self.dispatches {
                dispatch(&mut pass, pipeline, group, *groups);
            }
            Ok(())
        })
    }

    /// The image that it has made.
    pub(crate) fn picture(&self, gpu: &Gpu) -> Result<Vec<[f32; 4]>, LabError> {
        Ok(download(&gpu.device, &gpu.queue, self.result.texture())?.to_floats())
    }
}

/// A resource that a shader reads or writes.
#[derive(Clone, Copy)]
pub(super) enum Bound<'a> {
    Image(&'a TextureView),
    Buffer(&'a wgpu::Buffer),
    Sampler(&'a wgpu::Sampler),
}

impl<'a> Bound<'a> {
    fn get(self) -> BindingResource<'a> {
        match self {
            Self::Image(view) => BindingResource::TextureView(view),
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::Sampler(sampler) => BindingResource::Sampler(sampler),
        }
    }
}

/// The image of an input.
pub(super) fn image<'a>(images: &'a [InputImage], input: &str) -> Option<&'a TextureView> {
    images.iter().find(|image| image.input == input).map(|image| &image.view)
}

/// The size of a view's texture.
pub(super) fn size_of(view: &TextureView) -> Size {
    Size::new(view.texture().width(), view.texture().height())
}

/// An image that one dispatch writes and another reads.
pub(super) fn between(gpu: &Gpu, size: Size, format: TextureFormat) -> TextureView {
    let usage = TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC;
    target(gpu, size, format, usage)
}

/// The format of two numbers, and its name in WGSL: half floats, with two unused channels where a device cannot store
/// two.
pub(super) fn pair(gpu: &Gpu) -> (TextureFormat, &'static str) {
    match gpu.caps.storage.contains(&Format::Rg16Float) {
        true => (TextureFormat::Rg16Float, "rg16float"),
        false => (TextureFormat::Rgba16Float, "rgba16float"),
    }
}

/// A uniform buffer.
pub(super) fn uniform(gpu: &Gpu, numbers: &[f32]) -> wgpu::Buffer {
    // A multiple of 16 bytes, as structs in uniform buffers have.
    let mut padded = numbers.to_vec();
    padded.resize(numbers.len().next_multiple_of(4), 0.0);
    gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("settings"),
        contents: bytemuck::cast_slice(&padded),
        usage: wgpu::BufferUsages::UNIFORM,
    })
}

/// From uv to the camera's x and y at a distance of 1: factors, then offsets. For perspective projections.
pub(super) fn unprojection(camera: &Camera) -> [f32; 4] {
    let m = camera.projection;
    let (x, y) = (m[0][0], m[1][1]);
    [2.0 / x, -2.0 / y, (m[2][0] - 1.0) / x, (m[2][1] + 1.0) / y]
}
