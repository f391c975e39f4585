//! The passes of one recording, and whether they are fit for a device.

use std::collections::BTreeSet;

use super::limits;
use super::names::{pascal, snake, stem};
use super::recorded::Recorded;
use super::violations::Violations;
use crate::node::{
    Arg, BufferLife, Drawing, ImageId, InputValue, KernelCall, NodeKind, Origin, Pass, PortType, Recording, Resource,
    Subresource,
};
use afterimage_base::image::Size;

pub(super) fn look(kind: &NodeKind, recorded: &Recorded, size: Size, violations: &mut Violations) {
    outputs(kind, recorded, violations);
    let recording = &recorded.recording;
    limits::look(recording, size, violations);
    let mut drawn: BTreeSet<Subresource> = BTreeSet::new();
    for pass in &recording.passes {
        for image in pass.writes().into_iter().filter_map(Resource::image) {
            let is_foreign = (image.0 as usize) < recorded.input_images;
            let is_constant = matches!(recording.image(image).origin, Origin::Constant(_));
            violations.require(!is_foreign && !is_constant, || {
                format!("the pass `{}` writes an image that is not its own", pass.label)
            });
        }
        pixels(pass, recording, violations);
        retained(pass, recording, violations);
        for shader in pass.shaders() {
            let stem = stem(shader.file());
            violations.require(snake(&pascal(stem)) == stem, || {
                format!("the file `{}` is not called after a kind, in snake_case", shader.file())
            });
        }
        for kernel in &pass.kernels {
            blocks(kernel, kind, violations);
            samples(kernel, recording, violations);
        }
        // Mip levels and layers are drawn one by one.
        for part in pass.args().flat_map(|arg| parts(arg, recording)).filter(|part| !drawn.contains(part)) {
            let (label, Subresource { level, layer, .. }) = (&recording.image(part.image).label, part);
            violations.add(format!(
                "the pass `{}` reads level {level} of layer {layer} of `{label}`, which is not drawn",
                pass.label
            ));
        }
        drawn.extend(pass.drawing().into_iter().flat_map(Drawing::targets));
    }
}

fn outputs(kind: &NodeKind, recorded: &Recorded, violations: &mut Violations) {
    for (port, value) in kind.outputs().iter().zip(&recorded.outputs) {
        let fits = matches!(
            (port.ty, value),
            (PortType::Image | PortType::Volume, InputValue::Image(_) | InputValue::Zero)
                | (PortType::Multisampled, InputValue::Image(_))
                | (PortType::Pyramid, InputValue::Pyramid(_) | InputValue::Zero)
                | (PortType::Table | PortType::Value, InputValue::Buffer(_))
        );
        violations
            .require(fits, || format!("the output `{}` is used and not given as a {}", port.name, port.ty.name()));
    }
}

/// The parts that an argument reads, of an image that is drawn in parts.
fn parts(arg: Arg, recording: &Recording) -> Vec<Subresource> {
    let is_in_parts = |image: ImageId| {
        let image = recording.image(image);
        image.origin == Origin::Transient && (image.desc.levels, image.desc.layers) != (1, 1)
    };
    match arg {
        Arg::Texture(image) if is_in_parts(image) => {
            (0..recording.image(image).desc.levels).map(|level| image.level(level)).collect()
        }
        Arg::Level(part) if is_in_parts(part.image) => vec![part],
        _ => Vec::new(),
    }
}

/// The structs of host blocks have the members that the kind's ports declare.
fn blocks(kernel: &KernelCall, kind: &NodeKind, violations: &mut Violations) {
    let Ok(reflection) = kernel.shader.reflect() else { return };
    for arg in kernel.args.iter().filter(|arg| matches!(arg.value, Arg::Block(_))) {
        let layout = reflection.struct_of(&kernel.function, &arg.name).and_then(|ty| reflection.layout(ty));
        let declared = kind.input(&arg.name).and_then(|port| port.block);
        let fits = layout.zip(declared).is_some_and(|(layout, declared)| declared.fits(layout));
        violations.require(fits, || {
            format!("the struct of `{}` in `{}` has not the members of its host block", arg.name, kernel.function)
        });
    }
}

/// Samples are sanitized where the library reads them, and nowhere else.
fn samples(kernel: &KernelCall, recording: &Recording, violations: &mut Violations) {
    let has_samples = kernel.textures().any(|image| recording.image(image).desc.samples > 1);
    let is_direct = kernel.shader.reads_textures_itself(&kernel.function);
    violations.require(!(has_samples && is_direct), || {
        format!("`{}` reads samples directly: `texel_sample` of the library sanitizes them", kernel.function)
    });
}

/// A pixel is read at the place of the result, so its image has the size of the result.
fn pixels(pass: &Pass, recording: &Recording, violations: &mut Violations) {
    for misfit in recording.misfit_pixels(pass) {
        violations.add(format!(
            "`{}` takes the pixel `{}` of `{}`, which has another size than its result: take a texture, and read it \
             with `tap`",
            misfit.kernel.function,
            misfit.argument,
            recording.image(misfit.image).label
        ));
    }
}

/// A pass that runs after a change of its uniforms reads nothing that frames change.
fn retained(pass: &Pass, recording: &Recording, violations: &mut Violations) {
    let is_retained =
        |resource: &Resource| resource.image().is_some_and(|i| recording.image(i).origin == Origin::Retained);
    if !pass.writes().iter().any(is_retained) {
        return;
    }
    let lasts = |resource: &Resource| match *resource {
        Resource::Image(image) => matches!(recording.image(image).origin, Origin::Constant(_) | Origin::Retained),
        Resource::Buffer(buffer) => matches!(recording.buffer(buffer).life, BufferLife::Constant(_)),
    };
    let is_of_frame = pass.args().any(|arg| matches!(arg, Arg::Frame | Arg::Block(_)));
    violations.require(!is_of_frame && pass.reads().iter().all(lasts), || {
        format!("the pass `{}` writes an image that is made once, and reads what each frame changes", pass.label)
    });
}
