//! Limits that every WebGPU device has: dispatches, workgroups, bindings and buffers.

use super::violations::Violations;
use crate::node::{Arg, KernelCall, PassKind, Recording};
use afterimage_base::caps::Caps;
use afterimage_base::image::Size;

/// Workgroups of a dispatch in each direction.
const MAX_GROUPS: u32 = 65_535;
/// Invocations of a workgroup in each direction.
const MAX_INVOCATIONS: [u32; 3] = [256, 256, 64];
/// Bindings of a pass, and bytes of a uniform.
const MAX_TEXTURES: usize = 16;
const MAX_BUFFERS: usize = 8;
const MAX_UNIFORM_BYTES: usize = 64 << 10;

pub(super) fn look(recording: &Recording, size: Size, violations: &mut Violations) {
    let caps = Caps::default();
    for buffer in recording.buffers.iter().filter(|buffer| buffer.bytes > caps.max_buffer) {
        violations.add(format!(
            "the buffer `{}` has {} bytes at {size}; the limit of a device may be {}",
            buffer.label, buffer.bytes, caps.max_buffer
        ));
    }
    for pass in &recording.passes {
        let place = format!("the pass `{}` at {size}", pass.label);
        for kernel in &pass.kernels {
            dispatch(kernel, &place, violations);
            match pass.kind {
                PassKind::Workgroup([width, height]) => invocations([width, height, 1], &caps, &place, violations),
                _ => workgroup(kernel, &caps, &place, violations),
            }
            bindings(kernel, &caps, &place, violations);
        }
        exceeds(pass.uniform_buffers(), caps.max_uniform_buffers as usize, "uniform buffers", &place, violations);
    }
}

fn exceeds(count: usize, max: usize, what: &str, place: &str, violations: &mut Violations) {
    violations.require(count <= max, || format!("{place} has {count} {what}; the limit of a device may be {max}"));
}

fn dispatch(kernel: &KernelCall, place: &str, violations: &mut Violations) {
    let max = kernel.workgroups.into_iter().flatten().max().unwrap_or(0);
    exceeds(max as usize, MAX_GROUPS as usize, "workgroups in one direction", place, violations);
}

fn workgroup(kernel: &KernelCall, caps: &Caps, place: &str, violations: &mut Violations) {
    if kernel.workgroups.is_none() {
        return;
    }
    let entry = kernel.shader.reflect().ok().and_then(|reflection| reflection.entry(&kernel.function));
    let Some(entry) = entry else {
        return violations.add(format!("{place} has no entry point `{}`", kernel.function));
    };
    invocations(entry.workgroup, caps, place, violations);
}

fn invocations(sides: [u32; 3], caps: &Caps, place: &str, violations: &mut Violations) {
    let all = sides.iter().map(|side| *side as usize).product();
    exceeds(all, caps.workgroup_invocations as usize, "invocations in a workgroup", place, violations);
    for (side, max) in sides.into_iter().zip(MAX_INVOCATIONS) {
        exceeds(side as usize, max as usize, "invocations in one direction of a workgroup", place, violations);
    }
}

fn bindings(kernel: &KernelCall, caps: &Caps, place: &str, violations: &mut Violations) {
    let count = |fits: fn(&Arg) -> bool| kernel.args.iter().filter(|arg| fits(&arg.value)).count();
    let textures = count(|arg| matches!(arg, Arg::Texture(_) | Arg::Level(_) | Arg::Pixel(_)));
    exceeds(textures, MAX_TEXTURES, "textures", place, violations);
    let buffers = count(|arg| matches!(arg, Arg::Buffer(..) | Arg::Value(..)));
    exceeds(buffers, MAX_BUFFERS, "buffers", place, violations);
    let images = count(|arg| matches!(arg, Arg::Storage(_)));
    exceeds(images, caps.max_storage_images as usize, "storage images", place, violations);
    exceeds(kernel.uniform.len(), MAX_UNIFORM_BYTES, "bytes in its uniform", place, violations);
}
