//! Bind group layouts of composed shaders.

use afterimage_graph::node::{ImageId, Subresource};
use afterimage_plan::codegen::{Composed, Slot, SlotKind};
use afterimage_plan::{Plan, Stage};
use afterimage_wgsl::SampleMode;
use wgpu::{
    BindGroupLayoutEntry, BindingType, BufferBindingType, Device, SamplerBindingType, ShaderStages,
    StorageTextureAccess, TextureSampleType, TextureViewDimension,
};

use crate::texture_format::texture_format;

/// A compute or a render pipeline.
#[derive(Clone)]
pub(crate) enum Pipeline {
    Compute(wgpu::ComputePipeline),
    Render(wgpu::RenderPipeline),
    /// For the geometry of a drawing pass.
    Drawing(wgpu::RenderPipeline),
    /// None: the pass only clears, or the host draws with its own.
    None,
}

impl Pipeline {
    pub(crate) fn stage(&self) -> Stage {
        match self {
            Self::Compute(_) => Stage::Compute,
            Self::Render(_) => Stage::Fragment,
            Self::Drawing(_) | Self::None => Stage::Drawing,
        }
    }
}

/// A sampler that clamps, and filters within and between mip levels or takes the nearest texel.
pub(crate) fn sampler(device: &Device, is_linear: bool) -> wgpu::Sampler {
    let (filter, between) = match is_linear {
        true => (wgpu::FilterMode::Linear, wgpu::MipmapFilterMode::Linear),
        false => (wgpu::FilterMode::Nearest, wgpu::MipmapFilterMode::Nearest),
    };
    device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("afterimage"),
        mag_filter: filter,
        min_filter: filter,
        mipmap_filter: between,
        ..Default::default()
    })
}

/// The entries of the layout of the bind group of a pass.
pub(crate) fn layout_entries(plan: &Plan, composed: &Composed, stage: Stage) -> Vec<BindGroupLayoutEntry> {
    bound_slots(composed, stage).map(|slot| entry(plan, composed, *slot, stage)).collect()
}

/// The slots of a stage: a draw has an attachment where a dispatch has a storage image.
pub(crate) fn bound_slots(composed: &Composed, stage: Stage) -> impl Iterator<Item = &Slot> {
    composed.slots.iter().filter(move |slot| stage == Stage::Compute || !matches!(slot.kind, SlotKind::Storage(_)))
}

/// True if the shader filters texels itself, so that its sampler must not filter.
pub(crate) fn manual_filtering(composed: &Composed) -> bool {
    composed.sample_mode != SampleMode::Plain
}

fn entry(plan: &Plan, composed: &Composed, slot: Slot, stage: Stage) -> BindGroupLayoutEntry {
    let visibility = match stage {
        Stage::Compute => ShaderStages::COMPUTE,
        Stage::Fragment => ShaderStages::FRAGMENT,
        Stage::Drawing => ShaderStages::VERTEX_FRAGMENT,
    };
    let ty = match slot.kind {
        // The frame constants are those of most passes or those of passes whose memory begins.
        SlotKind::Frame => {
            BindingType::Buffer { ty: BufferBindingType::Uniform, has_dynamic_offset: true, min_binding_size: None }
        }
        SlotKind::StoredParams => buffer(BufferBindingType::Storage { read_only: true }),
        SlotKind::Block(_) | SlotKind::Params | SlotKind::Extent => buffer(BufferBindingType::Uniform),
        SlotKind::Sampler if manual_filtering(composed) => BindingType::Sampler(SamplerBindingType::NonFiltering),
        SlotKind::Sampler => BindingType::Sampler(SamplerBindingType::Filtering),
        SlotKind::Texture(image) | SlotKind::Level(Subresource { image, .. }) => BindingType::Texture {
            // A pass that filters texels itself accepts filterable and unfilterable textures.
            sample_type: TextureSampleType::Float {
                filterable: !manual_filtering(composed) && is_filterable(plan, image),
            },
            view_dimension: dimension(plan, image),
            multisampled: plan.image(image).desc.samples > 1,
        },
        SlotKind::Storage(image) => BindingType::StorageTexture {
            access: StorageTextureAccess::WriteOnly,
            format: texture_format(plan.image(image).desc.format),
            view_dimension: dimension(plan, image),
        },
        SlotKind::Buffer(_, writes) => buffer(BufferBindingType::Storage { read_only: !writes }),
    };
    layout_entry(slot.binding, visibility, ty)
}

fn layout_entry(binding: u32, visibility: ShaderStages, ty: BindingType) -> BindGroupLayoutEntry {
    BindGroupLayoutEntry { binding, visibility, ty, count: None }
}

fn buffer(ty: BufferBindingType) -> BindingType {
    BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

fn dimension(plan: &Plan, image: ImageId) -> TextureViewDimension {
    if plan.image(image).desc.volume { TextureViewDimension::D3 } else { TextureViewDimension::D2 }
}

fn is_filterable(plan: &Plan, image: ImageId) -> bool {
    let planned = plan.image(image);
    planned.sample_mode == SampleMode::Plain && planned.desc.samples == 1
}
