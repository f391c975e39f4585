//! The plan: a value that states everything about a frame, equal for equal inputs.

mod barrier;
mod image;
mod metering;
mod names;
mod pass;
mod refresh;
mod savings;
mod state;

use afterimage_base::color::Colorimetry;
use afterimage_base::image::{ColorState, Size};
use afterimage_graph::node::{BlockId, HostBlock, ImageColor, ImageId, Pass, Resource, VirtualBuffer};
use serde::{Serialize, Serializer};

pub use barrier::{AliasingBarrier, Batch, Transition, Use};
pub use image::{Lifetime, Memory, PlannedImage, Slot};
pub use metering::Metering;
pub use pass::{PlannedPass, Refresh, ScheduledPass, Stage, UniformBlock};
pub(crate) use refresh::passes_only_for;
pub use savings::{Baked, CachedResults, Fused, Savings, SharedRead, Skipped};
pub use state::{StateContent, StateItem};

use crate::options::Options;
use crate::request::Part;
use names::unique;

/// A pipeline made ready for one frame size, one set of facts and one device. It is never altered.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    pub images: Vec<PlannedImage>,
    pub buffers: Vec<VirtualBuffer>,
    /// The passes in the order of execution.
    pub passes: Vec<PlannedPass>,
    /// Passes that need no barrier between them, with the barriers before them; they cover all passes in order.
    pub batches: Vec<Batch>,
    /// The transitions of the outputs to the host after the last batch.
    pub exports: Vec<Transition>,
    /// The memory of the transient images.
    pub memory: Memory,
    /// The images that the host gives: input name and image.
    pub inputs: Vec<(String, ImageId)>,
    /// The inputs of which frames state a rectangle and a factor.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rectangles: Vec<RectangleInput>,
    /// The host blocks that passes read.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub blocks: Vec<PlannedBlock>,
    pub outputs: Vec<PlanOutput>,
    /// The work of the nodes that frames do not do.
    #[serde(flatten)]
    pub savings: Savings,
    /// Parameters that change while the plan runs, as `node.parameter`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub dynamic: Vec<String>,
    /// The size of the frame.
    pub size: Size,
    /// The switches it was made with.
    pub options: Options,
}

/// A host block and where it lies in the one uniform buffer of a plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedBlock {
    /// Its input in the graph.
    pub id: BlockId,
    /// The name of the input.
    pub name: String,
    #[serde(serialize_with = "type_of")]
    pub block: &'static HostBlock,
    /// Its offset in the buffer.
    pub offset: u64,
}

fn type_of<S: Serializer>(block: &&HostBlock, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(block.name)
}

/// An image that the host gets.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlanOutput {
    pub name: String,
    pub image: ImageId,
    /// The color state of the output's wire in the graph.
    pub state: ColorState,
    /// The colorimetry of the image that is written, also if nodes are skipped.
    pub colorimetry: Colorimetry,
    /// True if it goes into a rectangle of the host's image, which frames state: the uniforms of its passes have the
    /// first texel behind the [`extent`](UniformBlock::extent).
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub in_rectangle: bool,
}

/// An input of which frames state a rectangle and a factor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RectangleInput {
    /// The name of the input.
    pub name: String,
    /// The image: its size is that of the rectangle in the plan, and not that of the host's texture.
    pub image: ImageId,
    /// The size of the rectangle.
    pub part: Part,
    /// The factor in the pipeline's file.
    pub scale: f32,
    /// Offsets of its [uniform](Self::uniform) in the uniform buffer of the plan.
    pub places: Vec<u64>,
}

impl PlanOutput {
    /// An output that the planner adds for measurements.
    pub(crate) fn of_data(name: String, image: ImageId) -> Self {
        let ImageColor { state, colorimetry } = ImageColor::of(ColorState::Data);
        Self { name, image, state, colorimetry, in_rectangle: false }
    }
}

impl Plan {
    /// The output of that name; the first if `None`.
    pub fn output(&self, name: Option<&str>) -> Option<&PlanOutput> {
        match name {
            Some(name) => self.outputs.iter().find(|output| output.name == name),
            None => self.outputs.first(),
        }
    }

    pub fn image(&self, id: ImageId) -> &PlannedImage {
        &self.images[id.0 as usize]
    }

    /// The host block with that id.
    ///
    /// # Panics
    /// If no pass reads it.
    pub fn block(&self, id: BlockId) -> &PlannedBlock {
        self.blocks.iter().find(|planned| planned.id == id).expect("a plan lists the blocks that its passes read")
    }

    /// Offsets in the uniform buffer of the first texel of an output in a rectangle.
    pub fn origin_places(&self, output: &PlanOutput) -> impl Iterator<Item = u64> {
        let writers = self.passes.iter().filter(|planned| planned.pass.function_result() == Some(output.image));
        writers.map(|planned| planned.uniform.extent_offset + size_of::<[f32; 2]>() as u64)
    }

    /// Returns whether a pass writes an output in a rectangle.
    pub(crate) fn has_origin(&self, pass: &Pass) -> bool {
        let mut outputs = self.outputs.iter().filter(|output| output.in_rectangle);
        outputs.any(|output| pass.function_result() == Some(output.image))
    }

    /// The name of each image: its label, with `#2` and so on after it where several have the same.
    pub fn image_names(&self) -> Vec<String> {
        unique(self.images.iter().map(|image| image.label.as_str()))
    }

    /// The name of each buffer, likewise.
    pub fn buffer_names(&self) -> Vec<String> {
        unique(self.buffers.iter().map(|buffer| buffer.label.as_str()))
    }

    /// The name of each pass: its node and what it does, made unique likewise.
    pub fn pass_names(&self) -> Vec<String> {
        let names: Vec<String> = self.work().map(|pass| format!("{}: {}", pass.nodes.join("+"), pass.label)).collect();
        unique(names.iter().map(String::as_str))
    }

    /// The passes as they were recorded and fused, in the order of execution.
    pub fn work(&self) -> impl Iterator<Item = &Pass> {
        self.passes.iter().map(|planned| &planned.pass)
    }

    /// Bytes that all passes read and write in one frame, each image once a pass, savings by
    /// caches of the device are not counted. A pass that does not run in every frame counts by its share.
    pub fn bytes_moved(&self) -> u64 {
        let of_pass = |pass: usize| {
            let (share, bytes) = (self.share_of_frames(pass), self.bytes_moved_by(pass));
            if share < 1.0 { (share * bytes as f64) as u64 } else { bytes }
        };
        (0..self.passes.len()).map(of_pass).sum()
    }

    /// Bytes that one pass reads and writes: of images with a stride those of its pixels.
    pub fn bytes_moved_by(&self, pass: usize) -> u64 {
        let pass = &self.passes[pass].pass;
        let bytes = |resource: Resource| resource.image().map_or(0, |image| self.image(image).desc.bytes());
        let stride = u64::from(pass.kernels.iter().map(|kernel| kernel.stride).min().unwrap_or(1));
        let read: u64 = pass.reads().into_iter().map(bytes).sum();
        read / (stride * stride) + pass.writes().into_iter().map(bytes).sum::<u64>()
    }
}
