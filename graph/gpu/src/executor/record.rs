//! Commands: a loaded plan and its bind groups into the host's encoder.

use std::ops::Range;

use wgpu::{CommandEncoder, Device, TextureUses, TextureView};

use super::drawing::{record_draw, record_drawing};
use super::frame_constants::FrameConstantsAt;
use super::host_draw::HostDraw;
use super::host_set::{HostSet, Run};
use super::loaded::Loaded;
use super::residency::ImageBinding;
use crate::layout::Pipeline;
use crate::pipelines::Built;
use crate::store;

/// Histories and adaptation as they are before a first frame: zero.
pub(super) fn clear_memory(device: &Device, loaded: &Loaded, encoder: &mut CommandEncoder) {
    for &buffer in &loaded.persistent {
        encoder.clear_buffer(&loaded.residency.buffers[buffer], 0, None);
    }
    for binding in &loaded.residency.bindings {
        let ImageBinding::Ring(ring, 0) = binding else { continue };
        ring.iter().for_each(|stored| store::blacken(device, stored, encoder));
    }
}

/// Separates the first frame on a heap from the plan that used it before: after this, the first write of each image
/// waits for all earlier passes.
pub(super) fn take_over(loaded: &Loaded, encoder: &mut CommandEncoder) {
    let textures = loaded.residency.heap_textures().map(|texture| wgpu::TextureTransition {
        texture,
        selector: None,
        state: TextureUses::STORAGE_WRITE_ONLY,
    });
    encoder.transition_resources(std::iter::empty(), textures);
}

pub(super) fn record(
    loaded: &Loaded,
    set: &HostSet,
    now: FrameConstantsAt<'_>,
    passes: Range<usize>,
    (encoder, draws): (&mut CommandEncoder, &mut [HostDraw<'_>]),
) {
    let mut index = passes.start;
    while index < passes.end {
        match &set.runs[index].built.pipeline {
            Pipeline::Compute(_) => index = record_dispatches(loaded, set, now, index..passes.end, encoder),
            pipeline => {
                let run = &set.runs[index];
                transition_for_draw(set.transitions_before(&loaded.residency, index, now.0), encoder);
                stamp(loaded, index, encoder);
                match pipeline {
                    Pipeline::Render(pipeline) => record_draw(loaded, run, pipeline, now, index, encoder),
                    _ => record_drawing(loaded, run, now, index, (encoder, draws)),
                }
                index += 1;
                stamp(loaded, index, encoder);
            }
        }
    }
}

/// Writes the time before the pass of this number, if passes are timed.
fn stamp(loaded: &Loaded, number: usize, encoder: &mut CommandEncoder) {
    if let Some(timing) = &loaded.timing {
        encoder.write_timestamp(&timing.queries, number as u32);
    }
}

/// One compute pass for the dispatches that these passes begin with; the index after it.
fn record_dispatches(
    loaded: &Loaded,
    set: &HostSet,
    (ring_index, frame_constants): FrameConstantsAt<'_>,
    passes: Range<usize>,
    encoder: &mut CommandEncoder,
) -> usize {
    let mut pass =
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("afterimage"), timestamp_writes: None });
    let mut index = passes.start;
    if let Some(timing) = &loaded.timing {
        pass.write_timestamp(&timing.queries, index as u32);
    }
    while let Some(run) = set.runs[..passes.end].get(index)
        && let Run { built: Built { pipeline: Pipeline::Compute(pipeline), .. }, .. } = &**run
    {
        let [x, y, z] = loaded.passes[index].workgroups;
        let transitions = set.transitions_before(&loaded.residency, index, ring_index);
        if transitions.len() > 0 {
            let textures =
                transitions.map(|(texture, state)| wgpu::TextureTransition { texture, selector: None, state });
            pass.transition_resources(std::iter::empty(), textures);
        }
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, run.group(ring_index), loaded.frame_offset(index));
        if loaded.passes[index].immediate {
            pass.set_immediates(0, frame_constants.bytes(loaded.uses_uninitialized(index)));
        }
        let label = loaded.label(index);
        label.iter().for_each(|label| pass.push_debug_group(label));
        pass.dispatch_workgroups(x, y, z);
        label.iter().for_each(|_| pass.pop_debug_group());
        index += 1;
        if let Some(timing) = &loaded.timing {
            pass.write_timestamp(&timing.queries, index as u32);
        }
    }
    index
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
