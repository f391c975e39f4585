//! What the host states about its images, and the inputs of plans that follow from a frame.

use std::collections::{BTreeMap, BTreeSet};

use afterimage_base::diagnostic::nearest;
use afterimage_graph::check::{Graph, GraphInput};
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_plan::{GivenImage, HostInputs, Part, PlanError};
use wgpu::TextureView;

use super::error::PostError;
use crate::device::image_format;
use crate::error::GpuError;
use crate::executor::{Frame, MULTISAMPLED, Rectangle, VOLUME, view_of};

/// What the host states about its images.
#[derive(Clone, Default)]
pub(super) struct HostBindings {
    /// The size of images in rectangles, whatever the sizes of the rectangles.
    pub(super) size: Option<Size>,
    /// Inputs whose texels are known to be finite.
    pub(super) finite: BTreeSet<String>,
    /// Outputs that hold linear light.
    pub(super) linear: BTreeSet<String>,
}

impl HostBindings {
    /// Whether a plan that was made for `inputs` can render a frame.
    ///
    /// # Errors
    /// An image of the host does not fit the graph.
    pub(super) fn fit(&self, graph: &Graph, inputs: &HostInputs, frame: &Frame<'_>) -> Result<bool, GpuError> {
        for input in &graph.inputs {
            if input.block.is_some() {
                if gives_block(frame, input) != inputs.blocks.contains(&input.name) {
                    return Ok(false);
                }
                continue;
            }
            let (desc, part) = self.input_image(frame, input)?.unzip();
            if desc != inputs.inputs.get(&input.name).map(|given| given.desc)
                || part.flatten() != inputs.parts.get(&input.name).copied()
            {
                return Ok(false);
            }
        }
        for output in &graph.outputs {
            if self.is_linear(frame, &output.name) != inputs.linear.contains(&output.name)
                || is_in_rectangle(frame, &output.name) != inputs.rectangles.contains(&output.name)
            {
                return Ok(false);
            }
        }
        Ok(!inputs.inputs.is_empty() || output_size(frame).or(self.size).is_none_or(|size| size == inputs.size))
    }

    /// The inputs of a plan for a frame. The size is that of the first image, or else of the first output, or the
    /// stated one.
    ///
    /// # Errors
    /// An image of the host does not fit the graph, or no size is known.
    pub(super) fn inputs(&self, graph: &Graph, frame: &Frame<'_>) -> Result<HostInputs, PostError> {
        check_given(graph, frame)?;
        let (mut inputs, mut parts, mut blocks) = (BTreeMap::new(), BTreeMap::new(), BTreeSet::new());
        let mut size = None;
        for input in &graph.inputs {
            if gives_block(frame, input) {
                blocks.insert(input.name.clone());
            }
            let Some((desc, part)) = self.input_image(frame, input)? else { continue };
            // The size of a volume is not that of the frame.
            if !desc.volume {
                size = size.or(Some(desc.size));
            }
            if let Some(part) = part {
                parts.insert(input.name.clone(), part);
            }
            inputs.insert(input.name.clone(), GivenImage { desc, finite: self.finite.contains(&input.name) });
        }
        let (mut linear, mut rectangles) = (BTreeSet::new(), BTreeSet::new());
        for output in &graph.outputs {
            if self.is_linear(frame, &output.name) {
                linear.insert(output.name.clone());
            }
            if is_in_rectangle(frame, &output.name) {
                rectangles.insert(output.name.clone());
            }
        }
        let Some(size) = size.or(output_size(frame)).or(self.size) else {
            let first = graph.inputs.iter().find(|input| input.block.is_none());
            return Err(PlanError::MissingInput(first.map_or(String::new(), |input| input.name.clone())).into());
        };
        Ok(HostInputs { size, inputs, blocks, linear, parts, rectangles })
    }

    /// Whether the image of an output holds linear light: the host states so, or the device encodes it.
    fn is_linear(&self, frame: &Frame<'_>, output: &str) -> bool {
        let view = view_of(frame.outputs, output);
        let format = frame.stated_format(output).or(view.map(|view| view.texture().format()));
        self.linear.contains(output) || format.is_some_and(|format| format.is_srgb())
    }

    /// The description of the host's image for an input, and how its rectangle is read if it has one.
    fn input_image(
        &self,
        frame: &Frame<'_>,
        input: &GraphInput,
    ) -> Result<Option<(ImageDesc, Option<Part>)>, GpuError> {
        let Some(view) = view_of(frame.inputs, &input.name) else { return Ok(None) };
        let desc = desc_of(input, view)?;
        let has_factor = frame.factors.iter().any(|(name, _)| *name == input.name);
        Ok(Some(match (frame.rectangle(&input.name), self.size) {
            (Some(_), Some(size)) => (ImageDesc { size, ..desc }, Some(Part::Scaled)),
            (Some(rectangle), None) => (ImageDesc { size: rectangle.size(), ..desc }, Some(Part::Rectangle)),
            (None, _) => (desc, has_factor.then_some(Part::Rectangle)),
        }))
    }
}

/// Checks that the frame has all inputs that are not optional.
///
/// # Errors
/// The first one that is missing, with the name that the host may have given for it.
fn check_given(graph: &Graph, frame: &Frame<'_>) -> Result<(), PostError> {
    for input in graph.inputs.iter().filter(|input| !input.optional) {
        if let Some(block) = input.block {
            if !frame.blocks.iter().any(|(name, _)| *name == input.name) {
                return Err(GpuError::MissingBlock { port: input.name.clone(), ty: block.name }.into());
            }
        } else if !frame.inputs.iter().any(|(name, _)| *name == input.name) {
            let unknown = frame.inputs.iter().map(|(name, _)| *name);
            let unknown: Vec<&str> =
                unknown.filter(|name| graph.inputs.iter().all(|known| known.name != *name)).collect();
            let given = nearest(&input.name, unknown.iter().copied()).or(match unknown[..] {
                [only] => Some(only),
                _ => None,
            });
            return Err(PostError::MissingInput { input: input.name.clone(), given: given.map(str::to_owned) });
        }
    }
    Ok(())
}

fn gives_block(frame: &Frame<'_>, input: &GraphInput) -> bool {
    input.block.is_some() && frame.blocks.iter().any(|(name, _)| *name == input.name)
}

fn output_size(frame: &Frame<'_>) -> Option<Size> {
    let (name, view) = frame.outputs.first()?;
    Some(frame.rectangle(name).unwrap_or(Rectangle::of_texture(view.texture())).size())
}

/// Whether an output is written to a rectangle of the host's image.
fn is_in_rectangle(frame: &Frame<'_>, output: &str) -> bool {
    frame.rectangle(output).is_some() && view_of(frame.outputs, output).is_some()
}

/// The description of the host's texture for an input.
fn desc_of(input: &GraphInput, view: &TextureView) -> Result<ImageDesc, GpuError> {
    let texture = view.texture();
    let channels = if texture.format().is_depth_stencil_format() { 1 } else { texture.format().components() };
    let unfit = |why: String| GpuError::UnfitImage { port: input.name.clone(), why };
    let Some(format) = image_format(texture.format()) else {
        return Err(unfit(format!("its format, {:?}, is none that plans have", texture.format())));
    };
    if channels < input.min_channels {
        let why = format!(
            "its format, {:?}, has {channels} of the {} channels that the pipeline reads; does it belong to another \
             input?",
            texture.format(),
            input.min_channels
        );
        return Err(unfit(why));
    }
    let samples = texture.sample_count();
    match (input.multisampled, samples > 1) {
        (true, false) => return Err(unfit("it has one sample in each pixel, and the pipeline requires more".into())),
        (false, true) => return Err(unfit(MULTISAMPLED.into())),
        _ => {}
    }
    let is_volume = texture.dimension() == wgpu::TextureDimension::D3;
    match (input.volume, is_volume) {
        (true, false) => return Err(unfit("it is no 3-D texture, and the pipeline requires a volume".into())),
        (false, true) => return Err(unfit(VOLUME.into())),
        _ => {}
    }
    let depth = if is_volume { texture.depth_or_array_layers() } else { 1 };
    let size = Size::volume(texture.width(), texture.height(), depth);
    let desc = if is_volume { ImageDesc::volume(size) } else { ImageDesc::new(size) };
    Ok(desc.format(format).multisampled(samples))
}
