//! Kinds that only tests have: they show what travels on wires that no output can take.

use afterimage_graph::check::{CheckOptions, Graph, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::Registry;
use afterimage_graph::prelude::*;

use crate::reference::guard::{LARGEST_HALF, guard};
use crate::reference::image::Image;
use crate::support::gpu::{Picture, Run};

static TABLE: Shader = Shader::new(
    "probe_table.wgsl",
    "@group(0) @binding(0) var<storage, read> table: array<u32>;
@group(0) @binding(1) var result: texture_storage_2d<rgba32float, write>;
@compute @workgroup_size(64)
fn probe_table(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= textureDimensions(result).x { return; }
    let word = table[min(id.x, arrayLength(&table) - 1u)];
    let header = vec4f(bitcast<f32>(word), 0.0, 0.0, 0.0);
    let count = vec4f(f32(word & 0xffffu), f32(word >> 16u), 0.0, 0.0);
    textureStore(result, vec2u(id.x, 0u), select(count, header, id.x < 4u));
}",
);
static VALUE: Shader = Shader::new("probe_value.wgsl", "fn probe_value(value: vec4f) -> vec4f { return value; }");
static VOLUME: Shader = Shader::new(
    "probe_volume.wgsl",
    "@group(0) @binding(0) var volume: texture_3d<f32>;
@group(0) @binding(1) var result: texture_storage_2d<rgba32float, write>;
@compute @workgroup_size(16, 16)
fn probe_volume(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) { return; }
    let width = textureDimensions(volume).x;
    textureStore(result, id.xy, texel3(volume, vec3i(vec3u(id.x % width, id.x / width, id.y))));
}",
);

params! {
    /// The first 260 words of a table: four floats, then whole numbers as their low and high halves.
    pub struct ProbeTable {}
}

params! {
    /// A value as one pixel.
    pub struct ProbeValue {}
}

params! {
    /// A volume as an image: rows of all slices beside each other, one row of pixels for each slice.
    pub struct ProbeVolume {}
}

const RESULT: &[Output] = &[Output::image("result", OutputState::Always(ColorState::Data), "What was seen.")];

fn seen(width: u32, height: u32) -> ImageDesc {
    ImageDesc::new(Size::new(width, height)).format(Format::Rgba32Float)
}

impl Node for ProbeTable {
    const INPUTS: &'static [Input] = &[Input::new("table", PortType::Table, "The table.")];
    const OUTPUTS: &'static [Output] = RESULT;
    const FALLBACK: Fallback = Fallback::Absent;

    fn record(&self, pass: &mut Recorder<'_>) {
        let result = pass.output("result", seen(260, 1));
        pass.compute(&TABLE, "probe_table").image("result", result).dispatch([5, 1, 1]);
    }
}

impl Node for ProbeValue {
    const INPUTS: &'static [Input] = &[Input::new("value", PortType::Value, "The value.")];
    const OUTPUTS: &'static [Output] = RESULT;
    const FALLBACK: Fallback = Fallback::Absent;

    fn record(&self, pass: &mut Recorder<'_>) {
        pass.function(&VALUE, "probe_value").write("result", seen(1, 1));
    }
}

impl Node for ProbeVolume {
    const INPUTS: &'static [Input] = &[Input::new("volume", PortType::Volume, "The volume.")];
    const OUTPUTS: &'static [Output] = RESULT;
    const FALLBACK: Fallback = Fallback::Absent;

    fn record(&self, pass: &mut Recorder<'_>) {
        let volume = pass.image("volume");
        let size = pass.desc(volume).size;
        let result = pass.output("result", seen(size.width * size.height, size.depth));
        let groups = pass.desc(result).size.div_up(16);
        pass.compute(&VOLUME, "probe_volume").image("result", result).dispatch([groups.width, groups.height, 1]);
    }
}

const PROBES: &[NodeKind] =
    &[NodeKind::of::<ProbeTable>(), NodeKind::of::<ProbeValue>(), NodeKind::of::<ProbeVolume>()];

/// The graph of a pipeline that may use probes.
pub(crate) fn graph(text: &str) -> Graph {
    let document = parse("test.ron", text).unwrap_or_else(|errors| panic!("{errors:?}"));
    let registry = Registry::new(&[afterimage_nodes::ALL, PROBES]).expect("no two kinds share a name");
    let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
    check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors:?}")).0
}

/// A pipeline from `scene` (and `more` inputs) over some nodes to the node `seen`.
pub(crate) fn pipeline(more: &str, nodes: &str) -> Graph {
    graph(&format!(
        "Pipeline(inputs: {{ \"scene\": Color, {more} }}, nodes: {{ {nodes} }}, outputs: {{ \"out\": \"seen\" }})"
    ))
}

/// What the node `seen` shows in the first frame, with 32 bits between all nodes.
pub(crate) fn shown(nodes: &str, scene: &Picture) -> Picture {
    let graph = pipeline("", nodes);
    Run::new(&graph).exact().frame(&[("scene", scene)]).remove(0)
}

/// The same with another image of data.
pub(crate) fn shown_with(nodes: &str, scene: &Picture, name: &str, data: &Picture) -> Picture {
    let graph = pipeline(&format!("\"{name}\": Data"), nodes);
    Run::new(&graph).exact().frame(&[("scene", scene), (name, data)]).remove(0)
}

/// The sizes at which each kind is held to its twin.
pub(crate) const SIZES: [(u32, u32); 3] = [(1, 1), (2, 3), (641, 359)];

/// Seventeen stops of gradients and edges, with black, the brightest half float and NaN in it.
pub(crate) fn scene(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let (u, v) = (f64::from(x) / f64::from(width), f64::from(y) / f64::from(height));
        let edge = if u + 0.3 * v > 0.7 { 5.0 } else { 0.0 };
        let stops = -8.0 + 6.0 * u + 2.0 * (9.0 * v).sin() + edge + 0.4 * (40.0 * u).sin() * (31.0 * v).cos();
        let light = stops.exp2() as f32;
        match (x * 31 + y * 17) % 1009 {
            500 => [0.0, 0.0, 0.0, 1.0],
            501 => [65504.0, 65504.0, 65504.0, 1.0],
            502 => [f32::NAN, 0.25, f32::INFINITY, 1.0],
            503 => [-1.0, 0.5, 0.25, 1.0],
            _ => [light * (1.0 + u as f32), light, light * (1.5 - v as f32), 0.5],
        }
    })
}

/// The picture as its readers see it: guarded, in f64.
pub(crate) fn twin(picture: &Picture) -> Image {
    Image::new(picture.width as usize, picture.height as usize, |x, y| {
        picture.at(x as u32, y as u32).map(|value| guard(f64::from(value), LARGEST_HALF))
    })
}
