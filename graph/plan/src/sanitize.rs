//! Sanitizing: numbers of host images become finite at their first read.
//!
//! Pixels and texels are sanitized where they are read (see `shaders/lib/sampling.wgsl`). A kernel that filters or
//! reads textures directly gets a sanitized copy: a filtered read has four texels, each with the code that repairs it,
//! and the device cannot filter what is not sanitized.

use crate::builder::{PlanBuilder, copy_pass, finite_image};
use afterimage_graph::node::{Arg, ImageId, KernelCall};

/// Puts a sanitized copy in front of kernels that filter a host image or read it directly.
pub(crate) fn sanitize(builder: &mut PlanBuilder) {
    for (name, image) in builder.inputs.clone() {
        let recording = &mut builder.recording;
        let reads = |kernel: &KernelCall| needs_copy(kernel, image);
        let first = recording.passes.iter().position(|pass| pass.kernels.iter().any(reads));
        let Some(first) = first.filter(|_| !recording.image(image).finite) else { continue };
        let copy = recording.add_image(finite_image(format!("{name}.sanitized"), recording.image(image)));
        let kernels = recording.passes.iter_mut().flat_map(|pass| &mut pass.kernels);
        kernels.filter(|kernel| needs_copy(kernel, image)).for_each(|kernel| redirect(kernel, image, copy));
        let mut pass = copy_pass(&name, Arg::Pixel(image), copy);
        pass.label = "sanitize".into();
        recording.passes.insert(first, pass);
    }
}

fn needs_copy(kernel: &KernelCall, image: ImageId) -> bool {
    let (shader, function) = (&kernel.shader, &kernel.function);
    // Nobody knows how often an untrusted kernel reads: each read would have the code that repairs a texel.
    let cannot_sanitize =
        shader.is_untrusted() || shader.reads_textures_itself(function) || shader.filters_textures(function);
    kernel.accepts(Arg::Texture(image)) && cannot_sanitize
}

fn redirect(kernel: &mut KernelCall, old: ImageId, new: ImageId) {
    let args = kernel.args.iter_mut().filter(|arg| arg.value == Arg::Texture(old));
    args.for_each(|arg| arg.value = Arg::Texture(new));
}
