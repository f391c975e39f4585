//! The numbers of a plan: one buffer with the uniform of each pass and the size of its result.

use afterimage_graph::node::{Pass, Work};
use afterimage_plan::Plan;

use super::prepare::written;

/// Uniform offsets are multiples of this.
pub(super) const ALIGNMENT: u64 = 256;

/// Bytes of a result's size.
pub(super) const EXTENT_BYTES: u64 = 8;

/// Where each pass's uniform begins in the one buffer, and its bytes. Behind it lies the size of its result.
pub(super) fn regions(plan: &Plan) -> Vec<(u64, u64)> {
    let mut offset = 0;
    let mut region = |pass: &Pass| {
        let (start, bytes) = (offset, pass_uniform(&pass.work).len() as u64);
        offset += bytes.next_multiple_of(ALIGNMENT) + ALIGNMENT;
        (start, bytes)
    };
    plan.recording.passes.iter().map(&mut region).collect()
}

/// Whether the new plan can run with the resources of the old one and other uniforms.
pub(super) fn differs_in_uniforms_only(old: &Plan, new: &Plan) -> bool {
    old.batches == new.batches && old.memory == new.memory && blank(old) == blank(new)
}

/// The plan with zeros for all its numbers.
fn blank(plan: &Plan) -> Plan {
    let mut plan = plan.clone();
    for pass in &mut plan.recording.passes {
        match &mut pass.work {
            Work::Steps { steps, .. } => steps.iter_mut().for_each(|step| step.uniform.fill(0)),
            Work::Tiled(tiling) => {
                tiling.stages.iter_mut().flat_map(|s| &mut s.steps).for_each(|step| step.uniform.fill(0));
            }
            Work::Rows(rows) => rows.source.iter_mut().for_each(|step| step.uniform.fill(0)),
            Work::Cells(cells) => cells.readers.iter_mut().for_each(|reader| reader.call.uniform.fill(0)),
            Work::Entry(call) => call.uniform.fill(0),
        }
    }
    plan
}

/// The uniform of a pass: its steps' structs, each at a multiple of 16.
pub(super) fn pass_uniform(work: &Work) -> Vec<u8> {
    let mut bytes = Vec::new();
    let parts: Vec<&[u8]> = match work {
        Work::Steps { steps, .. } => steps.iter().map(|step| step.uniform.as_slice()).collect(),
        Work::Tiled(tiling) => {
            for stage in &tiling.stages {
                let size = [stage.size.width, stage.size.height, 0, 0];
                bytes.extend(size.iter().flat_map(|x| x.to_le_bytes()));
            }
            tiling.stages.iter().flat_map(|stage| &stage.steps).map(|step| step.uniform.as_slice()).collect()
        }
        Work::Rows(rows) => rows.source.iter().map(|step| step.uniform.as_slice()).collect(),
        Work::Cells(cells) => cells.readers.iter().map(|reader| reader.call.uniform.as_slice()).collect(),
        Work::Entry(call) => vec![&call.uniform],
    };
    for part in parts.into_iter().filter(|part| !part.is_empty()) {
        bytes.resize(bytes.len().next_multiple_of(16), 0);
        bytes.extend_from_slice(part);
    }
    bytes.resize(bytes.len().next_multiple_of(16), 0);
    bytes
}

/// The contents of the one uniform buffer: for each pass its uniform, then the size of the image that it writes.
pub(super) fn uniform_bytes(plan: &Plan) -> Vec<u8> {
    let mut all = Vec::new();
    for pass in &plan.recording.passes {
        all.extend(pass_uniform(&pass.work));
        all.resize(all.len().next_multiple_of(ALIGNMENT as usize), 0);
        let [width, height] = written(pass).map_or([1.0; 2], |image| {
            let size = plan.recording.image(image).desc.size;
            [size.width as f32, size.height as f32]
        });
        all.extend([width, height].iter().flat_map(|side| side.to_le_bytes()));
        all.resize(all.len().next_multiple_of(ALIGNMENT as usize), 0);
    }
    all.resize(all.len().max(ALIGNMENT as usize), 0);
    all
}
