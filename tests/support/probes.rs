//! Kinds that only tests have: they show the content of wires that no output accepts.

use afterimage_graph::prelude::*;
use afterimage_lab::stress::ShowValue;

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

node_kind! {
    /// The first 388 words of a table: four floats, then integers as their low and high halves.
    pub struct ProbeTable {}

    const INPUTS: &'static [Input] = &[Input::new("table", PortType::Table, "The table.")];
    const OUTPUTS: &'static [Output] = RESULT;
}

node_kind! {
    /// A volume as an image: rows of all slices beside each other, one row of pixels for each slice.
    pub struct ProbeVolume {}

    const INPUTS: &'static [Input] = &[Input::new("volume", PortType::Volume, "The volume.")];
    const OUTPUTS: &'static [Output] = RESULT;
}

const RESULT: &[Output] =
    &[Output::image("result", OutputState::Always(ColorState::Data), "The content of the wire.").or(Fallback::Absent)];

fn seen(width: u32, height: u32) -> ImageDesc {
    ImageDesc::new(Size::new(width, height)).format(Format::Rgba32Float)
}

impl Node for ProbeTable {
    fn record(&self, pass: &mut Recorder<'_>) {
        let result = pass.output("result", seen(388, 1));
        pass.compute(&TABLE, "probe_table").image("result", result).dispatch([7, 1, 1]);
    }
}

impl Node for ProbeVolume {
    fn record(&self, pass: &mut Recorder<'_>) {
        let volume = pass.image("volume");
        let size = pass.desc(volume).size;
        let result = pass.output("result", seen(size.width * size.height, size.depth));
        let groups = pass.desc(result).size.div_up(16);
        pass.compute(&VOLUME, "probe_volume").image("result", result).dispatch([groups.width, groups.height, 1]);
    }
}

pub const ALL: &[NodeKind] =
    &[NodeKind::of::<ProbeTable>(), NodeKind::of::<ShowValue>(), NodeKind::of::<ProbeVolume>()];
