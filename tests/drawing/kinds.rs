//! Kinds that draw triangles, for the tests of drawing passes.

use afterimage_graph::node::{
    BufferId, Compare, DepthTest, ImageId, Load, NodeKind, Recorder, Subresource, VertexFormat,
};
use afterimage_graph::prelude::*;

use super::blend::{Glass, GlassPair, GlassSamples, Glow, Show};
use super::draws::{Chosen, Pieces};
use super::raster::{Biased, Shapes, Sides, Two};

pub const ALL: &[NodeKind] = &[
    NodeKind::of::<Mips>(),
    NodeKind::of::<Layers>(),
    NodeKind::of::<Overlap>(),
    NodeKind::of::<Edge>(),
    NodeKind::of::<Twice>(),
    NodeKind::of::<Chain>(),
    NodeKind::of::<Indexed>(),
    NodeKind::of::<Part>(),
    NodeKind::of::<Sides>(),
    NodeKind::of::<Biased>(),
    NodeKind::of::<Two>(),
    NodeKind::of::<Shapes>(),
    NodeKind::of::<Glass>(),
    NodeKind::of::<GlassSamples>(),
    NodeKind::of::<Glow>(),
    NodeKind::of::<Show>(),
    NodeKind::of::<GlassPair>(),
    NodeKind::of::<Pieces>(),
    NodeKind::of::<Chosen>(),
];

/// Vertices with a place in clip space and a color, and what readers of levels need.
pub static SHADER: Shader = Shader::new(
    "draw_test.wgsl",
    "struct Corner { @builtin(position) place: vec4f, @location(0) color: vec4f }
@vertex fn corner(@location(0) place: vec3f, @location(1) color: vec4f) -> Corner {
    return Corner(vec4f(place, 1.0), color);
}
@vertex fn shifted(@location(0) place: vec3f, @location(1) color: vec4f, @location(2) shift: vec4f) -> Corner {
    return Corner(vec4f(place, 1.0) + vec4f(shift.xyz, 0.0), color * shift.w);
}
@fragment fn colored(corner: Corner) -> @location(0) vec4f { return corner.color; }",
);
pub static PICK: Shader = Shader::new(
    "draw_pick.wgsl",
    "fn pick(source: texture_2d<f32>, at: Point) -> vec4f { return texel(source, at.pixel); }",
);
static OVER: Shader = Shader::new(
    "draw_over.wgsl",
    "@group(0) @binding(0) var source: texture_2d<f32>;
struct Corner { @builtin(position) place: vec4f, @location(0) color: vec4f }
@vertex fn over(@location(0) place: vec3f, @location(1) color: vec4f) -> Corner {
    return Corner(vec4f(place, 1.0), color);
}
@fragment fn added(corner: Corner) -> @location(0) vec4f {
    return corner.color + textureLoad(source, vec2i(corner.place.xy), 0);
}",
);

/// A vertex: its place in clip space, and its color.
pub type Vertex = ([f32; 3], [f32; 4]);

/// A triangle whose corners lie on no center of a pixel of the sizes of the tests.
pub const LARGE: [Vertex; 3] = [
    ([-0.875, -0.75, 0.25], [1.0, 0.0, 0.5, 1.0]),
    ([0.9375, -0.3125, 0.25], [0.0, 4.0, 0.5, 0.5]),
    ([-0.375, 0.875, 0.25], [0.25, 0.5, 8.0, 0.0]),
];
/// Another one, which cuts through the first in depth.
pub const OTHER: [Vertex; 3] = [
    ([-0.9375, 0.65625, 0.0], [3.0, 3.0, 3.0, 1.0]),
    ([0.640625, 0.796875, 0.5], [2.0, 3.0, 1.0, 1.0]),
    ([0.203125, -0.9375, 0.25], [1.0, 0.0, 3.0, 1.0]),
];

pub const CLEARS: [[f64; 4]; 4] =
    [[0.5, 0.25, 0.125, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 0.75, 1.0], [7.0, 0.0, 0.0, 0.0]];

pub const RESULT: &[Output] =
    &[Output::image("result", OutputState::Always(ColorState::Data), "What is drawn.").or(Fallback::Absent)];

fn bytes(vertices: &[Vertex]) -> Vec<u8> {
    let numbers = vertices.iter().flat_map(|(place, color)| place.iter().chain(color));
    numbers.flat_map(|number| number.to_le_bytes()).collect()
}

pub fn buffer(pass: &mut Recorder<'_>, vertices: &[Vertex]) -> BufferId {
    pass.constant_buffer("vertices", bytes(vertices))
}

pub const FORMATS: [VertexFormat; 2] = [VertexFormat::Float32x3, VertexFormat::Float32x4];

fn draw(pass: &mut Recorder<'_>, vertices: &[Vertex], target: impl Into<Subresource>, load: Load<[f64; 4]>) {
    let buffer = buffer(pass, vertices);
    let draw = pass.draw(&SHADER, "corner").fragment("colored").color(target, load);
    draw.vertices(buffer, &FORMATS).record(vertices.len() as u32, 1);
}

pub fn desc(pass: &Recorder<'_>) -> ImageDesc {
    ImageDesc::new(pass.frame_size)
}

node_kind! {
    /// An image of four mip levels: each is cleared, and a triangle is drawn into the third.
    pub struct Mips {
        /// The level that is shown.
        pub level: u32 = 2 => within(0.0..=3.0), unit("levels");
    }

    const OUTPUTS: &'static [Output] = RESULT;
}

impl Node for Mips {
    fn record(&self, pass: &mut Recorder<'_>) {
        // All levels of an image of one texel are one texel.
        let most = pass.frame_size.levels() + 1;
        let mips = pass.transient("mips", desc(pass).with_levels(most.min(4)));
        for level in (0..most.min(4)).rev() {
            pass.clear("clear").color(mips.level(level), Load::Clear(CLEARS[level as usize])).record();
        }
        if most > 2 {
            draw(pass, &LARGE, mips.level(2), Load::Keep);
        }
        let level = self.level.min(most - 1);
        let desc = desc(pass).level(level);
        pass.function(&PICK, "pick").read_level("source", mips.level(level)).write("result", desc);
    }
}

node_kind! {
    /// An image of three layers: triangles are drawn into the second and the third.
    pub struct Layers {
        /// The layer that is shown.
        pub layer: u32 = 1 => within(0.0..=2.0), unit("layers");
    }

    const OUTPUTS: &'static [Output] = RESULT;
}

impl Node for Layers {
    fn record(&self, pass: &mut Recorder<'_>) {
        let layers = pass.transient("layers", desc(pass).with_layers(3));
        let part = |layer: u32| layers.level(0).layer(layer);
        pass.clear("first").color(part(0), Load::Clear(CLEARS[0])).record();
        draw(pass, &LARGE, part(1), Load::Clear(CLEARS[1]));
        draw(pass, &OTHER, part(2), Load::Clear(CLEARS[2]));
        let desc = desc(pass);
        pass.function(&PICK, "pick").read_level("source", part(self.layer)).write("result", desc);
    }
}

choices! {
    /// The fragment that stays.
    pub enum Stays {
        /// The nearest.
        Near,
        /// The farthest, with a reversed depth.
        Far,
        /// The last.
        Last,
    }
}

node_kind! {
    /// Two triangles that cut through each other.
    pub struct Overlap {
        /// The fragment that stays.
        pub stays: Stays = Stays::Near;
        /// True if the depth has 16 bits.
        pub short: bool = false;
        /// True if each triangle has a pass of its own, the second keeping what the first has drawn.
        pub apart: bool = false;
    }

    const OUTPUTS: &'static [Output] = &[
        Output::image("result", OutputState::Always(ColorState::Data), "The colors.").or(Fallback::Absent),
        Output::image("depth", OutputState::Always(ColorState::Data), "The depth.").or(Fallback::Absent),
    ];
}

impl Node for Overlap {
    fn record(&self, pass: &mut Recorder<'_>) {
        let format = if self.short { Format::Depth16Unorm } else { Format::Depth32Float };
        let desc = desc(pass);
        let depth = pass.transient("depth", desc.format(format));
        let color = pass.output("result", desc);
        let test = match self.stays {
            Stays::Near => DepthTest::default(),
            Stays::Far => DepthTest::REVERSED,
            Stays::Last => DepthTest { compare: Compare::Always, ..DepthTest::default() },
        };
        let (first, both) = (buffer(pass, &LARGE), buffer(pass, &[LARGE, OTHER].concat()));
        let second = buffer(pass, &OTHER);
        let mut draw = |buffer, count, load, test| {
            let draw = pass.draw(&SHADER, "corner").fragment("colored").color(color, load).depth(depth, test);
            draw.vertices(buffer, &FORMATS).record(count, 1);
        };
        if self.apart {
            draw(first, 3, Load::Clear(CLEARS[0]), test);
            draw(second, 3, Load::Keep, DepthTest { load: Load::Keep, ..test });
        } else {
            draw(both, 6, Load::Clear(CLEARS[0]), test);
        }
        if pass.is_output_used("depth") {
            pass.function(&PICK, "pick").read("source", depth).write("depth", desc.format(Format::R32Float));
        }
    }
}

node_kind! {
    /// A triangle with four samples in each pixel.
    pub struct Edge {}

    const OUTPUTS: &'static [Output] = &[
        Output::new("samples", PortType::Multisampled, OutputState::Always(ColorState::Scene), "The colors."),
        Output::new("depth", PortType::Multisampled, OutputState::Always(ColorState::Data), "The depths."),
    ];
}

impl Node for Edge {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = desc(pass).multisampled(4);
        let (color, depth) = (pass.output("samples", desc), pass.level("depth", desc.format(Format::Depth32Float)));
        pass.set_output("depth", InputValue::Image(depth));
        let vertices = LARGE.map(|(place, _)| (place, [50.0, 25.0, 5.0, 1.0]));
        let buffer = buffer(pass, &vertices);
        let draw = pass.draw(&SHADER, "corner").fragment("colored").color(color, Load::Clear([0.0; 4]));
        draw.depth(depth, DepthTest::default()).vertices(buffer, &FORMATS).record(3, 1);
    }
}

node_kind! {
    /// Two triangles, each in a pass.
    pub struct Twice {
        /// True if the second pass clears what the first has drawn.
        pub clears: bool = false;
    }

    const OUTPUTS: &'static [Output] = &[
        Output::image("result", OutputState::Always(ColorState::Data), "Both.").or(Fallback::Absent),
        Output::image("between", OutputState::Always(ColorState::Data), "After the first.").or(Fallback::Absent),
        Output::image("other", OutputState::Always(ColorState::Data), "Another one.").or(Fallback::Absent),
    ];
}

impl Node for Twice {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = desc(pass);
        let color = pass.output("result", desc);
        draw(pass, &LARGE, color, Load::Clear(CLEARS[0]));
        if pass.is_output_used("between") {
            pass.function(&PICK, "pick").read("source", color).write("between", desc);
        }
        let load = if self.clears { Load::Clear(CLEARS[1]) } else { Load::Keep };
        draw(pass, &OTHER, color, load);
        let other = pass.output("other", desc);
        draw(pass, &OTHER, other, Load::Clear(CLEARS[3]));
    }
}

node_kind! {
    /// A triangle over an image that another triangle is drawn into, with a depth for each.
    pub struct Chain {}

    const OUTPUTS: &'static [Output] = RESULT;
}

impl Chain {
    fn depth(pass: &mut Recorder<'_>, name: &str) -> ImageId {
        let desc = desc(pass).format(Format::Depth32Float);
        pass.transient(name, desc)
    }
}

impl Node for Chain {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = desc(pass);
        let (color, depth) = (pass.transient("first", desc), Self::depth(pass, "first_depth"));
        let vertices = buffer(pass, &LARGE);
        let draw = pass.draw(&SHADER, "corner").fragment("colored").color(color, Load::Clear(CLEARS[0]));
        draw.depth(depth, DepthTest::default()).vertices(vertices, &FORMATS).record(3, 1);
        let copy = pass.transient("copy", desc);
        pass.function(&PICK, "pick").read("source", color).write_to(copy);
        let (result, depth) = (pass.output("result", desc), Self::depth(pass, "second_depth"));
        let vertices = buffer(pass, &OTHER);
        let draw = pass.draw(&OVER, "over").fragment("added").color(result, Load::Clear(CLEARS[1]));
        let draw = draw.depth(depth, DepthTest::default()).image("source", copy);
        draw.vertices(vertices, &FORMATS).record(3, 1);
    }
}

node_kind! {
    /// Instances of a triangle, by indices that name its corners in another order.
    pub struct Indexed {}

    const OUTPUTS: &'static [Output] = RESULT;
}

/// The offset of each instance, and the factor of its color.
pub const SHIFTS: [[f32; 4]; 2] = [[-0.25, 0.125, 0.0, 0.5], [0.5, -0.25, 0.0, 2.0]];

impl Node for Indexed {
    fn record(&self, pass: &mut Recorder<'_>) {
        let vertices = buffer(pass, &[OTHER, LARGE].concat());
        let indices: Vec<u8> = [4_u32, 5, 3].into_iter().flat_map(u32::to_le_bytes).collect();
        let indices = pass.constant_buffer("indices", indices);
        let shifts: Vec<u8> = SHIFTS.as_flattened().iter().flat_map(|number| number.to_le_bytes()).collect();
        let shifts = pass.constant_buffer("shifts", shifts);
        let desc = desc(pass);
        let color = pass.output("result", desc);
        let draw = pass.draw(&SHADER, "shifted").fragment("colored").color(color, Load::Clear(CLEARS[0]));
        let draw = draw.vertices(vertices, &FORMATS).instances(shifts, &[VertexFormat::Float32x4]);
        draw.indices(indices).record(3, 2);
    }
}

node_kind! {
    /// An image of two levels. The host draws into the second.
    pub struct Part {}

    const OUTPUTS: &'static [Output] = RESULT;
}

impl Node for Part {
    fn record(&self, pass: &mut Recorder<'_>) {
        let last = pass.frame_size.levels().min(1);
        let image = pass.transient("levels", desc(pass).with_levels(last + 1));
        if last > 0 {
            pass.clear("first").color(image.level(0), Load::Clear(CLEARS[0])).record();
        }
        pass.host_draw("second").color(image.level(last), Load::Clear(CLEARS[1])).record();
        let desc = desc(pass).level(last);
        pass.function(&PICK, "pick").read_level("source", image.level(last)).write("result", desc);
    }
}
