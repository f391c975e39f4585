//! Kinds of `stress` alone: they show wires that cannot be outputs as images, and measure the filter of the device.

use afterimage_graph::prelude::*;

static LEVEL: Shader = Shader::new(
    "show_level.wgsl",
    "import afterimage::sampling::texel;
fn show_level(level: texture_2d<f32>, level_sampler: sampler, at: Point) -> vec4f { return texel(level, at.pixel); }",
);
static VALUE: Shader = Shader::new("show_value.wgsl", "fn show_value(value: vec4f) -> vec4f { return value; }");
static VOLUME: Shader = Shader::new(
    "show_volume.wgsl",
    "import afterimage::sampling::texel3;
struct ShowVolume { depth: f32 }
fn show_volume_magnitude(v: vec4f) -> u32 {
    let bits = bitcast<vec4u>(v) & vec4u(0x7fffffffu);
    return max(max(bits.x, bits.y), max(bits.z, bits.w));
}
fn show_volume(volume: texture_3d<f32>, volume_sampler: sampler, at: Point, params: ShowVolume) -> vec4f {
    var worst = texel3(volume, vec3i(at.pixel, 0));
    for (var z = 1; z < i32(params.depth); z++) {
        let cell = texel3(volume, vec3i(at.pixel, z));
        if show_volume_magnitude(cell) > show_volume_magnitude(worst) { worst = cell; }
    }
    return worst;
}",
);

static FILTER: Shader = Shader::new(
    "show_filter.wgsl",
    "import afterimage::sampling::tap;
fn show_filter(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    return tap(source, source_sampler, vec2f((0.5 + at.uv.x) / at.size.x, 0.5));
}",
);

choices! {
    /// The level of a pyramid that is shown.
    pub enum End {
        /// The largest level.
        Finest,
        /// The smallest level.
        Coarsest,
    }
}

node_kind! {
    /// One level of a pyramid.
    pub struct ShowLevel {
        /// The largest or the smallest level.
        pub end: End = End::Finest;
    }

    const INPUTS: &'static [Input] = &[Input::new("pyramid", PortType::Pyramid, "The pyramid.")];
    const OUTPUTS: &'static [Output] = &[Output::image("result", OutputState::same("pyramid"), "The level.")];
    const INVARIANTS: Invariants = super::laws::ALL;
}

node_kind! {
    /// A value as one pixel.
    pub struct ShowValue {}

    const INPUTS: &'static [Input] = &[Input::new("value", PortType::Value, "The value.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Data), "The value.").or(Fallback::Absent)];
    const INVARIANTS: Invariants = super::laws::ALL;
}

node_kind! {
    /// The worst cell of each column of a volume: by its bits the largest, which NaN and infinity are.
    pub struct ShowVolume {}

    const INPUTS: &'static [Input] = &[Input::new("volume", PortType::Volume, "The volume.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Data), "Its worst cells.").or(Fallback::Absent)];
    const INVARIANTS: Invariants = super::laws::ALL;
}

node_kind! {
    /// The way from the first texel of an image to the second, over its whole width.
    pub struct ShowFilter {}

    const INPUTS: &'static [Input] = &[Input::image("image", "The image.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Data), "What the filter gives.")
            .or(Fallback::Absent)];
    const INVARIANTS: Invariants = super::laws::ALL;
}

impl Node for ShowLevel {
    fn record(&self, pass: &mut Recorder<'_>) {
        let levels = pass.pyramid("pyramid");
        let level = match self.end {
            End::Finest => levels[0],
            End::Coarsest => levels[levels.len() - 1],
        };
        let desc = pass.desc(level);
        pass.function(&LEVEL, "show_level").read("level", level).write("result", desc);
    }
}

impl Node for ShowValue {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = ImageDesc::new(Size::new(1, 1)).format(Format::Rgba32Float);
        pass.function(&VALUE, "show_value").write("result", desc);
    }
}

impl Node for ShowVolume {
    fn record(&self, pass: &mut Recorder<'_>) {
        let volume = pass.image("volume");
        let size = pass.desc(volume).size;
        let desc = ImageDesc::new(Size::new(size.width, size.height)).format(Format::Rgba32Float);
        pass.function(&VOLUME, "show_volume").set("depth", size.depth as f32).write("result", desc);
    }
}

impl Node for ShowFilter {
    fn record(&self, pass: &mut Recorder<'_>) {
        let image = pass.image("image");
        let desc = pass.desc(image).format(Format::Rgba32Float);
        pass.function(&FILTER, "show_filter").read("source", image).write("result", desc);
    }
}

/// The kinds of this file.
pub(crate) const ALL: &[NodeKind] = &[
    NodeKind::of::<ShowFilter>(),
    NodeKind::of::<ShowLevel>(),
    NodeKind::of::<ShowValue>(),
    NodeKind::of::<ShowVolume>(),
];
