//! Full-screen draws.

/// A render pipeline that draws one triangle over a whole target, without vertex buffers and depth.
pub struct FullScreenPipeline<'a> {
    /// The pipeline's name in tools and errors.
    pub label: &'a str,
    /// The module of both entry points.
    pub module: &'a wgpu::ShaderModule,
    /// The vertex entry point, which makes the corners of the triangle from the indices 0, 1 and 2.
    pub vertex: &'a str,
    /// The fragment entry point.
    pub fragment: &'a str,
    /// The layout; `None` derives it from the module.
    pub layout: Option<&'a wgpu::PipelineLayout>,
    /// The format of the target.
    pub format: wgpu::TextureFormat,
    /// Samples in each pixel of the target.
    pub samples: u32,
    /// The driver's pipeline cache.
    pub cache: Option<&'a wgpu::PipelineCache>,
}

impl FullScreenPipeline<'_> {
    /// Compiles the pipeline.
    pub fn create(&self, device: &wgpu::Device) -> wgpu::RenderPipeline {
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.label),
            layout: self.layout,
            vertex: wgpu::VertexState {
                module: self.module,
                entry_point: Some(self.vertex),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState { count: self.samples, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: self.module,
                entry_point: Some(self.fragment),
                compilation_options: Default::default(),
                targets: &[Some(self.format.into())],
            }),
            multiview_mask: None,
            cache: self.cache,
        })
    }
}

/// Begins a render pass with one color attachment, which is stored.
pub fn color_pass<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: Option<&str>,
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPass<'e> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label,
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
        })],
        ..Default::default()
    })
}
