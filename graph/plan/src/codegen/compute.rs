//! Compute entry points that their authors have written.

use super::module::{Composed, Slot, SlotKind};
use afterimage_base::image::Format;
use afterimage_graph::node::{Arg, ImageId, KernelCall};
use afterimage_wgsl::{GlobalKind, SampleMode, ShaderError, ShaderFeatures, Text};

/// A compute entry point, with the formats of its storage images set and its bindings resolved.
pub(super) fn compose_compute(
    call: &KernelCall,
    format_of: &dyn Fn(ImageId) -> Format,
    sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    features: ShaderFeatures,
) -> Result<Composed, ShaderError> {
    let reflection = call.shader.reflect()?;
    let Bound { slots, formats, reading } = Bound::new(call, format_of, sample_mode_of)?;
    let mut text = Text::default().reading(reading, features)?;
    text.module(&call.shader)?;
    let source = formats.iter().fold(text.text, |source, (name, format)| set_storage_format(&source, name, *format));
    let entry = reflection.entry(&call.function);
    Ok(Composed {
        source,
        map: text.map,
        compute: call.function.clone(),
        fragment: None,
        slots,
        workgroup: entry.map_or([1; 3], |entry| entry.workgroup),
        unchecked: call.shader.is_unchecked(),
        reading,
        zero_workgroup_memory: !call.shader.is_unchecked(),
    })
}

/// What the bindings of a compute entry point hold.
pub(super) struct Bound {
    pub(super) slots: Vec<Slot>,
    /// The formats of the storage images, by the variables' names.
    pub(super) formats: Vec<(String, Format)>,
    /// How the textures must be read.
    pub(super) reading: SampleMode,
}

impl Bound {
    pub(super) fn new(
        call: &KernelCall,
        format_of: &dyn Fn(ImageId) -> Format,
        sample_mode_of: &dyn Fn(ImageId) -> SampleMode,
    ) -> Result<Self, ShaderError> {
        let mut bound = Self { slots: Vec::new(), formats: Vec::new(), reading: SampleMode::default() };
        let Self { slots, formats, reading } = &mut bound;
        for global in &call.shader.reflect()?.globals {
            let kind = match (&global.kind, call.arg(&global.name)) {
                (GlobalKind::Uniform(ty), None) if ty == "Frame" => SlotKind::Frame,
                (GlobalKind::Uniform(_), None) => SlotKind::Params,
                (GlobalKind::Sampler, None) => SlotKind::Sampler,
                (GlobalKind::Texture(_), Some(Arg::Texture(image))) => {
                    *reading = (*reading).max(sample_mode_of(image));
                    SlotKind::Texture(image)
                }
                (GlobalKind::StorageTexture(_), Some(Arg::Storage(image))) => {
                    formats.push((global.name.clone(), format_of(image)));
                    SlotKind::Storage(image)
                }
                (GlobalKind::Buffer(_), Some(Arg::Buffer(buffer, writes))) => SlotKind::Buffer(buffer, writes),
                // A binding that this entry point does not use.
                (_, None) => continue,
                _ => {
                    return Err(ShaderError::at(
                        call.shader.file(),
                        0,
                        format!("`{}` holds another kind of resource", global.name),
                    ));
                }
            };
            slots.push(Slot { binding: global.binding, kind });
        }
        Ok(bound)
    }
}

/// Replaces the format in `var NAME: texture_storage_2d<FORMAT, write>`, which a graph file may choose.
pub(super) fn set_storage_format(source: &str, name: &str, format: Format) -> String {
    let declaration = format!("var {name}: texture_storage_");
    let Some(start) = source.find(&declaration) else { return source.to_owned() };
    let Some(open) = source[start..].find('<').map(|at| start + at + 1) else { return source.to_owned() };
    let Some(comma) = source[open..].find(',').map(|at| open + at) else { return source.to_owned() };
    format!("{}{}{}", &source[..open], format.wgsl(), &source[comma..])
}
