//! Graph to plan: passes, their order, the barriers between them and the memory of their images.
//!
//! [`plan()`] reads as the list of its steps.

mod barriers;
mod batches;
mod cells;
pub mod codegen;
mod contract;
mod cull;
mod diff;
mod dot;
mod fuse;
mod hash;
mod json;
mod list_scheduling;
mod memory;
mod names;
mod order;
mod pass_graph;
pub(crate) mod passes;
mod placement;
mod plan_cache;
mod print;
mod rows;
mod sanitize;
mod schedule_graph;
mod skyline;
mod specialize;
mod svg;
mod tile;
mod verify;

use std::collections::{BTreeMap, BTreeSet};

use afterimage_base::image::{ColorState, Format, ImageDesc, Size};
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::node::{ImageId, Origin, Recording};
use afterimage_wgsl::SampleMode;

pub use afterimage_base::caps::Caps;
pub use barriers::{AliasingBarrier, BatchBarriers, Transition, Use};
pub use cells::SharedRead;
pub use codegen::Ignored;
pub use contract::contract;
pub use diff::{PlanDiff, diff};
pub use fuse::Fused;
pub use hash::PlanHash;
pub use memory::{Lifetime, Memory, Requirement, Slot};
pub use plan_cache::PlanCache;
pub use specialize::Skipped;
pub use verify::{Fault, verify};

/// What a plan is made for, beside the graph: the frame, the scene and the device.
pub struct PlanRequest<'a> {
    /// The size of the frame, for nodes without an image input.
    pub size: Size,
    /// The images that the host gives, by the name of the pipeline's input.
    pub inputs: BTreeMap<String, GivenImage>,
    /// What the host says of the scene.
    pub facts: Facts,
    /// What the device can do.
    pub caps: Caps,
    /// Switches.
    pub options: Options,
    /// Bytes and alignment that the device wants for an image.
    pub requirement: &'a dyn Fn(&ImageDesc) -> Requirement,
}

/// An image that the host gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GivenImage {
    /// Size and format.
    pub desc: ImageDesc,
    /// Whether the host promises that all its numbers are finite, not negative (unless the input allows it), and at most 65504.
    pub finite: bool,
}

/// Switches of the planner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Options {
    /// Whether point kernels are fused, and kernels joined that sum up one image.
    pub fuse: bool,
    /// Whether gather kernels are chained through workgroup memory.
    pub tile: Tiles,
    /// How transient images share memory.
    pub alias: Alias,
    /// Whether each pass is a batch of its own.
    pub serial: bool,
    /// Whether every intermediate is stored in 32 bits and filtered with all of them, where a device's own filter has eight bits of fraction: the
    /// truth of `measure`.
    pub exact: bool,
    /// Whether fewest batches come before smallest memory in the choice of the order.
    pub batches_first: bool,
    /// Whether unchecked shaders too run with the driver's checks of indices and loops. Pixels are the same.
    pub bounds_checks: bool,
    /// Whether sums of weighted colours (halvings, tents, the filter of Caracal) are made in half floats, where the device has them and no image of
    /// the pass is in 32 bits. What is stored in between has 11 bits anyway; a sum of them loses about one more.
    pub half: bool,
    /// Whether sums over a workgroup (of meters and of the wide logarithmic mean) are made by operations of subgroups, where the device has them.
    /// They add in another order, so results differ by roundings of 32-bit floats.
    pub subgroups: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            fuse: true,
            tile: Tiles::WhereItPays,
            alias: Alias::Placed,
            serial: false,
            exact: false,
            batches_first: false,
            bounds_checks: false,
            half: false,
            subgroups: false,
        }
    }
}

/// Whether chains of images are made in one dispatch, through workgroup memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Tiles {
    /// Each image has a pass of its own.
    Never,
    /// Where the cost model says that it is faster, on a device that has such memory.
    WhereItPays,
    /// Wherever it is possible: for tests and measurements.
    Always,
}

/// How transient images share memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Alias {
    /// Each image has its own.
    None,
    /// Images of equal description take turns in one texture.
    Pool,
    /// All images lie in one heap, at offsets; where the backend cannot, the pool.
    Placed,
}

/// A pipeline made ready for one frame size, one set of facts and one device: a value, equal for equal inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The images, the buffers and the passes in the order of execution.
    pub recording: Recording,
    /// How each pass runs.
    pub stages: Vec<Stage>,
    /// For each pass, its place in the order of recording, which says what each read must see.
    pub recorded: Vec<usize>,
    /// How each image is read.
    pub sample_modes: Vec<SampleMode>,
    /// Passes that need no barrier between them: ranges that cover all passes in order.
    pub batches: Vec<std::ops::Range<usize>>,
    /// What must happen before each batch.
    pub barriers: Vec<BatchBarriers>,
    /// What hands the outputs to the host after the last batch.
    pub exports: Vec<Transition>,
    /// When each image lives.
    pub lifetimes: Vec<Option<Lifetime>>,
    /// Where each image lies.
    pub memory: Memory,
    /// The images that the host gives: input name and image.
    pub inputs: Vec<(String, ImageId)>,
    /// What the host gets.
    pub outputs: Vec<PlanOutput>,
    /// Nodes that are not in the plan, and why.
    pub skipped: Vec<Skipped>,
    /// Switches that have no effect here.
    pub ignored: Vec<Ignored>,
    /// Images that fusion has removed.
    pub fused: Vec<Fused>,
    /// Images that several kernels read together in one pass.
    pub shared_reads: Vec<SharedRead>,
    /// The size of the frame.
    pub size: Size,
    /// The switches it was made with.
    pub options: Options,
}

/// An image that the host gets.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanOutput {
    /// The output's name.
    pub name: String,
    /// The image.
    pub image: ImageId,
    /// What its numbers mean.
    pub state: ColorState,
}

/// How a pass runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// A dispatch.
    Compute,
    /// A full-screen triangle.
    Fragment,
}

/// Why a graph cannot be planned in this setting.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PlanError {
    /// The host does not give an image that the pipeline needs.
    MissingInput(String),
    /// An image is larger than the device allows.
    TooLarge {
        /// The image, as `node.port`.
        label: String,
        /// Its size.
        size: Size,
        /// The longest side allowed.
        limit: u32,
    },
    /// An output comes from a node that is off and has nothing to stand in for it.
    NothingToShow(String),
    /// The sizes of images that depend on the previous frame do not settle.
    UnstableHistory(String),
}

impl std::fmt::Display for PlanError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::MissingInput(name) => write!(f, "the pipeline needs an image for its input `{name}`"),
            Self::TooLarge { label, size, limit } => {
                write!(f, "image `{label}` is {size}, but this device allows at most {limit} texels a side")
            }
            Self::NothingToShow(name) => {
                write!(f, "output `{name}` comes from a node that is off, and nothing stands in for it")
            }
            Self::UnstableHistory(name) => write!(f, "the size of `{name}@previous` grows from frame to frame"),
        }
    }
}

impl std::error::Error for PlanError {}

/// Makes the plan of a graph.
pub fn plan(graph: &Graph, setting: &PlanRequest<'_>) -> Result<Plan, PlanError> {
    let special = specialize::specialize(graph, setting);
    let needed = cull::cull(graph, &special)?;
    let mut draft = passes::record(graph, setting, &special, &needed)?;
    cull::prune(&mut draft);
    sanitize::sanitize(&mut draft);
    let mut fused = if setting.options.fuse { fuse::fuse(&mut draft) } else { Vec::new() };
    let always = setting.options.tile == Tiles::Always;
    if always || setting.options.tile == Tiles::WhereItPays && setting.caps.tiles {
        fused.extend(rows::rows(&mut draft, always));
        fused.extend(tile::tile(&mut draft, &setting.caps, always));
    }
    let shared_reads = if setting.options.fuse { cells::cells(&mut draft, &setting.caps) } else { Vec::new() };
    check_sizes(&draft.recording, &setting.caps)?;
    // Stages come before memory: they may widen formats.
    let mut stages = passes::stages(&mut draft.recording, &setting.caps);
    let sample_modes = sanitize::sample_modes(&draft.recording, &setting.caps, setting.options.exact);
    let (mut options, ignored) = setting.options.granted(&setting.caps);
    if stages.contains(&Stage::Fragment) {
        // What is drawn to has layouts of its own, and images that overlap would disagree on them.
        options.alias = options.alias.min(Alias::Pool);
    }
    let requirements = memory::requirements(&draft, setting);
    let order::Order { recorded, batches } = order::order(&mut draft, &mut stages, &requirements, &setting.options);
    let lifetimes = memory::lifetimes(&draft, &batches);
    let memory = memory::place(&draft, &lifetimes, requirements, &fused, setting);
    let (mut barriers, exports) = barriers::barriers(&draft.recording, &stages, &batches, &draft.outputs);
    barriers::hand_over(&mut barriers, &memory, &lifetimes, options.alias);
    let mut skipped = special.skipped;
    skipped.extend(needed.skipped);
    Ok(Plan {
        recording: draft.recording,
        stages,
        recorded,
        sample_modes,
        batches,
        barriers,
        exports,
        lifetimes,
        memory,
        inputs: draft.inputs,
        outputs: draft.outputs,
        skipped,
        ignored,
        fused,
        shared_reads,
        size: setting.size,
        options,
    })
}

/// A plan in the making.
pub(crate) struct PlanBuilder {
    pub(crate) recording: Recording,
    pub(crate) inputs: Vec<(String, ImageId)>,
    pub(crate) outputs: Vec<PlanOutput>,
}

impl PlanBuilder {
    /// The images that outlive the frame or leave it.
    pub(crate) fn kept(&self) -> BTreeSet<ImageId> {
        let outputs = self.outputs.iter().map(|output| output.image);
        let remembered = self.recording.images.iter().filter_map(|image| match image.origin {
            Origin::Previous { of, .. } => Some(of),
            _ => None,
        });
        outputs.chain(remembered).collect()
    }

    /// Images that outlive the frame or leave it: nothing may be removed from under them.
    pub(crate) fn is_kept(&self, image: ImageId) -> bool {
        let previous =
            |v: &afterimage_graph::node::VirtualImage| matches!(v.origin, Origin::Previous { of, .. } if of == image);
        self.outputs.iter().any(|o| o.image == image) || self.recording.images.iter().any(previous)
    }
}

fn check_sizes(recording: &Recording, caps: &Caps) -> Result<(), PlanError> {
    for image in &recording.images {
        let ImageDesc { size, volume, .. } = image.desc;
        let limit = if volume { caps.max_volume_side } else { caps.max_side };
        if size.width.max(size.height).max(size.depth) > limit {
            return Err(PlanError::TooLarge { label: image.label.clone(), size, limit });
        }
    }
    Ok(())
}

impl Plan {
    /// The output of that name; the first if `None`.
    pub fn output(&self, name: Option<&str>) -> Option<&PlanOutput> {
        match name {
            Some(name) => self.outputs.iter().find(|output| output.name == name),
            None => self.outputs.first(),
        }
    }

    /// The format of an image.
    pub fn format(&self, image: ImageId) -> Format {
        self.recording.image(image).desc.format
    }
}
