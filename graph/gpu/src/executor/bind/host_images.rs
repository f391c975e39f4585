//! Checks of the host's images against the plan.

use afterimage_base::color::Transfer;
use afterimage_graph::image::{ColorState, ImageDesc, Size};
use afterimage_graph::node::{ImageId, Pass, Resource};
use afterimage_plan::{Plan, PlanOutput};
use afterimage_wgsl::SampleMode;
use wgpu::{Texture, TextureDimension, TextureFormat, TextureUsages, TextureView};

use crate::error::GpuError;
use crate::executor::frame::Frame;
use crate::texture_format::{image_format, texture_format};

/// A name that the plan does not know is an error: its image would stay as it was.
pub(crate) fn check_names(plan: &Plan, frame: &Frame<'_>) -> Result<(), GpuError> {
    let is_known = |name: &str| plan.outputs.iter().any(|output| output.name == name);
    match frame.outputs.iter().find(|(name, _)| !is_known(name)) {
        None => Ok(()),
        Some((name, _)) => Err(GpuError::unknown_output(plan, name)),
    }
}

/// Checks the size of an image for an input.
pub(crate) fn check_input(
    plan: &Plan,
    port: &str,
    image: ImageId,
    view: &TextureView,
    size: Size,
) -> Result<(), GpuError> {
    let texture = view.texture();
    let planned = plan.image(image);
    check_size(plan, port, image, size)?;
    if image_format(texture.format()) != Some(planned.desc.format) {
        return Err(wrong_format(port, texture, planned.desc));
    }
    check_samples(port, texture.sample_count(), planned.desc.samples)?;
    check_dimension(port, texture, size, planned.desc)?;
    // A device filters no depth. Only an image that is finite is read by its filter.
    if texture.format().is_depth_stencil_format() && planned.sample_mode == SampleMode::Plain {
        return Err(GpuError::unfit(port, "it is a depth, which no device filters: do not promise that it is finite"));
    }
    if texture.usage().contains(TextureUsages::TEXTURE_BINDING) {
        return Ok(());
    }
    Err(GpuError::unfit(port, "its texture lacks the usage `TEXTURE_BINDING`"))
}

fn wrong_format(port: &str, texture: &Texture, planned: ImageDesc) -> GpuError {
    GpuError::WrongImage {
        port: port.to_owned(),
        given: format!("{:?}", texture.format()),
        planned: planned.format.name().to_owned(),
    }
}

/// Refuses textures with another number of samples than the shader reads.
fn check_samples(port: &str, given: u32, planned: u32) -> Result<(), GpuError> {
    let why = match (given, planned) {
        _ if given == planned => return Ok(()),
        (_, 1) => MULTISAMPLED.into(),
        _ => format!("it has {given} samples in each pixel, and the plan is made for {planned}"),
    };
    Err(GpuError::unfit(port, why))
}

/// The reason why a multisampled image does not fit an input that is not declared so.
pub const MULTISAMPLED: &str = "it is multisampled: give the image that it is resolved into, or declare the \
                                       input as `multisampled: true` and wire it to a `Resolve`";

/// Refuses textures that are no volume of the planned depth where the shader reads one.
fn check_dimension(port: &str, texture: &Texture, size: Size, planned: ImageDesc) -> Result<(), GpuError> {
    let depth = size.depth;
    let why = match (texture.dimension() == TextureDimension::D3, planned.volume) {
        (true, true) if depth == planned.size.depth => return Ok(()),
        (true, true) => format!("it has {depth} slices, and the plan is made for {}", planned.size.depth),
        (false, false) => return Ok(()),
        (true, false) => VOLUME.into(),
        (false, true) => "it is no 3-D texture, and the plan is made for a volume".into(),
    };
    Err(GpuError::unfit(port, why))
}

/// The reason why a volume does not fit an input that is not declared so.
pub const VOLUME: &str = "it is a 3-D texture: declare the input as `volume: true`";

/// Checks the size of an image for an output.
pub(crate) fn check_output(plan: &Plan, output: &PlanOutput, view: &TextureView, size: Size) -> Result<(), GpuError> {
    let (texture, port, image) = (view.texture(), output.name.as_str(), output.image);
    let desc = plan.image(image).desc;
    check_size(plan, port, image, size)?;
    if texture.dimension() != TextureDimension::D2 {
        return Err(GpuError::unfit(port, "its texture is not 2-D"));
    }
    if texture.sample_count() > 1 {
        return Err(GpuError::unfit(
            port,
            format!("it has {} samples in each pixel, and outputs have one", texture.sample_count()),
        ));
    }
    if !must_be_drawn(plan, image, texture) {
        return Ok(());
    }
    // Not even trying is allowed with a format of depth.
    let has_color = !texture.format().is_depth_stencil_format();
    if has_color && can_be_drawn(plan, image) {
        return match texture.usage().contains(TextureUsages::RENDER_ATTACHMENT) {
            true => Ok(()),
            false if texture.format() == texture_format(desc.format) => {
                Err(GpuError::unfit(port, "its texture lacks the usages `STORAGE_BINDING` and `RENDER_ATTACHMENT`"))
            }
            false => Err(GpuError::unfit(port, "its texture lacks the usage `RENDER_ATTACHMENT`")),
        };
    }
    match texture.format() == texture_format(desc.format) {
        true => {
            Err(GpuError::unfit(port, "its texture lacks the usage `STORAGE_BINDING`, and no draw makes this image"))
        }
        false => Err(wrong_format(port, texture, desc)),
    }
}

/// An image that the pipeline has encoded would be encoded a second time by a format that encodes. `of_texture` is the
/// format of the texture.
pub(crate) fn check_encoding(
    output: &PlanOutput,
    drawn: Option<TextureFormat>,
    of_texture: TextureFormat,
) -> Result<(), GpuError> {
    let transfer = output.colorimetry.transfer;
    let is_encoded = output.state == ColorState::Encoded && transfer != Transfer::Linear;
    let Some(format) = drawn.filter(|format| format.is_srgb() && is_encoded) else { return Ok(()) };
    let port = &output.name;
    Err(GpuError::unfit(
        port,
        match transfer {
            Transfer::Pq | Transfer::Hlg => format!(
                "the device encodes for the format {format:?}, and the pipeline has encoded the image as {transfer}: \
                 give a view without `Srgb`"
            ),
            _ if !of_texture.is_srgb() => format!(
                "its view has the format {format:?}, and its texture {of_texture:?}: state that of the view, \
                 `formats: &[(\"{port}\", TextureFormat::{format:?})]` in `Frame`"
            ),
            _ => format!(
                "the device encodes for the format {format:?}, and the plan has encoded the image already: name the \
                 output in `HostInputs::linear`"
            ),
        },
    ))
}

/// No pass may read a host image while it writes to it. `views` are those of the inputs, then of the outputs.
pub(crate) fn check_apart(plan: &Plan, views: &[TextureView]) -> Result<(), GpuError> {
    let (inputs, outputs) = views.split_at(plan.inputs.len());
    let is_whole = |texture: &Texture| texture.mip_level_count() == 1 && texture.depth_or_array_layers() == 1;
    for (output, view) in plan.outputs.iter().zip(outputs) {
        let same = |(_, given): &(_, &TextureView)| given.texture() == view.texture() && is_whole(view.texture());
        for ((name, input), _) in plan.inputs.iter().zip(inputs).filter(same) {
            let (read, written) = (Resource::Image(*input), Resource::Image(output.image));
            let both = |pass: &&Pass| pass.reads().contains(&read) && pass.writes().contains(&written);
            if let Some(pass) = plan.work().find(both) {
                let why = format!("it is the image of input `{name}`, which `{}` reads while it writes", pass.label);
                return Err(GpuError::unfit(&output.name, why));
            }
        }
    }
    Ok(())
}

fn check_size(plan: &Plan, port: &str, image: ImageId, size: Size) -> Result<(), GpuError> {
    let planned = plan.image(image).desc.size;
    if (size.width, size.height) == (planned.width, planned.height) || has_rectangle(plan, image) {
        return Ok(());
    }
    Err(GpuError::WrongImage {
        port: port.to_owned(),
        given: format!("{}x{}", size.width, size.height),
        planned: format!("{}x{}", planned.width, planned.height),
    })
}

/// True if frames state a rectangle of the image, which may then have any size.
fn has_rectangle(plan: &Plan, image: ImageId) -> bool {
    plan.rectangles.iter().any(|input| input.image == image)
        || plan.outputs.iter().any(|output| output.image == image && output.in_rectangle)
}

/// True if passes cannot store to the host's image for an output: it has another format, or is not made for it.
pub(crate) fn must_be_drawn(plan: &Plan, image: ImageId, texture: &Texture) -> bool {
    texture.format() != texture_format(plan.image(image).desc.format) || !is_storable(texture)
}

fn is_storable(texture: &Texture) -> bool {
    texture.usage().contains(TextureUsages::STORAGE_BINDING)
}

/// True if kernel functions make the image: only they can be drawn.
fn can_be_drawn(plan: &Plan, image: ImageId) -> bool {
    plan.work().any(|pass| pass.function_result() == Some(image))
}
