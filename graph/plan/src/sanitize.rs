//! Sanitizing: numbers of host images, of images that a host draws, and of sums that draws make, become finite where
//! they are read.
//!
//! Pixels and texels are sanitized where they are read (see `shaders/lib/sampling.wgsl`). A kernel that filters or
//! reads textures directly gets a sanitized copy: a filtered read has four texels, each with the code that repairs it,
//! and the device cannot filter what is not sanitized. So does a kernel that reads numbers besides it which may be
//! negative where the host image may not: all textures of a pass are sampled alike. And so does an untrusted one that
//! may read more texels than those around its pixel.

use std::collections::BTreeSet;

use afterimage_base::caps::Caps;

use crate::builder::{PlanBuilder, copy_level_pass, copy_pass, copy_volume_pass, finite_image};
use afterimage_graph::node::{Arg, ImageId, KernelCall, Origin, Pass, Recording, Resource, VirtualImage};

/// Puts a sanitized copy in front of kernels that filter an image of the host or read it directly.
pub(crate) fn sanitize(builder: &mut PlanBuilder, caps: &Caps) {
    for (name, image) in builder.inputs.clone().into_iter().chain(drawn(&builder.recording)) {
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
        // The contract lets kernels read samples through the library alone, and a copy would need samples of its own.
        if recording.image(image).finite || recording.image(image).desc.samples > 1 {
            continue;
        }
        let is_plain = recording.image(image).desc.is_plain();
        // No copy has several levels or layers.
        let can_be_copied = |read: Arg| match read {
            Arg::Texture(read) => read == image && is_plain,
            Arg::Level(part) => part.image == image,
            _ => false,
        };
        // Copies of what the image, or a level of it, holds now: a later draw changes it.
        let mut copies: Vec<(Arg, ImageId)> = Vec::new();
        for mut pass in std::mem::take(&mut recording.passes) {
            let kernels = pass.kernels.iter_mut().filter(|kernel| cannot_sanitize(kernel, &more_signed, caps));
            for arg in kernels.flat_map(|kernel| &mut kernel.args).filter(|arg| can_be_copied(arg.value)) {
                let known = copies.iter().find(|(read, _)| *read == arg.value);
                let copy = known.map(|(_, copy)| *copy).unwrap_or_else(|| {
                    let copy = add_copy(recording, &name, arg.value, image);
                    copies.push((arg.value, copy));
                    copy
                });
                arg.value = Arg::Texture(copy);
            }
            if pass.writes().contains(&Resource::Image(image)) {
                copies.clear();
            }
            recording.passes.push(pass);
        }
    }
}

/// Adds a pass that makes a sanitized copy of what is read.
fn add_copy(recording: &mut Recording, name: &str, read: Arg, image: ImageId) -> ImageId {
    let mut copy = finite_image(format!("{name}.sanitized"), recording.image(image));
    let volume = Some(copy.desc).filter(|desc| desc.volume);
    if let Arg::Level(part) = read {
        copy.desc = copy.desc.level(part.level);
    }
    let copy = recording.add_image(copy);
    let mut pass = match (read, volume) {
        (_, Some(desc)) => copy_volume_pass(name, image, copy, desc.size),
        (Arg::Level(_), None) => copy_level_pass(name, read, copy),
        (_, None) => copy_pass(name, Arg::Pixel(image), copy),
    };
    pass.label = "sanitize".into();
    recording.passes.push(pass);
    copy
}

/// The images whose numbers may not be finite because of what is drawn into them, and those of earlier frames.
fn drawn(recording: &Recording) -> Vec<(String, ImageId)> {
    let is_drawn = |image: &VirtualImage| !image.finite && !matches!(image.origin, Origin::Input(_));
    let drawn = recording.images.iter().zip(0..).filter(|(image, _)| is_drawn(image));
    drawn.map(|(image, id)| (image.label.clone(), ImageId(id))).collect()
}

/// Texels around a pixel, and the pixel: an untrusted kernel that reads no more repairs them itself, but not on a
/// processor. There a mean of nine takes 0.33 s at 1280x720 so, and 0.1 with a copy.
const AROUND: usize = 9;

/// Returns whether a kernel that reads an image needs a copy of it.
fn cannot_sanitize(kernel: &KernelCall, more_signed: &BTreeSet<ImageId>, caps: &Caps) -> bool {
    let (shader, function) = (&kernel.shader, &kernel.function);
    let is_mixed = kernel.textures().any(|other| more_signed.contains(&other));
    // Each read has the code that repairs a texel.
    let few = if caps.fast_workgroup_memory { AROUND } else { 0 };
    let reads_many = shader.is_untrusted() && shader.texel_reads(function) > few;
    is_mixed || reads_many || shader.reads_textures_itself(function) || shader.filters_textures(function)
}
