//! Render pipelines of drawing passes, from their description.

use afterimage_graph::node::{
    Blend, BlendComponent, BlendFactor, ColorAttachment, Compare, Cull, Drawing, Factors, Geometry, Raster, Topology,
    VertexBuffer, VertexFormat, WriteMask,
};
use afterimage_plan::Plan;
use afterimage_plan::codegen::Draw;
use wgpu::{ColorTargetState, VertexAttribute, VertexStepMode};

use crate::texture_format::texture_format;

/// The state of a drawing pass's pipeline, without its module and its bindings.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct DrawState {
    colors: Vec<ColorTargetState>,
    depth: Option<wgpu::DepthStencilState>,
    samples: u32,
    /// `None` if the pass only clears, or the host draws with pipelines of its own.
    geometry: Option<GeometryState>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct GeometryState {
    vertices: Vec<Vertices>,
    primitive: wgpu::PrimitiveState,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Vertices {
    stride: u64,
    step: VertexStepMode,
    attributes: Vec<VertexAttribute>,
}

impl DrawState {
    pub(crate) fn new(plan: &Plan, drawing: &Drawing) -> Self {
        let desc = |image| plan.image(image).desc;
        let geometry = drawing.geometry();
        let raster = geometry.map(|geometry| geometry.raster).unwrap_or_default();
        let depth = drawing.depth.map(|depth| wgpu::DepthStencilState {
            format: texture_format(desc(depth.target.image).format),
            depth_write_enabled: Some(depth.test.write),
            depth_compare: Some(compare(depth.test.compare)),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState { constant: raster.bias, slope_scale: raster.slope_bias, clamp: 0.0 },
        });
        Self {
            colors: drawing.colors.iter().map(|color| color_target(plan, color)).collect(),
            depth,
            samples: drawing.targets().next().map_or(1, |target| desc(target.image).samples),
            geometry: geometry.map(|geometry| GeometryState {
                vertices: vertices(geometry),
                primitive: primitive(&raster, geometry.indices.is_some()),
            }),
        }
    }

    /// True if the pass draws with a pipeline of the plan.
    pub(crate) fn has_geometry(&self) -> bool {
        self.geometry.is_some()
    }
}

pub(crate) fn render_pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    entries: &Draw,
    layout: &wgpu::PipelineLayout,
    state: &DrawState,
    cache: Option<&wgpu::PipelineCache>,
) -> wgpu::RenderPipeline {
    let geometry = state.geometry.as_ref().expect("a pass with a module has geometry");
    let layouts: Vec<_> = geometry.vertices.iter().map(|vertices| Some(vertices.layout())).collect();
    let targets: Vec<Option<ColorTargetState>> = state.colors.iter().cloned().map(Some).collect();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("afterimage"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(&entries.vertex),
            compilation_options: Default::default(),
            buffers: &layouts,
        },
        primitive: geometry.primitive,
        depth_stencil: state.depth.clone(),
        multisample: wgpu::MultisampleState { count: state.samples, ..Default::default() },
        fragment: entries.fragment.as_deref().map(|entry| wgpu::FragmentState {
            module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache,
    })
}

impl Vertices {
    fn layout(&self) -> wgpu::VertexBufferLayout<'_> {
        wgpu::VertexBufferLayout { array_stride: self.stride, step_mode: self.step, attributes: &self.attributes }
    }
}

/// The buffers of vertices, whose locations count on from one to the next.
fn vertices(geometry: &Geometry) -> Vec<Vertices> {
    let mut location = 0;
    let mut of_buffer = |vertices: &VertexBuffer| {
        let mut offset = 0;
        let attribute = |format: &VertexFormat| {
            let attribute = VertexAttribute { format: vertex_format(*format), offset, shader_location: location };
            (offset, location) = (offset + format.bytes(), location + 1);
            attribute
        };
        Vertices {
            stride: vertices.stride(),
            step: if vertices.per_instance { VertexStepMode::Instance } else { VertexStepMode::Vertex },
            attributes: vertices.formats.iter().map(attribute).collect(),
        }
    };
    geometry.vertices.iter().map(&mut of_buffer).collect()
}

fn primitive(raster: &Raster, has_indices: bool) -> wgpu::PrimitiveState {
    let topology = match raster.topology {
        Topology::Triangles => wgpu::PrimitiveTopology::TriangleList,
        Topology::TriangleStrip => wgpu::PrimitiveTopology::TriangleStrip,
        Topology::Lines => wgpu::PrimitiveTopology::LineList,
        Topology::Points => wgpu::PrimitiveTopology::PointList,
    };
    wgpu::PrimitiveState {
        topology,
        strip_index_format: (topology.is_strip() && has_indices).then_some(wgpu::IndexFormat::Uint32),
        front_face: if raster.clockwise { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
        cull_mode: match raster.cull {
            Cull::None => None,
            Cull::Front => Some(wgpu::Face::Front),
            Cull::Back => Some(wgpu::Face::Back),
        },
        ..Default::default()
    }
}

fn vertex_format(format: VertexFormat) -> wgpu::VertexFormat {
    match format {
        VertexFormat::Float32 => wgpu::VertexFormat::Float32,
        VertexFormat::Float32x2 => wgpu::VertexFormat::Float32x2,
        VertexFormat::Float32x3 => wgpu::VertexFormat::Float32x3,
        VertexFormat::Float32x4 => wgpu::VertexFormat::Float32x4,
        VertexFormat::Uint32 => wgpu::VertexFormat::Uint32,
        VertexFormat::Unorm8x4 => wgpu::VertexFormat::Unorm8x4,
    }
}

fn color_target(plan: &Plan, color: &ColorAttachment) -> ColorTargetState {
    let ColorAttachment { target, load: _, blend, writes: WriteMask(channels) } = *color;
    let all = [wgpu::ColorWrites::RED, wgpu::ColorWrites::GREEN, wgpu::ColorWrites::BLUE, wgpu::ColorWrites::ALPHA];
    ColorTargetState {
        format: texture_format(plan.image(target.image).desc.format),
        // Formats that cannot blend can be replaced.
        blend: (blend != Blend::REPLACE)
            .then(|| wgpu::BlendState { color: blend_component(blend.color), alpha: blend_component(blend.alpha) }),
        write_mask: all.into_iter().zip(channels).filter(|(_, writes)| *writes).map(|(channel, _)| channel).collect(),
    }
}

fn blend_component(component: BlendComponent) -> wgpu::BlendComponent {
    let one = Factors { source: BlendFactor::One, target: BlendFactor::One };
    let (operation, factors) = match component {
        BlendComponent::Add(factors) => (wgpu::BlendOperation::Add, factors),
        BlendComponent::Subtract(factors) => (wgpu::BlendOperation::Subtract, factors),
        BlendComponent::ReverseSubtract(factors) => (wgpu::BlendOperation::ReverseSubtract, factors),
        BlendComponent::Min => (wgpu::BlendOperation::Min, one),
        BlendComponent::Max => (wgpu::BlendOperation::Max, one),
    };
    let [src_factor, dst_factor] = [factors.source, factors.target].map(blend_factor);
    wgpu::BlendComponent { src_factor, dst_factor, operation }
}

fn blend_factor(factor: BlendFactor) -> wgpu::BlendFactor {
    match factor {
        BlendFactor::Zero => wgpu::BlendFactor::Zero,
        BlendFactor::One => wgpu::BlendFactor::One,
        BlendFactor::Source => wgpu::BlendFactor::Src,
        BlendFactor::OneMinusSource => wgpu::BlendFactor::OneMinusSrc,
        BlendFactor::SourceAlpha => wgpu::BlendFactor::SrcAlpha,
        BlendFactor::OneMinusSourceAlpha => wgpu::BlendFactor::OneMinusSrcAlpha,
        BlendFactor::Target => wgpu::BlendFactor::Dst,
        BlendFactor::OneMinusTarget => wgpu::BlendFactor::OneMinusDst,
        BlendFactor::TargetAlpha => wgpu::BlendFactor::DstAlpha,
        BlendFactor::OneMinusTargetAlpha => wgpu::BlendFactor::OneMinusDstAlpha,
    }
}

fn compare(compare: Compare) -> wgpu::CompareFunction {
    match compare {
        Compare::Less => wgpu::CompareFunction::Less,
        Compare::LessEqual => wgpu::CompareFunction::LessEqual,
        Compare::Equal => wgpu::CompareFunction::Equal,
        Compare::GreaterEqual => wgpu::CompareFunction::GreaterEqual,
        Compare::Greater => wgpu::CompareFunction::Greater,
        Compare::Always => wgpu::CompareFunction::Always,
    }
}
