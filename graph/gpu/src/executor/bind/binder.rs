//! Bind groups of single passes, on any thread.

use std::sync::Arc;

use afterimage_graph::node::Subresource;
use afterimage_plan::Stage;
use wgpu::{BindGroup, Buffer, BufferUsages, CommandEncoder, Device, TextureView};

use crate::bind_group::{PassBindings, Samplers};
use crate::buffer::buffer;
use crate::error::GpuError;
use crate::executor::loaded::LoadedPlan;
use crate::executor::loaded::bind_groups::BoundPass;
use crate::executor::loaded::uniforms::Staging;
use crate::frame_constants::{self, FrameConstants};
use crate::pipelines::Built;
use crate::store::level_view;

/// Makes bind groups, with the samplers and the buffer of frame constants that all plans of an executor share.
#[derive(Clone)]
pub(crate) struct Binder {
    pub(crate) device: Device,
    samplers: Samplers,
    /// The constants of the last frame, for shaders that do not take them from immediates: first those of most passes,
    /// then those of passes whose memory begins in that frame.
    frame: Buffer,
    pub(crate) frame_offsets: [u32; 2],
}

impl Binder {
    pub(crate) fn new(device: &Device) -> Self {
        let stride = device.limits().min_uniform_buffer_offset_alignment.max(frame_constants::BYTES);
        let bytes = u64::from(stride + frame_constants::BYTES);
        let frame = buffer(device, "frame", bytes, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
        Self { device: device.clone(), samplers: Samplers::new(device), frame, frame_offsets: [0, stride] }
    }

    /// Writes the constants for passes that take them from a buffer; the second ones only where a pass needs them.
    pub(crate) fn write_frame(
        &self,
        constants: &FrameConstants,
        has_uninitialized: bool,
        staging: &mut Staging,
        encoder: &mut CommandEncoder,
    ) -> Result<(), GpuError> {
        for (is_uninitialized, offset) in [false, true].into_iter().zip(self.frame_offsets) {
            if has_uninitialized || !is_uninitialized {
                let bytes = constants.bytes(is_uninitialized);
                let what = "the time of the frame";
                staging.write(&self.device, what, encoder, &self.frame, u64::from(offset), bytes)?;
            }
        }
        Ok(())
    }

    /// The bind groups and attachments of a pass. `views` are the host's: of all inputs, then of all outputs.
    pub(crate) fn bind_pass(
        &self,
        loaded: &LoadedPlan,
        index: usize,
        built: Built,
        views: &[TextureView],
    ) -> BoundPass {
        let mut pass = BoundPass { built, groups: Arc::new([]), attachments: Vec::new() };
        self.bind(loaded, index, views, &mut pass);
        self.attach(loaded, index, views, &mut pass);
        pass
    }

    /// Sets the bind groups of a pass, in the memory of those that it had and that nothing else uses.
    pub(crate) fn bind(&self, loaded: &LoadedPlan, index: usize, views: &[TextureView], pass: &mut BoundPass) {
        let ring_indices = ring_indices(loaded, index);
        match Arc::get_mut(&mut pass.groups).filter(|groups| groups.len() == ring_indices.len()) {
            Some(groups) => {
                for (ring_index, group) in ring_indices.zip(groups) {
                    *group = self.bind_group(loaded, index, &pass.built, views, ring_index);
                }
            }
            None => {
                let groups =
                    ring_indices.map(|ring_index| self.bind_group(loaded, index, &pass.built, views, ring_index));
                pass.groups = groups.collect();
            }
        }
    }

    /// Sets the attachments of a draw; several if the pass binds a history image, one for each ring index.
    pub(crate) fn attach(&self, loaded: &LoadedPlan, index: usize, views: &[TextureView], pass: &mut BoundPass) {
        let planned = &loaded.plan.passes[index].pass;
        let view = |image, ring_index| loaded.residency.view(image, views, ring_index);
        let ring_indices = ring_indices(loaded, index);
        pass.attachments.resize_with(ring_indices.len(), Vec::new);
        for (ring_index, attachments) in ring_indices.zip(&mut pass.attachments) {
            attachments.clear();
            match (pass.built.pipeline.stage(), loaded.passes[index].writes_image, planned.drawing()) {
                (Stage::Fragment, Some(image), _) => attachments.push(view(image, ring_index).clone()),
                (Stage::Drawing, _, Some(drawing)) => {
                    for Subresource { image, level, layer } in drawing.targets() {
                        let desc = loaded.plan.image(image).desc;
                        attachments.push(level_view(view(image, ring_index), desc, level, layer));
                    }
                }
                _ => {}
            }
        }
    }

    fn bind_group(
        &self,
        loaded: &LoadedPlan,
        index: usize,
        built: &Built,
        views: &[TextureView],
        ring_index: u32,
    ) -> BindGroup {
        let bindings = PassBindings {
            plan: &loaded.plan,
            pass: index,
            composed: &loaded.passes[index].composed,
            stage: built.pipeline.stage(),
            samplers: &self.samplers,
            frame: &self.frame,
            uniforms: &loaded.uniforms.buffer,
            buffers: &loaded.residency.buffers,
            view: &|image| loaded.residency.view(image, views, ring_index),
        };
        bindings.bind_group(&self.device, &built.layout)
    }
}

/// All ring indices if the pass binds a history image, or else one.
fn ring_indices(loaded: &LoadedPlan, index: usize) -> std::ops::Range<u32> {
    0..if loaded.in_rings[index] { loaded.residency.ring_length } else { 1 }
}
