//! Step 3b: numbers of host images become finite at their first read.
//!
//! Pixels and taps are sanitized where they are read (see `shaders/lib/sampling.wgsl`). A shader that reads textures by itself gets a sanitized copy.

use crate::passes::{copy_pass, copy_step};
use crate::{Caps, PlanBuilder};
use afterimage_base::image::Format;
use afterimage_graph::node::{Arg, ImageId, Origin, Pass, Recording, Resource, VirtualImage, Work};
use afterimage_wgsl::SampleMode;

pub(crate) fn sanitize(draft: &mut PlanBuilder) {
    for input in 0..draft.inputs.len() {
        let (name, image) = draft.inputs[input].clone();
        if draft.recording.image(image).finite {
            continue;
        }
        let Some(first) = draft.recording.passes.iter().position(|pass| reads_by_itself(pass, image)) else { continue };
        let source = draft.recording.image(image);
        let desc =
            source.desc.format(if source.desc.format.is_32_bit() { source.desc.format } else { Format::Rgba16Float });
        let copy = VirtualImage {
            label: format!("{name}.sanitized"),
            desc,
            origin: Origin::Transient,
            finite: true,
            signed: source.signed,
        };
        let copy = draft.recording.add_image(copy);
        for pass in draft.recording.passes.iter_mut().filter(|pass| reads_by_itself(pass, image)) {
            redirect(pass, image, copy);
        }
        let mut pass = copy_pass(&name, copy_step(&name, image), copy);
        pass.label = "sanitize".into();
        draft.recording.passes.insert(first, pass);
    }
}

fn reads_by_itself(pass: &Pass, image: ImageId) -> bool {
    match &pass.work {
        Work::Steps { steps, .. } => {
            steps.iter().any(|s| s.args.contains(&Arg::Texture(image)) && s.shader.reads_textures_itself())
        }
        // These come after this step.
        Work::Tiled(_) | Work::Rows(_) | Work::Cells(_) => false,
        Work::Entry(call) => {
            call.shader.reads_textures_itself() && call.bindings.iter().any(|b| b.resource == Resource::Image(image))
        }
    }
}

fn redirect(pass: &mut Pass, old: ImageId, new: ImageId) {
    match &mut pass.work {
        Work::Steps { steps, .. } => {
            let args = steps.iter_mut().flat_map(|s| &mut s.args).filter(|arg| **arg == Arg::Texture(old));
            args.for_each(|arg| *arg = Arg::Texture(new));
        }
        Work::Tiled(_) | Work::Rows(_) | Work::Cells(_) => {}
        Work::Entry(call) => {
            let bindings = call.bindings.iter_mut().filter(|b| b.resource == Resource::Image(old));
            bindings.for_each(|binding| binding.resource = Resource::Image(new));
        }
    }
}

/// How each image is read on this device. Where results must be exact, all filtering is done by hand: a device's own has eight bits of fraction.
pub(crate) fn sample_modes(recording: &Recording, caps: &Caps, exact: bool) -> Vec<SampleMode> {
    let reading = |image: &VirtualImage| {
        let outside = matches!(image.origin, Origin::Input(_)) && !image.finite;
        match (outside, image.signed, exact || image.desc.format.is_32_bit() && !caps.filter_32_bit) {
            (true, true, _) => SampleMode::SanitizedSigned,
            (true, false, _) => SampleMode::Sanitized,
            (false, _, true) => SampleMode::ByHand,
            (false, _, false) => SampleMode::Plain,
        }
    };
    recording.images.iter().map(reading).collect()
}
