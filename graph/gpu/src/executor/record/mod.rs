//! Commands: a loaded plan and its bind groups into the host's encoder.

mod draws;
mod uniforms;

use std::ops::Range;

use wgpu::{CommandEncoder, Device, TextureUses, TextureView};

use crate::executor::host_draw::HostDraw;
use crate::executor::loaded::LoadedPlan;
use crate::executor::loaded::bind_groups::BindGroups;
use crate::executor::loaded::residency::ImageBinding;
use crate::frame_constants::FrameConstants;
use crate::layout::Pipeline;
use crate::store;
use crate::timing::Timestamps;

/// Histories and adaptation as they are before a first frame: zero.
pub(crate) fn clear_memory(device: &Device, loaded: &LoadedPlan, encoder: &mut CommandEncoder) {
    for buffer in &loaded.persistent {
        encoder.clear_buffer(&loaded.residency.buffers[buffer.index], 0, None);
    }
    for binding in &loaded.residency.bindings {
        let ImageBinding::Ring(ring, 0) = binding else { continue };
        ring.iter().for_each(|stored| store::clear(device, stored, encoder));
    }
}

/// Separates the first frame on a heap from the plan that used it before: after this, the first write of each image
/// waits for all earlier passes.
pub(crate) fn separate_from_old_plan(loaded: &LoadedPlan, encoder: &mut CommandEncoder) {
    let textures = loaded.residency.heap_textures().map(|texture| wgpu::TextureTransition {
        texture,
        selector: None,
        state: TextureUses::STORAGE_WRITE_ONLY,
    });
    encoder.transition_resources(std::iter::empty(), textures);
}

/// One frame of a loaded plan.
pub(crate) struct FrameCommands<'a> {
    pub(crate) loaded: &'a LoadedPlan,
    pub(crate) groups: &'a BindGroups,
    /// The position of this frame's images in the rings of histories.
    pub(crate) ring_index: usize,
    pub(crate) constants: &'a FrameConstants,
}

impl<'a> FrameCommands<'a> {
    /// The commands of a frame of that number with these bind groups of the plan.
    pub(crate) fn new(loaded: &'a LoadedPlan, groups: usize, index: u32, constants: &'a FrameConstants) -> Self {
        let ring_index = (index % loaded.residency.ring_length) as usize;
        Self { loaded, groups: &loaded.bind_groups[groups], ring_index, constants }
    }

    /// Clears the buffers that begin with zeros and that passes of the frame write.
    pub(crate) fn clear_zeroed(&self, encoder: &mut CommandEncoder) {
        let loaded = self.loaded;
        for buffer in loaded.zeroed.iter().filter(|buffer| loaded.due.writes(buffer)) {
            encoder.clear_buffer(&loaded.residency.buffers[buffer.index], 0, None);
        }
    }

    /// Records passes, of which those that the host fills have their draws.
    pub(crate) fn record(&self, passes: Range<usize>, encoder: &mut CommandEncoder, draws: &mut [HostDraw<'_>]) {
        let mut index = passes.start;
        while index < passes.end {
            if let Pipeline::Compute(_) = self.groups.passes[index].built.pipeline {
                index = self.record_dispatches(index..passes.end, encoder);
                continue;
            }
            transition_for_draw(self.transitions_before(index), encoder);
            self.write_timestamp(index, encoder);
            match &self.groups.passes[index].built.pipeline {
                _ if !self.loaded.due.runs(index) => {}
                Pipeline::Render(pipeline) => self.record_full_screen(pipeline, index, encoder),
                _ => self.record_drawing(index, encoder, draws),
            }
            index += 1;
            self.write_timestamp(index, encoder);
        }
    }

    /// Records one compute pass for the dispatches that these passes begin with, and returns the index after them.
    fn record_dispatches(&self, passes: Range<usize>, encoder: &mut CommandEncoder) -> usize {
        let loaded = self.loaded;
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("afterimage"), timestamp_writes: None });
        let mut index = passes.start;
        if let Some(timing) = self.timing() {
            pass.write_timestamp(&timing.queries, index as u32);
        }
        while let Some(bound) = self.groups.passes[..passes.end].get(index)
            && let Pipeline::Compute(pipeline) = &bound.built.pipeline
        {
            let [x, y, z] = loaded.passes[index].workgroups;
            let transitions = self.transitions_before(index);
            if transitions.len() > 0 {
                let textures =
                    transitions.map(|(texture, state)| wgpu::TextureTransition { texture, selector: None, state });
                pass.transition_resources(std::iter::empty(), textures);
            }
            if loaded.due.runs(index) {
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, bound.group(self.ring_index), loaded.frame_offset(index));
                if loaded.passes[index].immediate {
                    pass.set_immediates(0, self.constants.bytes(loaded.uses_uninitialized(index)));
                }
                if let Some(label) = loaded.label(index) {
                    pass.push_debug_group(label);
                }
                pass.dispatch_workgroups(x, y, z);
                if loaded.label(index).is_some() {
                    pass.pop_debug_group();
                }
            }
            index += 1;
            if let Some(timing) = self.timing() {
                pass.write_timestamp(&timing.queries, index as u32);
            }
        }
        index
    }

    fn timing(&self) -> Option<&Timestamps> {
        self.loaded.timing.as_ref()
    }

    /// The explicit transitions before a pass: views of images, and their new states.
    fn transitions_before(&self, pass: usize) -> impl ExactSizeIterator<Item = (&TextureView, TextureUses)> {
        let BindGroups { explicit_transitions, bound_views, .. } = self.groups;
        explicit_transitions.before(pass, &self.loaded.residency, bound_views, self.ring_index)
    }

    /// Writes the time before the pass of this index, if passes are timed.
    fn write_timestamp(&self, index: usize, encoder: &mut CommandEncoder) {
        if let Some(timing) = self.timing() {
            encoder.write_timestamp(&timing.queries, index as u32);
        }
    }
}

/// Before a draw there is no compute pass in which to record transitions. From the state `RESOURCE` a barrier waits for
/// all shaders before.
fn transition_for_draw<'a>(
    transitions: impl ExactSizeIterator<Item = (&'a TextureView, TextureUses)>,
    encoder: &mut CommandEncoder,
) {
    if transitions.len() == 0 {
        return;
    }
    let new = transitions.filter(|(_, state)| *state != TextureUses::RESOURCE);
    let textures = new.map(|(view, _)| wgpu::TextureTransition {
        texture: view.texture(),
        selector: None,
        state: TextureUses::RESOURCE,
    });
    encoder.transition_resources(std::iter::empty(), textures);
}
