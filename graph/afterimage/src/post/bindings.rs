//! The host's statements about its images, and the inputs of plans that follow from a frame.

use std::collections::{BTreeMap, BTreeSet};

use afterimage_gpu::internal::{MULTISAMPLED, VOLUME, image_format, view_of};
use afterimage_gpu::wgpu::{Texture, TextureDimension, TextureFormat};
use afterimage_gpu::{Frame, GpuError, Rectangle};
use afterimage_graph::check::{Graph, GraphInput};
use afterimage_graph::diagnostic::nearest;
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_plan::{HostImageDesc, HostInputs, Part, PlanError};

use crate::error::PostError;

/// Size and format of an image of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostImage {
    /// Texels; the depth of an image that is no volume is 1.
    pub size: Size,
    /// The format of the texture of an input, and of the view of an output.
    pub format: TextureFormat,
    /// Samples in each pixel.
    pub samples: u32,
    /// `true` for a 3-D texture.
    pub volume: bool,
}

impl HostImage {
    /// A 2-D image with one sample in each pixel.
    pub fn new(width: u32, height: u32, format: TextureFormat) -> Self {
        Self { size: Size::new(width, height), format, samples: 1, volume: false }
    }

    /// The image of that size in a texture of the host.
    pub(super) fn of(texture: &Texture, size: Size) -> Self {
        let volume = texture.dimension() == TextureDimension::D3;
        Self { size, format: texture.format(), samples: texture.sample_count(), volume }
    }
}

/// The images of a frame as far as its plan depends on them.
pub(super) trait Images {
    /// The image of an input; the format is that of its texture.
    fn input(&self, name: &str) -> Option<HostImage>;
    /// The image of an output; the format is that of its view.
    fn output(&self, name: &str) -> Option<HostImage>;
    fn first_output(&self) -> Option<&str>;
    fn rectangle_size(&self, name: &str) -> Option<Size>;
    fn has_factor(&self, name: &str) -> bool;
    fn has_block(&self, input: &GraphInput) -> bool;
    /// The names of all images that are given for inputs.
    fn input_names(&self) -> Vec<&str>;
}

impl Images for Frame<'_> {
    fn input(&self, name: &str) -> Option<HostImage> {
        let view = view_of(self.inputs, name)?;
        Some(HostImage::of(view.texture(), self.size_of(name, view)))
    }

    fn output(&self, name: &str) -> Option<HostImage> {
        let view = view_of(self.outputs, name)?;
        let image = HostImage::of(view.texture(), self.size_of(name, view));
        Some(HostImage { format: self.stated_format(name).unwrap_or(image.format), ..image })
    }

    fn first_output(&self) -> Option<&str> {
        self.outputs.first().map(|(name, _)| *name)
    }

    fn rectangle_size(&self, name: &str) -> Option<Size> {
        self.rectangle(name).map(Rectangle::size)
    }

    fn has_factor(&self, name: &str) -> bool {
        self.factors.iter().any(|(known, _)| *known == name)
    }

    fn has_block(&self, input: &GraphInput) -> bool {
        input.block.is_some() && self.blocks.iter().any(|(name, _)| *name == input.name)
    }

    fn input_names(&self) -> Vec<&str> {
        self.inputs.iter().map(|(name, _)| *name).collect()
    }
}

/// The host's statements about its images.
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
    /// `true` if a plan that was made for `inputs` can render a frame.
    ///
    /// # Errors
    /// An image of the host does not fit the graph.
    pub(super) fn fit(&self, graph: &Graph, inputs: &HostInputs, frame: &impl Images) -> Result<bool, GpuError> {
        for input in &graph.inputs {
            if input.block.is_some() {
                if frame.has_block(input) != inputs.blocks.contains(&input.name) {
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
    pub(super) fn inputs(&self, graph: &Graph, frame: &impl Images) -> Result<HostInputs, PostError> {
        check_given(graph, frame)?;
        let (mut inputs, mut parts, mut blocks) = (BTreeMap::new(), BTreeMap::new(), BTreeSet::new());
        let mut size = None;
        for input in &graph.inputs {
            if frame.has_block(input) {
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
            inputs.insert(input.name.clone(), HostImageDesc { desc, finite: self.finite.contains(&input.name) });
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

    /// `true` if the image of an output holds linear light: the host states so, or the device encodes it.
    fn is_linear(&self, frame: &impl Images, output: &str) -> bool {
        self.linear.contains(output) || frame.output(output).is_some_and(|image| image.format.is_srgb())
    }

    /// The description of the host's image for an input, and how its rectangle is read if it has one.
    fn input_image(
        &self,
        frame: &impl Images,
        input: &GraphInput,
    ) -> Result<Option<(ImageDesc, Option<Part>)>, GpuError> {
        let Some(image) = frame.input(&input.name) else { return Ok(None) };
        let desc = desc_of(input, image)?;
        Ok(Some(match (frame.rectangle_size(&input.name), self.size) {
            (Some(_), Some(size)) => (ImageDesc { size, ..desc }, Some(Part::Scaled)),
            (Some(size), None) => (ImageDesc { size, ..desc }, Some(Part::Rectangle)),
            (None, _) => (desc, frame.has_factor(&input.name).then_some(Part::Rectangle)),
        }))
    }
}

/// Checks that the frame has all inputs that are not optional.
///
/// # Errors
/// The first one that is missing, with the name that the host may have given for it.
fn check_given(graph: &Graph, frame: &impl Images) -> Result<(), PostError> {
    for input in graph.inputs.iter().filter(|input| !input.optional) {
        if let Some(block) = input.block {
            if !frame.has_block(input) {
                return Err(GpuError::MissingBlock { port: input.name.clone(), ty: block.name }.into());
            }
        } else if frame.input(&input.name).is_none() {
            let mut unknown = frame.input_names();
            unknown.retain(|name| graph.inputs.iter().all(|known| known.name != *name));
            let given = nearest(&input.name, unknown.iter().copied()).or(match unknown[..] {
                [only] => Some(only),
                _ => None,
            });
            return Err(PostError::MissingInput { input: input.name.clone(), given: given.map(str::to_owned) });
        }
    }
    Ok(())
}

fn output_size(frame: &impl Images) -> Option<Size> {
    let name = frame.first_output()?;
    frame.rectangle_size(name).or(frame.output(name).map(|image| image.size))
}

/// `true` if an output is written to a rectangle of the host's image.
fn is_in_rectangle(frame: &impl Images, output: &str) -> bool {
    frame.rectangle_size(output).is_some() && frame.output(output).is_some()
}

/// The description of the host's image for an input.
fn desc_of(input: &GraphInput, image: HostImage) -> Result<ImageDesc, GpuError> {
    let HostImage { size, format: given, samples, volume } = image;
    let channels = if given.is_depth_stencil_format() { 1 } else { given.components() };
    let unfit = |why: String| GpuError::UnfitImage { port: input.name.clone(), why };
    let Some(format) = image_format(given) else {
        return Err(unfit(format!("its format, {given:?}, is none that plans have")));
    };
    if channels < input.min_channels {
        let why = format!(
            "its format, {given:?}, has {channels} of the {} channels that the pipeline reads; does it belong to \
             another input?",
            input.min_channels
        );
        return Err(unfit(why));
    }
    match (input.multisampled, samples > 1) {
        (true, false) => return Err(unfit("it has one sample in each pixel, and the pipeline requires more".into())),
        (false, true) => return Err(unfit(MULTISAMPLED.into())),
        _ => {}
    }
    match (input.volume, volume) {
        (true, false) => return Err(unfit("it is no 3-D texture, and the pipeline requires a volume".into())),
        (false, true) => return Err(unfit(VOLUME.into())),
        _ => {}
    }
    let desc = if volume { ImageDesc::volume(size) } else { ImageDesc::new(size) };
    Ok(desc.format(format).multisampled(samples))
}
