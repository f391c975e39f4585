//! The content of a plan, as JSON shows it and as the hash is taken of it. Keys are in alphabetical order.

use serde::Serialize;

use super::colorimetry::ColorimetryView;
use super::fnv::fnv1a;
use super::kernels::KernelView;
use super::names::Names;
use crate::options::Options;
use crate::plan::{AliasingBarrier, Batch, Fused, Memory, Plan, PlanOutput, PlannedPass, SharedRead, Transition};
use afterimage_base::image::ImageDesc;
use afterimage_graph::node::{BufferLife, ImageId, Origin, Resource};

/// The content of a plan as one line of JSON without its hash.
pub(super) fn canonical(plan: &Plan) -> String {
    let names = Names::new(plan);
    serde_json::to_string(&Content::new(plan, &names)).expect("names and numbers can always be written as JSON")
}

#[derive(Serialize)]
pub(super) struct Content<'a> {
    barriers: Vec<BarriersView<'a>>,
    batches: Vec<Vec<usize>>,
    buffers: Vec<BufferView<'a>>,
    exports: Vec<TransitionView<'a>>,
    fused: Vec<FusedView<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) hash: Option<String>,
    ignored: Vec<IgnoredView>,
    images: Vec<ImageView<'a>>,
    memory: MemoryView,
    options: OptionsView,
    outputs: Vec<OutputView<'a>>,
    passes: Vec<PassView<'a>>,
    shared_reads: Vec<FusedView<'a>>,
    size: [u32; 2],
    skipped: Vec<SkippedView<'a>>,
}

#[derive(Serialize)]
struct BarriersView<'a> {
    aliasing: Vec<AliasingView<'a>>,
    transitions: Vec<TransitionView<'a>>,
}

#[derive(Serialize)]
struct AliasingView<'a> {
    image: &'a str,
    owners: Vec<&'a str>,
}

#[derive(Serialize)]
struct TransitionView<'a> {
    from: &'static str,
    resource: &'a str,
    to: &'static str,
}

#[derive(Serialize)]
struct BufferView<'a> {
    bytes: u64,
    life: String,
    name: &'a str,
}

#[derive(Serialize)]
struct FusedView<'a> {
    bytes_saved: u64,
    image: &'a str,
    nodes: &'a [String],
}

#[derive(Serialize)]
struct IgnoredView {
    switch: &'static str,
    why: &'static str,
}

#[derive(Serialize)]
struct ImageView<'a> {
    bytes: u64,
    format: &'static str,
    /// The first and the last batch; the number of batches for what leaves the frame.
    lives: Option<[usize; 2]>,
    name: &'a str,
    offset: Option<u64>,
    origin: String,
    required: Option<u64>,
    sample_mode: String,
    size: String,
    slot: Option<u32>,
    volume: bool,
}

#[derive(Serialize)]
struct MemoryView {
    kept: u64,
    lower_bound: u64,
    placed: u64,
    pooled: u64,
    unaliased: u64,
    unshared: u64,
}

#[derive(Serialize)]
struct OptionsView {
    alias: String,
    batches_first: bool,
    bounds_checks: bool,
    exact: bool,
    fuse: bool,
    half: bool,
    row_downsample: String,
    serial: bool,
    subgroups: bool,
    tile: String,
}

#[derive(Serialize)]
struct OutputView<'a> {
    colorimetry: ColorimetryView,
    image: &'a str,
    name: &'a str,
    state: &'static str,
}

#[derive(Serialize)]
struct PassView<'a> {
    batch: usize,
    bytes_moved: u64,
    format: Option<&'static str>,
    label: &'a str,
    nodes: &'a [String],
    reads: Vec<&'a str>,
    runs: Vec<KernelView<'a>>,
    size: Option<String>,
    stage: String,
    writes: Vec<&'a str>,
}

#[derive(Serialize)]
struct SkippedView<'a> {
    node: &'a str,
    why: &'a str,
}

impl<'a> Content<'a> {
    pub(super) fn new(plan: &'a Plan, names: &'a Names) -> Self {
        Self {
            barriers: plan.batches.iter().map(|batch| BarriersView::new(batch, names)).collect(),
            batches: plan.batches.iter().map(|batch| batch.passes.clone().collect()).collect(),
            buffers: buffers(plan, names),
            exports: transitions(&plan.exports, names),
            fused: plan.fused.iter().map(FusedView::from).collect(),
            hash: None,
            ignored: plan.ignored.iter().map(|i| IgnoredView { switch: i.switch, why: i.why }).collect(),
            images: (0..plan.images.len()).map(|image| ImageView::new(plan, names, image)).collect(),
            memory: MemoryView::from(&plan.memory),
            options: OptionsView::from(plan.options),
            outputs: plan.outputs.iter().map(|output| OutputView::new(output, names)).collect(),
            passes: passes(plan, names),
            shared_reads: plan.shared_reads.iter().map(FusedView::from).collect(),
            size: [plan.size.width, plan.size.height],
            skipped: plan.skipped.iter().map(|left| SkippedView { node: &left.node, why: &left.why }).collect(),
        }
    }
}

impl<'a> BarriersView<'a> {
    fn new(batch: &Batch, names: &'a Names) -> Self {
        let aliasing = |barrier: &AliasingBarrier| AliasingView {
            image: names.image(barrier.image),
            owners: barrier.owners.iter().map(|image| names.image(*image)).collect(),
        };
        let transitions = transitions(&batch.transitions, names);
        Self { aliasing: batch.aliasing.iter().map(aliasing).collect(), transitions }
    }
}

fn transitions<'a>(transitions: &[Transition], names: &'a Names) -> Vec<TransitionView<'a>> {
    let view = |t: &Transition| TransitionView { from: t.from.name(), resource: names.of(t.resource), to: t.to.name() };
    transitions.iter().map(view).collect()
}

fn buffers<'a>(plan: &Plan, names: &'a Names) -> Vec<BufferView<'a>> {
    let life = |life: &BufferLife| match life {
        BufferLife::Frame => "frame".to_owned(),
        BufferLife::Zeroed => "zeroed".to_owned(),
        BufferLife::Persistent => "persistent".to_owned(),
        BufferLife::Constant(bytes) => constant(bytes),
    };
    let named = plan.buffers.iter().zip(names.buffers());
    named.map(|(buffer, name)| BufferView { bytes: buffer.bytes, life: life(&buffer.life), name }).collect()
}

/// Constants are part of the plan by their contents.
fn constant(bytes: &[u8]) -> String {
    format!("constant {:032x}", fnv1a(bytes))
}

fn passes<'a>(plan: &'a Plan, names: &'a Names) -> Vec<PassView<'a>> {
    let in_batch = |(number, batch): (usize, &'a Batch)| {
        batch.passes.clone().map(move |pass| PassView::new(plan, names, number, pass))
    };
    plan.batches.iter().enumerate().flat_map(in_batch).collect()
}

impl<'a> From<&'a Fused> for FusedView<'a> {
    fn from(fused: &'a Fused) -> Self {
        Self { bytes_saved: fused.bytes_saved, image: &fused.image, nodes: &fused.nodes }
    }
}

impl<'a> From<&'a SharedRead> for FusedView<'a> {
    fn from(read: &'a SharedRead) -> Self {
        Self { bytes_saved: read.bytes_saved, image: &read.image, nodes: &read.nodes }
    }
}

impl<'a> OutputView<'a> {
    fn new(output: &'a PlanOutput, names: &'a Names) -> Self {
        Self {
            colorimetry: output.colorimetry.into(),
            image: names.image(output.image),
            name: &output.name,
            state: output.state.name(),
        }
    }
}

impl<'a> ImageView<'a> {
    fn new(plan: &Plan, names: &'a Names, at: usize) -> Self {
        let image = &plan.images[at];
        let ImageDesc { size, format, volume } = image.desc;
        let origin = match &image.origin {
            Origin::Transient => "transient".to_owned(),
            Origin::Input(name) => format!("input {name}"),
            Origin::Constant(bytes) => constant(bytes),
            Origin::Previous { of, frames } => format!("{} {frames} frames ago", names.image(*of)),
        };
        Self {
            bytes: image.desc.bytes(),
            format: format.name(),
            lives: image.lifetime.map(|lifetime| [lifetime.first, lifetime.last]),
            name: names.image(ImageId(at as u32)),
            offset: image.offset,
            origin,
            required: image.requirement.map(|requirement| requirement.bytes),
            sample_mode: format!("{:?}", image.sample_mode),
            size: size.to_string(),
            slot: image.slot,
            volume,
        }
    }
}

impl From<&Memory> for MemoryView {
    fn from(memory: &Memory) -> Self {
        let Memory { placed, unaliased, unshared, pooled, lower_bound, kept, slots: _ } = *memory;
        Self { kept, lower_bound, placed, pooled, unaliased, unshared }
    }
}

impl From<Options> for OptionsView {
    fn from(options: Options) -> Self {
        let Options { fuse, tile, row_downsample, alias, serial, exact, .. } = options;
        let Options { batches_first, bounds_checks, half, subgroups, .. } = options;
        let [tile, row_downsample] = [tile, row_downsample].map(|when| format!("{when:?}"));
        let alias = format!("{alias:?}");
        Self { alias, batches_first, bounds_checks, exact, fuse, half, row_downsample, serial, subgroups, tile }
    }
}

impl<'a> PassView<'a> {
    fn new(plan: &'a Plan, names: &'a Names, batch: usize, at: usize) -> Self {
        let PlannedPass { pass, stage, .. } = &plan.passes[at];
        let target = pass.written_image().map(|image| plan.image(image).desc);
        let named = |resources: Vec<Resource>| resources.into_iter().map(|resource| names.of(resource)).collect();
        Self {
            batch,
            bytes_moved: plan.bytes_moved_by(at),
            format: target.map(|desc| desc.format.name()),
            label: &pass.label,
            nodes: &pass.nodes,
            reads: named(pass.reads()),
            runs: pass.kernels.iter().map(|kernel| KernelView::new(kernel, names)).collect(),
            size: target.map(|desc| desc.size.to_string()),
            stage: format!("{stage:?}"),
            writes: named(pass.writes()),
        }
    }
}
