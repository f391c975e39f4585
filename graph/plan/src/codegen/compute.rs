//! A compute kernel that its author has written whole: its formats, overrides and bindings are set.

use afterimage_graph::node::{Arg, KernelCall};
use afterimage_wgsl::{GlobalKind, Instance, Linker, ShaderError};

use super::module::{Composed, Entry, PassCode, Slot, SlotKind};

pub(super) fn compose_compute(code: &PassCode<'_>) -> Result<Composed, ShaderError> {
    let kernel = &code.pass.kernels[0];
    let mut linker = code.linker();
    let instance = linker.add_copy(kernel.shader.source())?;
    let (slots, immediate) = bind(code, kernel, &mut linker, instance)?;
    for (name, value) in &kernel.constants {
        linker.set_override(instance, name, *value);
    }
    let reflection = kernel.shader.reflect()?;
    let workgroup = reflection.entry(&kernel.function).map_or([1; 3], |entry| entry.workgroup);
    let linked = linker.link(String::new(), &[(instance, &kernel.function)])?;
    Ok(code.composed(linked, Entry { slots, immediate, workgroup, names: &[] }))
}

/// The bindings of a kernel, and whether it takes the frame's time from immediates; sets the formats of its storage
/// images.
pub(super) fn bind(
    code: &PassCode<'_>,
    kernel: &KernelCall,
    linker: &mut Linker<'_>,
    instance: Instance,
) -> Result<(Vec<Slot>, bool), ShaderError> {
    let (mut slots, mut immediate) = (Vec::new(), false);
    for global in &kernel.shader.reflect()?.globals {
        let kind = match (&global.kind, kernel.arg(&global.name)) {
            (GlobalKind::Frame, None) if code.options.immediates => {
                linker.make_immediate(instance, &global.name);
                immediate = true;
                continue;
            }
            (GlobalKind::Frame, None) => SlotKind::Frame,
            (GlobalKind::Uniform(_), Some(Arg::Block(block))) => SlotKind::Block(block),
            (GlobalKind::Uniform(_), None) => SlotKind::Params,
            (GlobalKind::Sampler, None) => SlotKind::Sampler,
            (GlobalKind::Texture(_), Some(Arg::Texture(image))) => SlotKind::Texture(image),
            (GlobalKind::Texture(_), Some(Arg::Level(part))) => SlotKind::Level(part),
            (GlobalKind::StorageTexture(_), Some(Arg::Storage(image))) => {
                linker.set_storage_format(instance, &global.name, code.format_of(image).wgsl());
                SlotKind::Storage(image)
            }
            (GlobalKind::Buffer(_), Some(Arg::Buffer(buffer, writes))) => SlotKind::Buffer(buffer, writes),
            (GlobalKind::Other, None) => {
                let message = format!(
                    "`{}` has a type that no kernel can bind: textures are `texture_2d<f32>` or `texture_3d<f32>`, and \
                     samplers do not compare",
                    global.name
                );
                return Err(ShaderError::new(kernel.shader.file(), (0, 0), message));
            }
            // A binding that this entry point does not use.
            (_, None) => continue,
            _ => {
                let message = format!("`{}` holds another kind of resource", global.name);
                return Err(ShaderError::new(kernel.shader.file(), (0, 0), message));
            }
        };
        slots.push(Slot { binding: global.binding, kind });
    }
    Ok((slots, immediate))
}
