//! The bind group of a pass.

use afterimage_graph::node::ImageId;
use afterimage_plan::codegen::{Composed, Slot, SlotKind};
use afterimage_plan::{Plan, Stage};
use wgpu::{BindGroup, BindGroupEntry, BindGroupLayout, BindingResource, Buffer, Device, TextureView};

use crate::frame_constants;
use crate::layout::{bound_slots, manual_filtering, sampler};
use crate::store::level_view;

/// The samplers that all passes share.
#[derive(Clone)]
pub(crate) struct Samplers {
    linear: wgpu::Sampler,
    nearest: wgpu::Sampler,
}

impl Samplers {
    pub(crate) fn new(device: &Device) -> Self {
        Self { linear: sampler(device, true), nearest: sampler(device, false) }
    }
}

/// The bindings of the slots of a pass.
pub(crate) struct PassBindings<'a> {
    pub(crate) plan: &'a Plan,
    /// The index of the pass.
    pub(crate) pass: usize,
    pub(crate) composed: &'a Composed,
    pub(crate) stage: Stage,
    pub(crate) samplers: &'a Samplers,
    /// The constants of the frame.
    pub(crate) frame: &'a Buffer,
    /// The uniforms of the plan.
    pub(crate) uniforms: &'a Buffer,
    /// The buffers of the plan.
    pub(crate) buffers: &'a [Buffer],
    /// The view of a whole image.
    pub(crate) view: &'a dyn Fn(ImageId) -> &'a TextureView,
}

/// Slots of a bind group that is made without an allocation of ours.
const FEW_SLOTS: usize = 16;

impl PassBindings<'_> {
    pub(crate) fn bind_group(&self, device: &Device, layout: &BindGroupLayout) -> BindGroup {
        let levels = self.level_views();
        let mut next_level = levels.iter();
        // A host with new views in every frame makes some bind groups in each: most fit into an array.
        let unused = BindGroupEntry { binding: 0, resource: BindingResource::Sampler(&self.samplers.nearest) };
        let mut few: [BindGroupEntry<'_>; FEW_SLOTS] = std::array::from_fn(|_| unused.clone());
        let mut many = Vec::new();
        let mut count = 0;
        for slot in bound_slots(self.composed, self.stage) {
            let resource = match slot.kind {
                SlotKind::Level(_) => BindingResource::TextureView(next_level.next().expect("each has its view")),
                kind => self.resource(kind),
            };
            let entry = BindGroupEntry { binding: slot.binding, resource };
            match few.get_mut(count) {
                Some(place) => *place = entry,
                None => many.push(entry),
            }
            count += 1;
        }
        if !many.is_empty() {
            many.splice(..0, few.iter().cloned());
        }
        let entries = if many.is_empty() { &few[..count] } else { &many };
        device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries })
    }

    fn resource(&self, kind: SlotKind) -> BindingResource<'_> {
        let uniform = &self.plan.passes[self.pass].uniform;
        match kind {
            SlotKind::Frame => part(self.frame, 0, u64::from(frame_constants::BYTES)),
            SlotKind::Block(block) => {
                let planned = self.plan.block(block);
                part(self.uniforms, planned.offset, planned.block.bytes() as u64)
            }
            SlotKind::Params | SlotKind::StoredParams => {
                part(self.uniforms, uniform.offset, uniform.bytes.len() as u64)
            }
            SlotKind::Extent => part(self.uniforms, uniform.extent_offset, size_of_val(&uniform.extent) as u64),
            SlotKind::Sampler if manual_filtering(self.composed) => BindingResource::Sampler(&self.samplers.nearest),
            SlotKind::Sampler => BindingResource::Sampler(&self.samplers.linear),
            SlotKind::Texture(image) | SlotKind::Storage(image) => BindingResource::TextureView((self.view)(image)),
            SlotKind::Level(_) => unreachable!("its view is made before"),
            SlotKind::Buffer(buffer, _) => self.buffers[buffer.0 as usize].as_entire_binding(),
        }
    }

    /// The views of single mip levels, in the order of their slots.
    fn level_views(&self) -> Vec<TextureView> {
        let level = |slot: &Slot| match slot.kind {
            SlotKind::Level(part) => {
                Some(level_view((self.view)(part.image), self.plan.image(part.image).desc, part.level, part.layer))
            }
            _ => None,
        };
        bound_slots(self.composed, self.stage).filter_map(level).collect()
    }
}

/// A part of a buffer.
pub(crate) fn part(buffer: &Buffer, offset: u64, bytes: u64) -> BindingResource<'_> {
    BindingResource::Buffer(wgpu::BufferBinding { buffer, offset, size: std::num::NonZeroU64::new(bytes) })
}
