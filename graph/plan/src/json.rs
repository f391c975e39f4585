//! Plans as canonical JSON: keys in alphabetical order, lists in the order of the plan, no number that depends on the
//! machine.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::hash::fnv1a;
use crate::names::Names;
use crate::{AliasingBarrier, Options, Plan, Transition};
use afterimage_base::image::ImageDesc;
use afterimage_graph::node::{Arg, BufferLife, ByRows, EntryCall, Origin, Resource, Step, Work};

impl Plan {
    /// The whole plan as indented JSON: the canonical content and its hash.
    pub fn to_json(&self) -> String {
        let names = Names::new(self);
        let content = Content { hash: Some(self.hash().to_string()), ..Content::new(self, &names) };
        serde_json::to_string_pretty(&content).expect("names and numbers can always be written as JSON")
    }

    /// What the hash is taken of.
    pub(crate) fn canonical(&self) -> String {
        let names = Names::new(self);
        serde_json::to_string(&Content::new(self, &names)).expect("names and numbers can always be written as JSON")
    }
}

#[derive(Serialize)]
struct Content<'a> {
    barriers: Vec<BarriersView<'a>>,
    batches: Vec<Vec<usize>>,
    buffers: Vec<BufferView<'a>>,
    exports: Vec<TransitionView<'a>>,
    fused: Vec<FusedView<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hash: Option<String>,
    ignored: Vec<IgnoredView>,
    images: Vec<ImageView<'a>>,
    memory: MemoryView,
    options: OptionsView,
    outputs: Vec<OutputView<'a>>,
    passes: Vec<PassView<'a>>,
    shared_reads: Vec<FusedView<'a>>,
    size: [u32; 2],
    skipped: Vec<LeftOutView<'a>>,
}

#[derive(Serialize)]
struct BarriersView<'a> {
    aliasing: Vec<HandOverView<'a>>,
    transitions: Vec<TransitionView<'a>>,
}

#[derive(Serialize)]
struct HandOverView<'a> {
    image: &'a str,
    residents: Vec<&'a str>,
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
    reading: String,
    required: Option<u64>,
    size: String,
    slot: Option<u32>,
    volume: bool,
}

#[derive(Serialize)]
struct LeftOutView<'a> {
    node: &'a str,
    why: &'a str,
}

#[derive(Serialize)]
struct MemoryView {
    heap: u64,
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
    serial: bool,
    subgroups: bool,
    tile: String,
}

#[derive(Serialize)]
struct OutputView<'a> {
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
struct KernelView<'a> {
    arguments: Vec<String>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    constants: BTreeMap<&'static str, f64>,
    function: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    groups: Option<[u32; 3]>,
    node: &'a str,
    shader: &'a str,
}

impl<'a> Content<'a> {
    fn new(plan: &'a Plan, names: &'a Names) -> Self {
        Self {
            barriers: barriers(plan, names),
            buffers: buffers(plan, names),
            exports: transitions(&plan.exports, names),
            fused: plan.fused.iter().map(FusedView::from).collect(),
            hash: None,
            images: (0..names.images.len()).map(|image| ImageView::new(plan, names, image)).collect(),
            ignored: plan.ignored.iter().map(|i| IgnoredView { switch: i.switch, why: i.why }).collect(),
            skipped: plan.skipped.iter().map(|left| LeftOutView { node: &left.node, why: &left.why }).collect(),
            memory: MemoryView::new(plan),
            options: OptionsView::new(&plan.options),
            outputs: outputs(plan, names),
            passes: passes(plan, names),
            shared_reads: plan.shared_reads.iter().map(FusedView::from).collect(),
            size: [plan.size.width, plan.size.height],
            batches: plan.batches.iter().map(|batch| batch.clone().collect()).collect(),
        }
    }
}

fn barriers<'a>(plan: &'a Plan, names: &'a Names) -> Vec<BarriersView<'a>> {
    let hand_over = |hand_over: &AliasingBarrier| HandOverView {
        image: names.of(Resource::Image(hand_over.image)),
        residents: hand_over.residents.iter().map(|image| names.of(Resource::Image(*image))).collect(),
    };
    let batches = plan.barriers.iter().map(|batch| BarriersView {
        aliasing: batch.aliasing.iter().map(hand_over).collect(),
        transitions: transitions(&batch.transitions, names),
    });
    batches.collect()
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
    let named = plan.recording.buffers.iter().zip(&names.buffers);
    named.map(|(buffer, name)| BufferView { bytes: buffer.bytes, life: life(&buffer.life), name }).collect()
}

/// Constants are part of the plan by their contents.
fn constant(bytes: &[u8]) -> String {
    format!("constant {:032x}", fnv1a(bytes))
}

fn outputs<'a>(plan: &'a Plan, names: &'a Names) -> Vec<OutputView<'a>> {
    let view = |output: &'a crate::PlanOutput| OutputView {
        image: names.of(Resource::Image(output.image)),
        name: &output.name,
        state: output.state.name(),
    };
    plan.outputs.iter().map(view).collect()
}

fn passes<'a>(plan: &'a Plan, names: &'a Names) -> Vec<PassView<'a>> {
    let with_waves =
        plan.batches.iter().enumerate().flat_map(|(batch, passes)| passes.clone().map(move |pass| (batch, pass)));
    with_waves.map(|(batch, pass)| PassView::new(plan, names, batch, pass)).collect()
}

impl<'a> From<&'a crate::Fused> for FusedView<'a> {
    fn from(fused: &'a crate::Fused) -> Self {
        Self { bytes_saved: fused.bytes_saved, image: &fused.image, nodes: &fused.nodes }
    }
}

impl<'a> From<&'a crate::SharedRead> for FusedView<'a> {
    fn from(read: &'a crate::SharedRead) -> Self {
        Self { bytes_saved: read.bytes_saved, image: &read.image, nodes: &read.nodes }
    }
}

impl<'a> ImageView<'a> {
    fn new(plan: &Plan, names: &'a Names, at: usize) -> Self {
        let image = &plan.recording.images[at];
        let ImageDesc { size, format, volume } = image.desc;
        let origin = match &image.origin {
            Origin::Transient => "transient".to_owned(),
            Origin::Input(name) => format!("input {name}"),
            Origin::Constant(bytes) => constant(bytes),
            Origin::Previous { of, frames } => format!("{} {frames} frames ago", names.images[of.0 as usize]),
        };
        Self {
            bytes: image.desc.bytes(),
            format: format.name(),
            lives: plan.lifetimes[at].map(|lifetime| [lifetime.first, lifetime.last]),
            name: &names.images[at],
            offset: plan.memory.offset_of[at],
            origin,
            reading: format!("{:?}", plan.sample_modes[at]),
            required: plan.memory.requirement_of[at].map(|requirement| requirement.bytes),
            size: size.to_string(),
            slot: plan.memory.slot_of[at],
            volume,
        }
    }
}

impl MemoryView {
    fn new(plan: &Plan) -> Self {
        let memory = &plan.memory;
        Self {
            heap: memory.heap,
            kept: memory.kept,
            lower_bound: memory.lower_bound,
            placed: memory.placed,
            pooled: memory.pooled,
            unaliased: memory.unaliased,
            unshared: memory.unshared,
        }
    }
}

impl OptionsView {
    fn new(options: &Options) -> Self {
        let Options { fuse, tile, alias, serial, exact, batches_first, bounds_checks, half, subgroups } = *options;
        let (alias, tile) = (format!("{alias:?}"), format!("{tile:?}"));
        Self { alias, exact, fuse, serial, tile, batches_first, bounds_checks, half, subgroups }
    }
}

impl<'a> PassView<'a> {
    fn new(plan: &'a Plan, names: &'a Names, batch: usize, at: usize) -> Self {
        let pass = &plan.recording.passes[at];
        let target = pass.writes().into_iter().find_map(|resource| match resource {
            Resource::Image(image) => Some(plan.recording.image(image).desc),
            Resource::Buffer(_) => None,
        });
        let named = |resources: Vec<Resource>| resources.into_iter().map(|resource| names.of(resource)).collect();
        Self {
            bytes_moved: plan.bytes_moved_by(at),
            format: target.map(|desc| desc.format.name()),
            label: &pass.label,
            nodes: &pass.nodes,
            reads: named(pass.reads()),
            runs: match &pass.work {
                Work::Steps { steps, .. } => steps.iter().map(|step| KernelView::of_step(step, names)).collect(),
                Work::Tiled(tiling) => {
                    let steps = tiling.stages.iter().flat_map(|stage| &stage.steps);
                    steps.map(|step| KernelView::of_step(step, names)).collect()
                }
                Work::Rows(rows) => {
                    let source = rows.source.iter().map(|step| KernelView::of_step(step, names));
                    source.chain([KernelView::by_rows(&rows.by, &pass.nodes)]).collect()
                }
                Work::Cells(cells) => {
                    let groups = [cells.coarsest[0], cells.coarsest[1], 1];
                    let readers = cells.readers.iter();
                    readers.map(|reader| KernelView::of_entry(&reader.call, groups, &reader.node, names)).collect()
                }
                Work::Entry(call) => {
                    let node = pass.nodes.first().map_or("", String::as_str);
                    vec![KernelView::of_entry(call, call.groups, node, names)]
                }
            },
            size: target.map(|desc| desc.size.to_string()),
            stage: format!("{:?}", plan.stages[at]),
            batch,
            writes: named(pass.writes()),
        }
    }
}

impl<'a> KernelView<'a> {
    fn of_step(step: &'a Step, names: &Names) -> Self {
        Self {
            arguments: step.args.iter().map(|arg| argument(*arg, names)).collect(),
            constants: BTreeMap::new(),
            function: &step.function,
            groups: None,
            node: &step.node,
            shader: step.shader.file(),
        }
    }

    fn by_rows(by: &ByRows, nodes: &'a [String]) -> Self {
        Self {
            arguments: vec!["texels of the source".into()],
            constants: BTreeMap::new(),
            function: by.function,
            groups: None,
            node: nodes.last().map_or("", String::as_str),
            shader: by.shader.file(),
        }
    }

    fn of_entry(call: &'a EntryCall, groups: [u32; 3], node: &'a str, names: &Names) -> Self {
        let binding = |b: &afterimage_graph::node::Binding| format!("{} = {}", b.name, names.of(b.resource));
        Self {
            arguments: call.bindings.iter().map(binding).collect(),
            constants: call.constants.iter().copied().collect(),
            function: &call.entry,
            groups: Some(groups),
            node,
            shader: call.shader.file(),
        }
    }
}

fn argument(arg: Arg, names: &Names) -> String {
    match arg {
        Arg::Step(step) => format!("step {step}"),
        Arg::Tile => "tile of the image before".into(),
        Arg::Pixel(image) => format!("pixel of {}", names.of(Resource::Image(image))),
        Arg::Texture(image) => format!("texture {}", names.of(Resource::Image(image))),
        Arg::Value(buffer, components) => format!("{components} of {}", names.of(Resource::Buffer(buffer))),
        Arg::Zero(components) => format!("zero {components}"),
        Arg::Sampler => "sampler".to_owned(),
        Arg::Point => "point".to_owned(),
        Arg::Frame => "frame".to_owned(),
        Arg::Params => "params".to_owned(),
    }
}
