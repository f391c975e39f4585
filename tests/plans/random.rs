//! Random graphs of test kinds: pixel and texture kernels, pyramids, volumes, values that stay on the GPU, two outputs, histories, and
//! nodes that are switched off. A graph follows from its recipe to the bit.

use std::collections::BTreeMap;

use afterimage_graph::check::{Facts, Graph, GraphInput, GraphNode, GraphOutput, Source};
use afterimage_graph::node::{ImageId, NodeKind};
use afterimage_graph::prelude::*;
use afterimage_plan::{Caps, GivenImage, Options, Plan, PlanError, PlanRequest, Requirement, plan};
use petgraph::graph::{DiGraph, NodeIndex};

static TINT: Shader =
    Shader::new("tint", "fn tint(source: vec4f) -> vec4f { return source * vec4f(0.5, 0.75, 1.0, 1.0); }");
static LAY: Shader = Shader::new(
    "lay",
    "fn lay(base: vec4f, over: texture_2d<f32>, over_sampler: sampler, at: Point) -> vec4f {
        return mix(base, tap(over, over_sampler, at.uv), 0.25);
    }",
);
static COPY: Shader = Shader::new(
    "look",
    "fn look(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
        return 0.5 * (tap(source, source_sampler, at.uv) + tap(source, source_sampler, at.uv + vec2f(0.01, 0.02)));
    }",
);
static BAKE: Shader = Shader::new(
    "bake",
    "@group(0) @binding(0) var source: texture_2d<f32>;
    @group(0) @binding(1) var result: texture_storage_3d<rgba16float, write>;
    @compute @workgroup_size(4, 4, 4)
    fn bake(@builtin(global_invocation_id) id: vec3u) {
        let p = vec2i(id.xy) * (1 + vec2i(vec3i(id).zz));
        textureStore(result, id, texel(source, p));
    }",
);
static SLICE: Shader = Shader::new(
    "slice",
    "fn slice(base: vec4f, volume: texture_3d<f32>, volume_sampler: sampler, at: Point) -> vec4f {
        return base + 0.125 * tap3(volume, volume_sampler, vec3f(at.uv, fract(base.r)));
    }",
);
static METER: Shader = Shader::new(
    "meter",
    "@group(0) @binding(0) var source: texture_2d<f32>;
    @group(0) @binding(1) var<storage, read> before: array<vec4f>;
    @group(0) @binding(2) var<storage, read_write> sum: array<vec4f>;
    @group(0) @binding(3) var<storage, read_write> value: array<vec4f>;
    @compute @workgroup_size(1)
    fn meter_sum() { sum[0] = 0.5 * (before[0] + texel(source, vec2i(1, 1))); }
    @compute @workgroup_size(1)
    fn meter_keep() { value[0] = sum[0]; }",
);
static SCALE: Shader = Shader::new(
    "scale",
    "fn scale(source: vec4f, value: vec4f) -> vec4f { return source * (0.5 + 0.5 * fract(value)); }",
);

const ANY: OutputState = OutputState::Same("source");

/// Declares a test kind: ports, what stands in for it, and what it records.
macro_rules! kind {
    ($kind:ident, $doc:literal, [$($input:expr),*], [$($output:expr),*], $bypass:expr, $record:expr) => {
        params! {
            #[doc = $doc]
            pub struct $kind {}
        }
        impl Node for $kind {
            const INPUTS: &'static [Input] = &[$($input),*];
            const OUTPUTS: &'static [Output] = &[$($output),*];
            const FALLBACK: Fallback = $bypass;
            fn record(&self, pass: &mut Recorder<'_>) {
                let record: fn(&mut Recorder<'_>) = $record;
                record(pass)
            }
        }
    };
}

const SOURCE: Input = Input::image("source", "An image.");
const RESULT: Output = Output::image("result", ANY, "An image.");

fn sized(pass: &mut Recorder<'_>, port: &str, change: fn(Size) -> Size) -> ImageDesc {
    let image = pass.image(port);
    ImageDesc::new(change(pass.desc(image).size))
}

fn look(pass: &mut Recorder<'_>, source: ImageId, result: ImageId) {
    pass.function(&COPY, "look").read("source", source).write_to(result);
}

kind!(Tint, "Changes each pixel.", [SOURCE], [RESULT], Fallback::Input("source"), |pass| {
    let desc = sized(pass, "source", |size| size);
    pass.function(&TINT, "tint").write("result", desc);
});
kind!(
    Lay,
    "Lays one image over another.",
    [Input::image("base", "An image."), Input::image("over", "An image.")],
    [Output::image("result", OutputState::Same("base"), "An image.")],
    Fallback::Input("base"),
    |pass| {
        let over = pass.image("over");
        let desc = sized(pass, "base", |size| size);
        pass.function(&LAY, "lay").read("over", over).write("result", desc);
    }
);
kind!(Blur, "Two passes with an image between.", [SOURCE], [RESULT], Fallback::Input("source"), |pass| {
    let (source, desc) = (pass.image("source"), sized(pass, "source", |size| size));
    let between = pass.transient("between", desc);
    look(pass, source, between);
    let result = pass.output("result", desc);
    look(pass, between, result);
});
kind!(Shrink, "Half the size.", [SOURCE], [RESULT], Fallback::Zero, |pass| {
    let (source, desc) = (pass.image("source"), sized(pass, "source", Size::half));
    let result = pass.output("result", desc);
    look(pass, source, result);
});
kind!(
    Grow,
    "The size of another image.",
    [SOURCE, Input::image("like", "An image.")],
    [Output::image("result", ANY, "An image.")],
    Fallback::Input("like"),
    |pass| {
        let (source, desc) = (pass.image("source"), sized(pass, "like", |size| size));
        let result = pass.output("result", desc);
        look(pass, source, result);
    }
);
kind!(
    Levels,
    "A pyramid.",
    [SOURCE],
    [Output::new("result", PortType::Pyramid, ANY, "Levels.")],
    Fallback::Zero,
    |pass| {
        let (mut above, mut desc) = (pass.image("source"), sized(pass, "source", |size| size));
        let mut levels = Vec::new();
        for index in 0..desc.size.levels().clamp(1, 6) {
            desc = desc.half();
            let level = pass.level(&format!("result.{index}"), desc);
            look(pass, above, level);
            levels.push(level);
            above = level;
        }
        pass.give("result", Arrival::Pyramid(levels));
    }
);
kind!(
    Join,
    "Joins a pyramid from its coarsest level up.",
    [Input::new("source", PortType::Pyramid, "Levels.")],
    [RESULT],
    Fallback::Zero,
    |pass| {
        let levels = pass.pyramid("source");
        let (coarsest, finer) = levels.split_last().expect("a pyramid has a level");
        let mut joined = *coarsest;
        for (index, level) in finer.iter().enumerate().rev() {
            let result = pass.level(&format!("result.{index}"), ImageDesc::new(pass.desc(*level).size));
            pass.function(&LAY, "lay").read("base", *level).read("over", joined).write_to(result);
            joined = result;
        }
        pass.give("result", Arrival::Image(joined));
    }
);
kind!(
    Bake,
    "A volume.",
    [SOURCE],
    [Output::new("result", PortType::Volume, ANY, "A volume.")],
    Fallback::Absent,
    |pass| {
        let size = sized(pass, "source", |size| size.div_up(16)).size;
        let result = pass.output("result", ImageDesc::volume(Size::volume(size.width, size.height, 16)));
        let groups = size.div_up(4);
        pass.compute(&BAKE, "bake").image("result", result).dispatch([groups.width, groups.height, 4]);
    }
);
kind!(
    Slice,
    "Looks into a volume.",
    [Input::image("base", "An image."), Input::new("volume", PortType::Volume, "A volume.")],
    [Output::image("result", OutputState::Same("base"), "An image.")],
    Fallback::Input("base"),
    |pass| {
        let desc = sized(pass, "base", |size| size);
        pass.function(&SLICE, "slice").write("result", desc);
    }
);
kind!(
    Meter,
    "A value that remembers the frame before.",
    [SOURCE],
    [Output::new("value", PortType::Value, OutputState::Nothing, "A value.")],
    Fallback::Absent,
    |pass| {
        let sum = pass.add_buffer("sum", 16, BufferLife::Frame);
        let value = pass.output_value("value", BufferLife::Persistent);
        pass.compute(&METER, "meter_sum").buffer("before", value).buffer("sum", sum).dispatch([1, 1, 1]);
        pass.compute(&METER, "meter_keep").buffer("sum", sum).buffer("value", value).dispatch([1, 1, 1]);
    }
);
kind!(
    Scale,
    "Scales by a value.",
    [SOURCE, Input::new("value", PortType::Value, "A value.")],
    [RESULT],
    Fallback::Input("source"),
    |pass| {
        let desc = sized(pass, "source", |size| size);
        pass.function(&SCALE, "scale").write("result", desc);
    }
);
kind!(
    Split,
    "Two images, one of half the size.",
    [SOURCE],
    [RESULT, Output::image("small", ANY, "An image.")],
    Fallback::Zero,
    |pass| {
        let (source, desc) = (pass.image("source"), sized(pass, "source", |size| size));
        let (whole, half) = (pass.output("result", desc), pass.output("small", desc.half()));
        look(pass, source, whole);
        look(pass, source, half);
    }
);

/// How often each kind is taken.
const KINDS: [(NodeKind, u32); 12] = [
    (NodeKind::of::<Tint>(), 14),
    (NodeKind::of::<Lay>(), 24),
    (NodeKind::of::<Blur>(), 14),
    (NodeKind::of::<Shrink>(), 10),
    (NodeKind::of::<Grow>(), 12),
    (NodeKind::of::<Levels>(), 5),
    (NodeKind::of::<Join>(), 5),
    (NodeKind::of::<Bake>(), 3),
    (NodeKind::of::<Slice>(), 4),
    (NodeKind::of::<Meter>(), 3),
    (NodeKind::of::<Scale>(), 4),
    (NodeKind::of::<Split>(), 4),
];

/// What a random graph follows from.
#[derive(Clone, Copy, Debug)]
pub struct Recipe {
    pub seed: u64,
    pub nodes: usize,
    /// Wires to earlier frames.
    pub histories: usize,
    /// Per cent of the nodes that are switched off.
    pub off: u64,
}

/// SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014).
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % limit.max(1) as u64) as usize
    }

    fn per_cent(&mut self, chance: u64) -> bool {
        (self.below(100) as u64) < chance
    }
}

/// A graph in the making.
struct Growing {
    dice: Dice,
    nodes: Vec<GraphNode>,
    /// What can be wired, by type, and of that what nobody reads yet.
    made: BTreeMap<PortType, Vec<Source>>,
    unread: BTreeMap<PortType, Vec<Source>>,
}

impl Recipe {
    pub fn graph(self) -> Graph {
        let made = BTreeMap::from([(PortType::Image, vec![Source::Input(0)])]);
        let mut growing = Growing { dice: Dice::new(self.seed), nodes: Vec::new(), made, unread: BTreeMap::new() };
        while growing.nodes.len() < self.nodes.max(1) {
            growing.add_any(self.off);
        }
        growing.funnel();
        growing.add_histories(self.histories);
        growing.finish()
    }

    pub fn plan(self, options: Options) -> Result<Plan, PlanError> {
        plan_at(&self.graph(), Size::new(640, 360), options)
    }
}

/// The plan of a random graph for a frame of that size, on a device that can store every format.
pub fn plan_at(graph: &Graph, size: Size, options: Options) -> Result<Plan, PlanError> {
    plan_on(graph, size, options, Caps { storage: Format::ALL.into(), ..Caps::default() })
}

pub fn plan_on(graph: &Graph, size: Size, options: Options, caps: Caps) -> Result<Plan, PlanError> {
    let given = GivenImage { desc: ImageDesc::new(size), finite: true };
    let inputs = BTreeMap::from([("picture".to_owned(), given)]);
    let requirement = &Requirement::typical;
    plan(graph, &PlanRequest { size, inputs, facts: Facts::default(), caps, options, requirement })
}

impl Growing {
    fn add_any(&mut self, off: u64) {
        let mut ticket = self.dice.below(KINDS.iter().map(|(_, weight)| *weight as usize).sum());
        let kind = KINDS.iter().find(|(_, weight)| {
            let found = ticket < *weight as usize;
            ticket = ticket.saturating_sub(*weight as usize);
            found
        });
        let kind = kind.expect("the ticket is below the sum of the weights").0;
        let has_all = kind.inputs().iter().all(|input| self.made.contains_key(&input.ty));
        if has_all {
            let wires = kind.inputs().iter().map(|input| self.pick(input.ty)).collect();
            // Whoever needs a volume or a value is starved without it, and so on to the outputs.
            let off = self.dice.per_cent(off) && kind.fallback() != Fallback::Absent;
            self.add(kind, wires, off);
        }
    }

    /// Mostly something new that nobody reads yet, sometimes anything.
    fn pick(&mut self, ty: PortType) -> Source {
        let unread = self.unread.entry(ty).or_default();
        if !unread.is_empty() && self.dice.per_cent(60) {
            let oldest = unread.len().saturating_sub(8);
            let at = oldest + self.dice.below(unread.len() - oldest);
            return unread.remove(at);
        }
        let made = &self.made[&ty];
        let oldest = if self.dice.per_cent(80) { made.len().saturating_sub(6) } else { 0 };
        made[oldest + self.dice.below(made.len() - oldest)]
    }

    fn add(&mut self, kind: NodeKind, wires: Vec<Source>, off: bool) {
        for source in &wires {
            self.unread.values_mut().for_each(|unread| unread.retain(|other| other != source));
        }
        let node = self.nodes.len();
        for (output, port) in kind.outputs().iter().enumerate() {
            let source = Source::Node { node, output, previous: 0 };
            self.made.entry(port.ty).or_default().push(source);
            self.unread.entry(port.ty).or_default().push(source);
        }
        let formats = [Format::R16Float, Format::Rg11b10Ufloat, Format::Rgba8Unorm, Format::Rgba32Float];
        let takes_formats = kind.outputs()[0].ty == PortType::Image;
        let format = (takes_formats && self.dice.per_cent(20)).then(|| formats[self.dice.below(formats.len())]);
        self.nodes.push(GraphNode {
            name: format!("{}{node}", kind.name().to_lowercase()),
            kind,
            values: Vec::new(),
            wires: wires.into_iter().map(Some).collect(),
            when: None,
            off,
            format,
            label: None,
            states: vec![None; kind.outputs().len()],
        });
    }

    /// Lays all images that nobody reads over each other, so that the last node needs nearly all others.
    fn funnel(&mut self) {
        let lay = NodeKind::of::<Lay>();
        while let [base, over, ..] = self.unread.get(&PortType::Image).map_or(&[][..], Vec::as_slice) {
            let wires = vec![*base, *over];
            self.add(lay, wires, false);
        }
    }

    /// Turns the second input of some nodes into what an image was in an earlier frame.
    fn add_histories(&mut self, count: usize) {
        let images: Vec<Source> = self.made[&PortType::Image].clone();
        let lays: Vec<usize> = (0..self.nodes.len()).filter(|at| self.nodes[*at].kind.name() == "Lay").collect();
        for _ in 0..count.min(lays.len()) {
            let (reader, past) = (lays[self.dice.below(lays.len())], images[self.dice.below(images.len())]);
            let frames = 1 + self.dice.below(3) as u32;
            if let Source::Node { node, output, .. } = past {
                self.nodes[reader].wires[1] = Some(Source::Node { node, output, previous: frames });
            }
        }
    }

    fn finish(self) -> Graph {
        let mut wires = DiGraph::new();
        self.nodes.iter().for_each(|_| {
            wires.add_node(());
        });
        for (reader, node) in self.nodes.iter().enumerate() {
            for source in node.wires.iter().flatten() {
                if let Source::Node { node, previous: 0, .. } = source {
                    wires.add_edge(NodeIndex::new(*node), NodeIndex::new(reader), ());
                }
            }
        }
        let input = GraphInput { name: "picture".into(), state: ColorState::Scene, optional: false, signed: false };
        let images = &self.made[&PortType::Image];
        let shown = [images[images.len() - 1], images[images.len() / 2]];
        let output = |(index, source): (usize, &Source)| GraphOutput {
            name: format!("shown{index}"),
            source: *source,
            state: ColorState::Scene,
        };
        let outputs = shown.iter().enumerate().map(output).collect();
        Graph { inputs: vec![input], nodes: self.nodes, outputs, wires }
    }
}
