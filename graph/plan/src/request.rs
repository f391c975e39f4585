//! Requests for plans: the frame, the scene and the device.

use std::collections::{BTreeMap, BTreeSet};

use afterimage_base::caps::Caps;
use afterimage_base::image::{ImageDesc, Size};
use afterimage_graph::check::{Facts, GraphInput, ParameterId};
use serde::Serialize;

use crate::options::Options;

/// The inputs of planning besides the graph: the frame, the scene and the device.
pub struct PlanRequest<'a> {
    /// The images and blocks of the host.
    pub given: HostInputs,
    /// Facts about the scene.
    pub facts: Facts,
    pub caps: Caps,
    pub options: Options,
    /// Parameters that the host changes while the plan runs. A node that has one runs also where its present values
    /// change nothing.
    pub dynamic: BTreeSet<ParameterId>,
    /// Bytes and alignment that the device wants for an image.
    pub requirement: &'a dyn Fn(&ImageDesc) -> Requirement,
}

/// The images and blocks that the host provides in a frame, as far as plans depend on them.
#[derive(Clone, Debug, PartialEq)]
pub struct HostInputs {
    /// The size of the frame, for nodes without an image input.
    pub size: Size,
    /// The images, by the names of the pipeline's inputs.
    pub inputs: BTreeMap<String, HostImageDesc>,
    /// The inputs that host blocks are given for.
    pub blocks: BTreeSet<String>,
    /// The outputs whose images hold linear light: what is encoded as sRGB or with a gamma is decoded again. A texture
    /// of an sRGB format holds linear light, because the device encodes it.
    pub linear: BTreeSet<String>,
    /// The inputs of which frames state a rectangle or a factor, and how large the rectangle is.
    pub parts: BTreeMap<String, Part>,
    /// The outputs that go into a rectangle of their image, which frames state.
    pub rectangles: BTreeSet<String>,
}

/// Samples of a multisampled image that every device has.
const SAMPLES: u32 = 4;

/// The size of the volumes of [`HostInputs::all`]. Odd sides have a middle, so that a checkerboard is symmetric.
const VOLUME: [u32; 3] = [9, 5, 3];

/// The kind of rectangle of an input whose rectangle and factor change without a new plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Part {
    /// A rectangle of the size in [`HostInputs::inputs`].
    Rectangle,
    /// A rectangle of any size, which is filtered to that size; data takes the nearest texel.
    Scaled,
}

impl HostInputs {
    /// A frame of this size for which the host gives nothing.
    pub fn none(size: Size) -> Self {
        let (inputs, parts) = (BTreeMap::new(), BTreeMap::new());
        Self { size, inputs, blocks: BTreeSet::new(), linear: BTreeSet::new(), parts, rectangles: BTreeSet::new() }
    }

    /// A frame of this size with the same image, or a block, for each of these inputs. Images of multisampled inputs
    /// have four samples, which every device has; volumes have 9 x 5 x 3 texels.
    pub fn all<'i>(size: Size, inputs: impl IntoIterator<Item = &'i GraphInput>, image: HostImageDesc) -> Self {
        let mut given = Self::none(size);
        for input in inputs {
            match input.block {
                Some(_) => drop(given.blocks.insert(input.name.clone())),
                None => {
                    let samples = if input.multisampled { SAMPLES } else { 1 };
                    let desc = image.desc.multisampled(samples);
                    let [width, height, depth] = VOLUME;
                    let volume = ImageDesc::volume(Size::volume(width, height, depth)).format(desc.format);
                    let desc = if input.volume { volume } else { desc };
                    given.inputs.insert(input.name.clone(), HostImageDesc { desc, ..image });
                }
            }
        }
        given
    }

    /// Returns whether the host provides an input.
    pub(crate) fn has(&self, input: &GraphInput) -> bool {
        match input.block {
            Some(_) => self.blocks.contains(&input.name),
            None => self.inputs.contains_key(&input.name),
        }
    }
}

impl PlanRequest<'_> {
    /// The parameters of a node that the host changes, by their indices.
    pub(crate) fn dynamic_of(&self, node: usize) -> Vec<usize> {
        let (first, last) = (ParameterId { node, index: 0 }, ParameterId { node, index: usize::MAX });
        self.dynamic.range(first..=last).map(|parameter| parameter.index).collect()
    }
}

/// An image that the host gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostImageDesc {
    pub desc: ImageDesc,
    /// True if the host guarantees that all its numbers are finite and within ±65504, and negative only where the color
    /// state allows it: see [`Signedness`](afterimage_base::image::Signedness).
    pub finite: bool,
}

/// The memory requirement of an image on a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Requirement {
    /// Bytes, with the driver's padding.
    pub bytes: u64,
    /// Alignment of its offset; a power of two.
    pub alignment: u64,
}

impl Requirement {
    /// A plausible requirement where no device is asked: whole blocks of 64 KiB.
    pub fn typical(desc: &ImageDesc) -> Self {
        const BLOCK: u64 = 1 << 16;
        Self { bytes: desc.bytes().next_multiple_of(BLOCK), alignment: BLOCK }
    }
}
