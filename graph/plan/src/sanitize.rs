//! Sanitizing: numbers of host images, and of images that a host draws, become finite at their first read.
//!
//! Pixels and texels are sanitized where they are read (see `shaders/lib/sampling.wgsl`). A kernel that filters or
//! reads textures directly gets a sanitized copy: a filtered read has four texels, each with the code that repairs it,
//! and the device cannot filter what is not sanitized. So does a kernel that reads numbers beside it which may be
//! negative where the host image may not: all textures of a pass are sampled alike.

use std::collections::BTreeSet;

use crate::builder::{PlanBuilder, copy_pass, copy_volume_pass, finite_image};
use afterimage_graph::node::{Arg, ImageId, KernelCall, Origin, Pass, Recording, Resource, VirtualImage};

/// Puts a sanitized copy in front of kernels that filter an image of the host or read it directly.
pub(crate) fn sanitize(builder: &mut PlanBuilder) {
    for (name, image) in builder.inputs.clone().into_iter().chain(drawn_by_host(&builder.recording)) {
        let recording = &mut builder.recording;
        let signedness = |image: ImageId| recording.image(image).signedness;
        let is_more_signed = |other: ImageId| other != image && signedness(other) > signedness(image);
        let more_signed: BTreeSet<ImageId> = recording
            .passes
            .iter()
            .flat_map(Pass::reads)
            .filter_map(Resource::image)
            .filter(|i| is_more_signed(*i))
            .collect();
        let reads = |kernel: &KernelCall| needs_copy(kernel, image, &more_signed);
        let first = recording.passes.iter().position(|pass| pass.kernels.iter().any(reads));
        // The contract lets kernels read samples through the library alone, and a copy would need samples of its own.
        let is_given_clean = recording.image(image).finite || recording.image(image).desc.samples > 1;
        let Some(first) = first.filter(|_| !is_given_clean) else { continue };
        let copy = recording.add_image(finite_image(format!("{name}.sanitized"), recording.image(image)));
        let kernels = recording.passes.iter_mut().flat_map(|pass| &mut pass.kernels);
        kernels
            .filter(|kernel| needs_copy(kernel, image, &more_signed))
            .for_each(|kernel| redirect(kernel, image, copy));
        let volume = Some(recording.image(image).desc).filter(|desc| desc.volume);
        let mut pass = match volume {
            Some(desc) => copy_volume_pass(&name, image, copy, desc.size),
            None => copy_pass(&name, Arg::Pixel(image), copy),
        };
        pass.label = "sanitize".into();
        recording.passes.insert(first, pass);
    }
}

/// The images whose numbers are unknown because a host draws them, and those of earlier frames.
fn drawn_by_host(recording: &Recording) -> Vec<(String, ImageId)> {
    let is_drawn = |image: &VirtualImage| !image.finite && !matches!(image.origin, Origin::Input(_));
    let drawn = recording.images.iter().zip(0..).filter(|(image, _)| is_drawn(image));
    drawn.map(|(image, id)| (image.label.clone(), ImageId(id))).collect()
}

fn needs_copy(kernel: &KernelCall, image: ImageId, more_signed: &BTreeSet<ImageId>) -> bool {
    let (shader, function) = (&kernel.shader, &kernel.function);
    // Nobody knows how often an untrusted kernel reads: each read would have the code that repairs a texel.
    let cannot_sanitize =
        shader.is_untrusted() || shader.reads_textures_itself(function) || shader.filters_textures(function);
    let is_mixed = kernel.textures().any(|other| more_signed.contains(&other));
    kernel.accepts(Arg::Texture(image)) && (cannot_sanitize || is_mixed)
}

fn redirect(kernel: &mut KernelCall, old: ImageId, new: ImageId) {
    let args = kernel.args.iter_mut().filter(|arg| arg.value == Arg::Texture(old));
    args.for_each(|arg| arg.value = Arg::Texture(new));
}
