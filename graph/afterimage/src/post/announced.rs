//! Frames that a host announces: their plans are made and compiled before the first of them is recorded.

use afterimage_gpu::wgpu::TextureFormat;
use afterimage_graph::check::GraphInput;
use afterimage_graph::image::Size;

use super::bindings::{HostImage, Images};

/// The most frames that can be announced: plans are cached for these at a few facts.
pub(super) const MAX_FRAMES: usize = 16;

/// A frame that a host will record, as far as plans depend on it: sizes and formats of its images.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExpectedFrame<'a> {
    /// The images of inputs, by their names.
    pub inputs: &'a [(&'a str, HostImage)],
    /// The optional inputs for which the frame has a block. Those that the pipeline needs are not listed.
    pub blocks: &'a [&'a str],
    /// The images of outputs, by their names.
    pub outputs: &'a [(&'a str, HostImage)],
    /// The sizes of the rectangles of inputs and outputs.
    pub rectangles: &'a [(&'a str, Size)],
    /// The inputs that have a factor.
    pub factors: &'a [&'a str],
}

/// An owned [`ExpectedFrame`].
#[derive(Clone)]
pub(super) struct AnnouncedFrame {
    inputs: Vec<(String, HostImage)>,
    blocks: Vec<String>,
    outputs: Vec<(String, HostImage)>,
    rectangles: Vec<(String, Size)>,
    factors: Vec<String>,
}

impl From<&ExpectedFrame<'_>> for AnnouncedFrame {
    fn from(frame: &ExpectedFrame<'_>) -> Self {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let images = |images: &[(&str, HostImage)]| images.iter().map(|(name, of)| ((*name).to_owned(), *of)).collect();
        Self {
            inputs: images(frame.inputs),
            blocks: names(frame.blocks),
            outputs: images(frame.outputs),
            rectangles: frame.rectangles.iter().map(|(name, size)| ((*name).to_owned(), *size)).collect(),
            factors: names(frame.factors),
        }
    }
}

impl AnnouncedFrame {
    /// The formats of outputs.
    pub(super) fn drawn(&self) -> Vec<(String, TextureFormat)> {
        self.outputs.iter().map(|(name, image)| (name.clone(), image.format)).collect()
    }
}

fn named<T: Copy>(all: &[(String, T)], name: &str) -> Option<T> {
    all.iter().find(|(known, _)| known == name).map(|(_, found)| *found)
}

impl Images for AnnouncedFrame {
    fn input(&self, name: &str) -> Option<HostImage> {
        named(&self.inputs, name)
    }

    fn output(&self, name: &str) -> Option<HostImage> {
        named(&self.outputs, name)
    }

    fn first_output(&self) -> Option<&str> {
        self.outputs.first().map(|(name, _)| name.as_str())
    }

    fn rectangle_size(&self, name: &str) -> Option<Size> {
        named(&self.rectangles, name)
    }

    fn has_factor(&self, name: &str) -> bool {
        self.factors.iter().any(|known| known == name)
    }

    fn has_block(&self, input: &GraphInput) -> bool {
        input.block.is_some() && (!input.optional || self.blocks.contains(&input.name))
    }

    fn input_names(&self) -> Vec<&str> {
        self.inputs.iter().map(|(name, _)| name.as_str()).collect()
    }
}
