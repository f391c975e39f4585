//! Whether the host's images fit the plan.

use afterimage_base::color::Transfer;
use afterimage_graph::image::{ColorState, ImageDesc};
use afterimage_graph::node::{ImageId, Pass, Resource};
use afterimage_plan::{Plan, PlanOutput};
use afterimage_wgsl::SampleMode;
use wgpu::{Texture, TextureDimension, TextureFormat, TextureUsages, TextureView};

use crate::device::{image_format, texture_format};
use crate::error::GpuError;
use crate::executor::frame::Frame;

/// A name that the plan does not know is an error: its image would stay as it was.
pub(crate) fn check_names(plan: &Plan, frame: &Frame<'_>) -> Result<(), GpuError> {
    let is_known = |name: &str| plan.outputs.iter().any(|output| output.name == name);
    match frame.outputs.iter().find(|(name, _)| !is_known(name)) {
        None => Ok(()),
        Some((name, _)) => Err(GpuError::UnknownOutput {
            name: (*name).to_owned(),
            known: plan.outputs.iter().map(|output| format!("`{}`", output.name)).collect::<Vec<_>>().join(", "),
        }),
    }
}

pub(crate) fn check_input(plan: &Plan, port: &str, image: ImageId, view: &TextureView) -> Result<(), GpuError> {
    let texture = view.texture();
    let planned = plan.image(image);
    check_desc(plan, port, image, texture, image_format(texture.format()) == Some(planned.desc.format))?;
    check_samples(port, texture.sample_count(), planned.desc.samples)?;
    check_dimension(port, texture, planned.desc)?;
    // A device filters no depth. Only an image that is finite is read by its filter.
    if texture.format().is_depth_stencil_format() && planned.sample_mode == SampleMode::Plain {
        let why = "it is a depth, which no device filters: do not promise that it is finite";
        return Err(GpuError::UnfitImage { port: port.to_owned(), why: why.into() });
    }
    if texture.usage().contains(TextureUsages::TEXTURE_BINDING) {
        return Ok(());
    }
    Err(GpuError::UnfitImage { port: port.to_owned(), why: "its texture lacks the usage `TEXTURE_BINDING`".into() })
}

/// What a shader reads as a multisampled texture must be one.
fn check_samples(port: &str, given: u32, planned: u32) -> Result<(), GpuError> {
    let why = match (given, planned) {
        _ if given == planned => return Ok(()),
        (_, 1) => MULTISAMPLED.into(),
        _ => format!("it has {given} samples in each pixel, and the plan is made for {planned}"),
    };
    Err(GpuError::UnfitImage { port: port.to_owned(), why })
}

/// Why a multisampled image does not fit an input that is not declared so.
pub(crate) const MULTISAMPLED: &str = "it is multisampled: give the image that it is resolved into, or declare the \
                                       input as `multisampled: true` and wire it to a `Resolve`";

/// What a shader reads as a volume must be one, as deep as planned.
fn check_dimension(port: &str, texture: &Texture, planned: ImageDesc) -> Result<(), GpuError> {
    let depth = texture.depth_or_array_layers();
    let why = match (texture.dimension() == TextureDimension::D3, planned.volume) {
        (true, true) if depth == planned.size.depth => return Ok(()),
        (true, true) => format!("it has {depth} slices, and the plan is made for {}", planned.size.depth),
        (false, false) => return Ok(()),
        (true, false) => VOLUME.into(),
        (false, true) => "it is no 3-D texture, and the plan is made for a volume".into(),
    };
    Err(GpuError::UnfitImage { port: port.to_owned(), why })
}

/// Why a volume does not fit an input that is not declared so.
pub(crate) const VOLUME: &str = "it is a 3-D texture: declare the input as `volume: true`";

pub(crate) fn check_output(plan: &Plan, port: &str, image: ImageId, view: &TextureView) -> Result<(), GpuError> {
    let texture = view.texture();
    let is_drawn = must_be_drawn(plan, image, texture);
    // Not even trying is allowed with a format of depth.
    let has_color = !texture.format().is_depth_stencil_format();
    check_desc(plan, port, image, texture, has_color && (!is_drawn || can_be_drawn(plan, image)))?;
    if !is_drawn || texture.usage().contains(TextureUsages::RENDER_ATTACHMENT) {
        return Ok(());
    }
    let why = "its texture lacks the usage `RENDER_ATTACHMENT`, or `STORAGE_BINDING` in the planned format";
    Err(GpuError::UnfitImage { port: port.to_owned(), why: why.into() })
}

/// An image that the pipeline has encoded would be encoded a second time by a format that encodes.
pub(crate) fn check_encoding(output: &PlanOutput, drawn: Option<TextureFormat>) -> Result<(), GpuError> {
    let is_encoded = output.state == ColorState::Encoded && output.colorimetry.transfer != Transfer::Linear;
    let Some(format) = drawn.filter(|format| format.is_srgb() && is_encoded) else { return Ok(()) };
    let why = format!(
        "the device encodes for the format {format:?}, and the pipeline has encoded the image already: give a view \
         without `Srgb`, or use `Encode(transfer: Linear)`"
    );
    Err(GpuError::UnfitImage { port: output.name.clone(), why })
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
                return Err(GpuError::UnfitImage { port: output.name.clone(), why });
            }
        }
    }
    Ok(())
}

fn check_desc(plan: &Plan, port: &str, image: ImageId, texture: &Texture, is_valid: bool) -> Result<(), GpuError> {
    let desc = plan.image(image).desc;
    let is_planned = (texture.width(), texture.height()) == (desc.size.width, desc.size.height);
    if is_valid && (is_planned || has_rectangle(plan, image)) {
        return Ok(());
    }
    let is_input = plan.inputs.iter().any(|(_, input)| *input == image);
    let usage = if is_input || is_storable(texture) { "" } else { " without `STORAGE_BINDING`" };
    Err(GpuError::WrongImage {
        port: port.to_owned(),
        given: format!("{}x{} {:?}{usage}", texture.width(), texture.height(), texture.format()),
        planned: format!("{} {}", desc.size, desc.format.name()),
    })
}

/// Whether frames state a rectangle of the image, which may then have any size.
fn has_rectangle(plan: &Plan, image: ImageId) -> bool {
    plan.rectangles.iter().any(|input| input.image == image)
        || plan.outputs.iter().any(|output| output.image == image && output.in_rectangle)
}

/// Whether passes cannot store to the host's image for an output: it has another format, or is not made for it.
pub(crate) fn must_be_drawn(plan: &Plan, image: ImageId, texture: &Texture) -> bool {
    texture.format() != texture_format(plan.image(image).desc.format) || !is_storable(texture)
}

fn is_storable(texture: &Texture) -> bool {
    texture.usage().contains(TextureUsages::STORAGE_BINDING)
}

/// Whether kernel functions make the image: only they can be drawn.
fn can_be_drawn(plan: &Plan, image: ImageId) -> bool {
    plan.work().any(|pass| pass.function_result() == Some(image))
}
