//! The layout of uniforms: the struct in the shader of a pass, its bytes, and the places of all passes in one buffer.
//!
//! A block has the uniforms of the kernels, in order, each at a multiple of 16 bytes.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use afterimage_graph::check::Graph;
use afterimage_graph::node::{Arg, BlockId, KernelOrigin, Pass};

use crate::plan::{Plan, PlannedBlock, PlannedImage, PlannedPass, ScheduledPass, UniformBlock};

/// Offsets in the uniform buffer are multiples of this: every device accepts it.
pub const UNIFORM_ALIGNMENT: u64 = 256;

/// Alignment of the uniforms of kernels in a block.
const KERNEL_ALIGNMENT: usize = 16;

/// The struct `PassUniform` of a pass; `type_of` gives the type of a kernel's uniform. Empty if there are no numbers.
pub(super) fn uniform_struct(pass: &Pass, type_of: &dyn Fn(usize) -> String) -> String {
    let mut members = String::new();
    let kernels = pass.kernels.iter().enumerate().filter(|(_, kernel)| !kernel.uniform.is_empty());
    for (index, _) in kernels {
        let _ = writeln!(members, "    @align({KERNEL_ALIGNMENT}) kernel{index}: {},", type_of(index));
    }
    if members.is_empty() { members } else { format!("struct PassUniform {{\n{members}}}\n") }
}

/// The bytes of that struct.
fn uniform_bytes(pass: &Pass) -> Vec<u8> {
    let mut bytes = Vec::new();
    for kernel in &pass.kernels {
        bytes.extend_from_slice(&kernel.uniform);
        bytes.resize(bytes.len().next_multiple_of(KERNEL_ALIGNMENT), 0);
    }
    bytes
}

/// The uniform block of each pass, one behind the other.
pub(super) fn uniform_blocks(passes: &[ScheduledPass], images: &[PlannedImage]) -> Vec<UniformBlock> {
    let mut offset = 0;
    let mut blocks = Vec::with_capacity(passes.len());
    for scheduled in passes {
        let bytes = uniform_bytes(&scheduled.pass);
        let size = scheduled.pass.written_image().map(|image| images[image.0 as usize].desc.size);
        let extent = size.map_or([1.0, 1.0, 0.0, 0.0], |size| [size.width as f32, size.height as f32, 0.0, 0.0]);
        let extent_offset = offset + (bytes.len() as u64).next_multiple_of(UNIFORM_ALIGNMENT);
        blocks.push(UniformBlock { offset, bytes, extent_offset, extent });
        offset = extent_offset + UNIFORM_ALIGNMENT;
    }
    blocks
}

fn uniform_ends(passes: &[PlannedPass]) -> impl Iterator<Item = u64> {
    passes.iter().map(|planned| planned.uniform.extent_offset + UNIFORM_ALIGNMENT)
}

/// The host blocks that passes read, behind the uniforms of the passes.
pub(crate) fn blocks(graph: &Graph, passes: &[PlannedPass]) -> Vec<PlannedBlock> {
    let args = passes.iter().flat_map(|planned| planned.pass.args());
    let read: BTreeSet<BlockId> = args.filter_map(Arg::block).collect();
    let mut end = uniform_ends(passes).max().unwrap_or(0);
    let mut blocks = Vec::with_capacity(read.len());
    for id in read {
        let input = &graph.inputs[id.0 as usize];
        let block = input.block.expect("only inputs for blocks give blocks");
        blocks.push(PlannedBlock { id, name: input.name.clone(), block, offset: end });
        end += (block.bytes() as u64).next_multiple_of(UNIFORM_ALIGNMENT);
    }
    blocks
}

impl Plan {
    /// The contents of the one uniform buffer.
    pub fn uniform_buffer(&self) -> Vec<u8> {
        let blocks = self.blocks.iter().map(|planned| planned.offset + planned.block.bytes() as u64);
        let ends = uniform_ends(&self.passes).chain(blocks);
        let mut buffer = vec![0; ends.max().unwrap_or(UNIFORM_ALIGNMENT) as usize];
        let mut put = |offset: u64, bytes: &[u8]| buffer[offset as usize..][..bytes.len()].copy_from_slice(bytes);
        for block in self.passes.iter().map(|planned| &planned.uniform) {
            put(block.offset, &block.bytes);
            put(block.extent_offset, block.extent.map(f32::to_le_bytes).as_flattened());
        }
        buffer
    }

    /// Offsets of the uniform of a kernel in the buffer: none if the kernel is culled, and several if it
    /// runs in several passes.
    pub(crate) fn uniform_places(&self, kernel: KernelOrigin) -> Vec<u64> {
        let origin = Some(kernel);
        let mut places = Vec::new();
        for planned in &self.passes {
            let mut offset = planned.uniform.offset;
            for kernel in &planned.pass.kernels {
                if kernel.origin == origin {
                    places.push(offset);
                }
                offset += kernel.uniform.len().next_multiple_of(KERNEL_ALIGNMENT) as u64;
            }
        }
        places
    }

    /// Returns whether two plans are equal but for the numbers in their uniforms, so that one can run with the
    /// resources of the other.
    pub fn differs_in_uniforms_only(&self, other: &Self) -> bool {
        // Most plans differ in more, and the copies are large.
        let is_alike = self.size == other.size && self.passes.len() == other.passes.len();
        is_alike && self.without_uniforms() == other.without_uniforms()
    }

    /// The plan with zeros for all numbers.
    fn without_uniforms(&self) -> Self {
        let mut plan = self.clone();
        for planned in &mut plan.passes {
            planned.uniform.bytes.fill(0);
            for kernel in &mut planned.pass.kernels {
                kernel.uniform.fill(0);
            }
        }
        plan
    }
}
