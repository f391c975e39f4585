//! Passes as data: what nodes record and what plans are made of.

use std::sync::Arc;

use afterimage_base::Shared;
use afterimage_base::image::ImageDesc;
use afterimage_wgsl::Shader;

/// A virtual image of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ImageId(pub u32);

/// A virtual buffer of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BufferId(pub u32);

/// An image or a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Resource {
    /// An image.
    Image(ImageId),
    /// A buffer.
    Buffer(BufferId),
}

/// Where an image comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Origin {
    /// Made and used within one frame; its memory is shared with others.
    Transient,
    /// Given by the host under this name.
    Input(String),
    /// Filled once, when the plan is set up.
    Constant(Arc<[u8]>),
    /// What `of` held so many frames ago.
    Previous {
        /// The image that is written in each frame.
        of: ImageId,
        /// How many frames ago.
        frames: u32,
    },
}

/// A virtual image: a description, and how it lives.
#[derive(Clone, Debug, PartialEq)]
pub struct VirtualImage {
    /// `node.port`, for people.
    pub label: String,
    /// Size and format.
    pub desc: ImageDesc,
    /// Where it comes from.
    pub origin: Origin,
    /// Whether all its numbers are known to be finite and within half range.
    pub finite: bool,
    /// Whether negative numbers are meant (data), not noise.
    pub signed: bool,
}

/// A virtual buffer.
#[derive(Clone, Debug, PartialEq)]
pub struct VirtualBuffer {
    /// `node.name`, for people.
    pub label: String,
    /// Its size.
    pub bytes: u64,
    /// How it lives.
    pub life: BufferLife,
}

/// How a buffer lives.
#[derive(Clone, Debug, PartialEq)]
pub enum BufferLife {
    /// Written before it is read in every frame.
    Frame,
    /// All zero at the start of every frame.
    Zeroed,
    /// Keeps its contents from frame to frame; all zero at first and after a reset.
    Persistent,
    /// Filled once, when the plan is set up.
    Constant(Arc<[u8]>),
}

/// One dispatch or draw.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// The nodes it works for; more than one after fusion.
    pub nodes: Vec<String>,
    /// What it does, for people.
    pub label: String,
    /// What runs.
    pub work: Work,
}

/// What a pass runs.
#[derive(Clone, Debug, PartialEq)]
pub enum Work {
    /// Kernel functions, each feeding the next, the last one's value written to an image: the framework writes the entry point.
    Steps {
        /// The functions.
        steps: Vec<Step>,
        /// The image that takes the last one's value.
        result: ImageId,
    },
    /// Several images in one dispatch, each made from the one before in workgroup memory: the framework writes the entry point.
    Tiled(Tiling),
    /// An image at half the size of its source, row by row: the framework writes the entry point.
    Rows(Rows),
    /// Several whole kernels that sum up one image cell by cell: the framework writes the entry point.
    Cells(Cells),
    /// A whole compute entry point.
    Entry(EntryCall),
}

/// A chain of images that one dispatch makes, tile by tile.
///
/// A workgroup makes one tile of the last image. Of each image before it, it makes as much as the next one reads, keeps that in workgroup
/// memory, and stores its own share where somebody else reads the image.
#[derive(Clone, Debug, PartialEq)]
pub struct Tiling {
    /// The images, first to last.
    pub stages: Vec<TileStage>,
    /// Texels of the last image that a workgroup makes, each way.
    pub tile: u32,
    /// Whether workgroup memory holds half floats.
    pub halves: bool,
}

/// One image of a [`Tiling`].
#[derive(Clone, Debug, PartialEq)]
pub struct TileStage {
    /// What makes a texel; [`Arg::Tile`] is the image before.
    pub steps: Vec<Step>,
    /// The whole image's size.
    pub size: crate::image::Size,
    /// Texels that a workgroup makes, across and down.
    pub extent: [u32; 2],
    /// How far the next image reads from its own place, in texels of this one.
    pub reach: f32,
    /// Where the image is stored, if anybody else reads it.
    pub result: Option<ImageId>,
}

/// A halving by workgroups of one row of invocations that walk down the source.
///
/// At each step an invocation makes the four texels under one texel of the result, and hands what its neighbours need through workgroup
/// memory; so each texel of the source is made about once, and never stored.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    /// What makes a texel of the source, which is exactly twice as large as the result.
    pub source: Vec<Step>,
    /// What makes a texel of the result.
    pub by: ByRows,
    /// The result.
    pub result: ImageId,
    /// Rows of the result that a workgroup makes.
    pub rows: u32,
}

/// The form by rows of a function that halves an image.
///
/// It is called by all invocations of the workgroup, once for the row above its first and then for each row and the one below its last, with
/// the texels under one texel of that row; the result of a call is the texel of the row before. It may wait for the others
/// (`workgroupBarrier`), and takes no parameters:
/// `fn name(state: ptr<function, ColorState>, square: Square, lane: u32) -> vec4f`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByRows {
    /// The module.
    pub shader: &'static Shader,
    /// The function's name.
    pub function: &'static str,
    /// The struct in which an invocation keeps what it needs of the rows before, all zero at first.
    pub state: &'static str,
}

/// Whole kernels that sum up one image cell by cell, each on a lattice of its own, and see every pixel in one dispatch.
///
/// A workgroup makes one cell of the coarsest lattice. Its invocations are shared out evenly among the cells of the finest lattice in it, and
/// walk over the pixels that touch their cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    /// The image that all of them read.
    pub source: ImageId,
    /// The kernels.
    pub readers: Vec<CellsReader>,
    /// Cells across and down that a workgroup makes one of; each side of every lattice is a multiple of it.
    pub coarsest: [u32; 2],
    /// Cells across and down whose sides are multiples of those of every lattice.
    pub finest: [u32; 2],
    /// Invocations for one of the finest cells, across and down.
    pub lanes: [u32; 2],
    /// Every so manyth pixel of every so manyth row is looked at; the cells divide the picture that these make up.
    pub step: u32,
}

/// One of the kernels of [`Cells`].
#[derive(Clone, Debug, PartialEq)]
pub struct CellsReader {
    /// The node it works for.
    pub node: String,
    /// The kernel as it would run alone.
    pub call: EntryCall,
    /// Its form by cells.
    pub by: ByCells,
}

/// The form by cells of a whole kernel that sums up an image over each cell of a lattice: with it the framework lets several such kernels
/// read each pixel together.
///
/// The cells divide the image evenly, whatever its size, so that a pixel may lie in several. The module imports `cells`, which has the structs
/// `Cell` and `Seen`, keeps each binding on a line of its own, and gives no name of its own or of a binding to anything else. It has three
/// functions, which all invocations of a workgroup call, at most 256:
///
/// - `fn FORM_begin(cell: Cell) -> ColorState` before the first pixel, to clear the cell's workgroup memory; a barrier follows;
/// - `fn FORM_visit(state: ptr<function, ColorState>, cell: Cell, seen: Seen)` for each pixel that the invocation sees, where it must not wait for
///   others. A pixel is seen once for each of the finest cells that it touches: shares of it add up to its area, and in one it is `centred`;
/// - `fn FORM_finish(state: ptr<function, ColorState>, cell: Cell)` after the last, to bring the invocations' states together and store the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ByCells {
    /// What the three functions' names begin with.
    pub form: &'static str,
    /// The variable that holds the image.
    pub source: &'static str,
    /// Cells across and down.
    pub cells: [u32; 2],
    /// The most cells that one workgroup's memory has room for.
    pub together: u32,
    /// It looks at every so manyth pixel of every so manyth row, as `stride` of the shader library has it.
    pub step: u32,
}

/// One kernel function in a pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The node it works for.
    pub node: String,
    /// The module.
    pub shader: Shared<Shader>,
    /// The function's name.
    pub function: Shared<str>,
    /// What is passed to it, in order.
    pub args: Vec<Arg>,
    /// Bytes of its `params`; empty if it has none.
    pub uniform: Vec<u8>,
    /// How far it reads its texture from its own place, in texels; `None` where that is not known.
    pub reach: Option<f32>,
    /// Constants of the module that hold here: see [`FunctionPass::promise`](super::FunctionPass::promise).
    pub promises: Vec<&'static str>,
    /// Its form by rows, if it has one.
    pub by_rows: Option<ByRows>,
}

/// What an argument of a kernel function is bound to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arg {
    /// The value of an earlier step of the same pass.
    Step(usize),
    /// This pixel of an image of the result's size.
    Pixel(ImageId),
    /// An image, read anywhere.
    Texture(ImageId),
    /// The image before in a [`Tiling`], read as far as its reach.
    Tile,
    /// The linear, clamping sampler of the argument before.
    Sampler,
    /// The first components of a value.
    Value(BufferId, u8),
    /// Zero, with this many components.
    Zero(u8),
    /// The pixel's place.
    Point,
    /// The frame's time.
    Frame,
    /// The step's uniform.
    Params,
}

/// A whole compute entry point and what its bindings hold.
#[derive(Clone, Debug, PartialEq)]
pub struct EntryCall {
    /// The module.
    pub shader: Shared<Shader>,
    /// The entry point's name.
    pub entry: Shared<str>,
    /// What each binding holds, by the variable's name, and whether the pass writes it.
    pub bindings: Vec<Binding>,
    /// Override constants.
    pub constants: Vec<(&'static str, f64)>,
    /// Bytes of the uniform called `params`; empty if it has none.
    pub uniform: Vec<u8>,
    /// Workgroups.
    pub groups: [u32; 3],
    /// Its form by cells, if it has one.
    pub by_cells: Option<ByCells>,
}

/// What a variable of a whole kernel holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Binding {
    /// The variable's name.
    pub name: String,
    /// What it holds.
    pub resource: Resource,
    /// Whether the pass writes it.
    pub writes: bool,
    /// Whether the pass reads it.
    pub reads: bool,
}

impl Step {
    /// A function without numbers of its own, promises or other forms.
    pub fn new(
        node: &str,
        shader: impl Into<Shared<Shader>>,
        function: impl Into<Shared<str>>,
        args: Vec<Arg>,
    ) -> Self {
        let (shader, function) = (shader.into(), function.into());
        let (uniform, promises) = (Vec::new(), Vec::new());
        Self { node: node.to_owned(), shader, function, args, uniform, reach: None, promises, by_rows: None }
    }
}

impl Pass {
    /// Everything it reads, each once, in order of first mention.
    pub fn reads(&self) -> Vec<Resource> {
        let mut found = Vec::new();
        let mut add = |resource| {
            if !found.contains(&resource) {
                found.push(resource);
            }
        };
        match &self.work {
            Work::Steps { steps, .. } => resources(steps).for_each(&mut add),
            Work::Tiled(tiling) => tiling.stages.iter().flat_map(|s| resources(&s.steps)).for_each(&mut add),
            Work::Rows(rows) => resources(&rows.source).for_each(&mut add),
            Work::Cells(cells) => cells.bindings().filter(|b| b.reads).for_each(|b| add(b.resource)),
            Work::Entry(call) => call.bindings.iter().filter(|b| b.reads).for_each(|b| add(b.resource)),
        }
        found
    }

    /// Everything it writes.
    pub fn writes(&self) -> Vec<Resource> {
        match &self.work {
            Work::Steps { result, .. } => vec![Resource::Image(*result)],
            Work::Tiled(tiling) => tiling.stages.iter().filter_map(|s| s.result).map(Resource::Image).collect(),
            Work::Rows(rows) => vec![Resource::Image(rows.result)],
            Work::Cells(cells) => cells.bindings().filter(|b| b.writes).map(|b| b.resource).collect(),
            Work::Entry(call) => call.bindings.iter().filter(|b| b.writes).map(|b| b.resource).collect(),
        }
    }

    /// The modules that it is made of.
    pub fn shaders(&self) -> Vec<&Shader> {
        match &self.work {
            Work::Steps { steps, .. } => steps.iter().map(|step| &*step.shader).collect(),
            Work::Tiled(tiling) => tiling.stages.iter().flat_map(|s| &s.steps).map(|step| &*step.shader).collect(),
            Work::Rows(rows) => rows.source.iter().map(|step| &*step.shader).chain([rows.by.shader]).collect(),
            Work::Cells(cells) => cells.readers.iter().map(|reader| &*reader.call.shader).collect(),
            Work::Entry(call) => vec![&call.shader],
        }
    }

    /// Its override constants.
    pub fn constants(&self) -> &[(&'static str, f64)] {
        match &self.work {
            Work::Entry(call) => &call.constants,
            Work::Steps { .. } | Work::Tiled(_) | Work::Rows(_) | Work::Cells(_) => &[],
        }
    }
}

impl Cells {
    /// Invocations of a workgroup.
    pub fn workgroup(&self) -> u32 {
        let inside = [0, 1].map(|axis| self.finest[axis] / self.coarsest[axis]);
        self.lanes[0] * self.lanes[1] * inside[0] * inside[1]
    }

    /// What the bindings of all readers hold.
    fn bindings(&self) -> impl Iterator<Item = &Binding> {
        self.readers.iter().flat_map(|reader| &reader.call.bindings)
    }
}

fn resources(steps: &[Step]) -> impl Iterator<Item = Resource> + '_ {
    steps.iter().flat_map(|step| &step.args).filter_map(|arg| arg.resource())
}

impl Arg {
    /// The resource it reads, if any.
    pub fn resource(self) -> Option<Resource> {
        match self {
            Self::Pixel(image) | Self::Texture(image) => Some(Resource::Image(image)),
            Self::Value(buffer, _) => Some(Resource::Buffer(buffer)),
            _ => None,
        }
    }
}
