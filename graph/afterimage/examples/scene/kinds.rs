//! Kinds that draw: the depth of a scene from its lamp, its light, and solids with an image of many mip levels.

use afterimage_graph::node::{Blend, CAMERA, Cull, DepthTest, Load, Raster, VertexFormat, WriteMask};
use afterimage_graph::prelude::*;

use crate::geometry::{Mesh, icosahedron};

pub(crate) const ALL: &[NodeKind] =
    &[NodeKind::of::<SceneDepth>(), NodeKind::of::<SceneLight>(), NodeKind::of::<MipSolids>()];

static DEPTH: Shader = Shader::new("scene_depth.wgsl", include_str!("scene_depth.wgsl"));
static LIGHT: Shader = Shader::new("scene_light.wgsl", include_str!("scene_light.wgsl"));
static SOLIDS: Shader = Shader::new("mip_solids.wgsl", include_str!("mip_solids.wgsl"));

/// Place, normal, and color with emission.
const VERTEX: [VertexFormat; 3] = [VertexFormat::Float32x3, VertexFormat::Float32x3, VertexFormat::Float32x4];

/// The buffers of the scene: vertices, indices, and how many of these.
fn scene(pass: &mut Recorder<'_>) -> (BufferId, BufferId, u32) {
    let mesh = Mesh::scene();
    let vertices = pass.constant_buffer("vertices", mesh.vertex_bytes());
    (vertices, pass.constant_buffer("indices", mesh.index_bytes()), mesh.count())
}

node_kind! {
    /// The depth map of a lamp.
    pub struct SceneDepth {
        /// Texels across and down.
        pub size: u32 = 2048 => within(1.0..=8192.0), unit("texels");
        /// Steps of 1/65535 by which the depth lies behind the surface.
        pub bias: u32 = 4 => within(0.0..=1000.0), usually(0.0..=16.0);
        /// How much further it lies behind for each unit of slope.
        pub slope_bias: f32 = 2.5 => within(0.0..=16.0), usually(0.0..=4.0), replans();
    }

    const INPUTS: &'static [Input] = &[Input::block("light", &CAMERA, "The camera at the lamp.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("depth", OutputState::Always(ColorState::Data), "The depth.").or(Fallback::Absent)];
}

impl Node for SceneDepth {
    fn record(&self, pass: &mut Recorder<'_>) {
        let (vertices, indices, count) = scene(pass);
        let size = Size::new(self.size, self.size);
        let depth = pass.transient("depth", ImageDesc::new(size).format(Format::Depth16Unorm));
        pass.set_output("depth", InputValue::Image(depth));
        let raster = Raster { bias: self.bias as i32, slope_bias: self.slope_bias, ..Raster::default() };
        let draw = pass.draw(&DEPTH, "from_light").depth(depth, DepthTest::default()).raster(raster);
        draw.vertices(vertices, &VERTEX).indices(indices).record(count, 1);
    }
}

node_kind! {
    /// The light of a scene, with four samples in each pixel. Alpha is how strongly a surface emits light.
    pub struct SceneLight {
        /// From white to the yellow of a candle.
        pub warmth: f32 = 0.35 => within(0.0..=1.0);
        /// The light of surfaces that emit some.
        pub emission: f32 = 12.0 => within(0.0..=1000.0), usually(0.0..=50.0);
    }

    const INPUTS: &'static [Input] = &[
        Input::block("camera", &CAMERA, "The camera."),
        Input::block("light", &CAMERA, "The camera at the lamp."),
        Input::image("shadows", "The depth map of the lamp.").accepts(&[ColorState::Data]),
    ];
    const OUTPUTS: &'static [Output] = &[Output::new(
        "samples",
        PortType::Multisampled,
        OutputState::Always(ColorState::Scene),
        "The light of the scene.",
    )];
}

impl Node for SceneLight {
    fn record(&self, pass: &mut Recorder<'_>) {
        let (vertices, indices, count) = scene(pass);
        let desc = ImageDesc::new(pass.frame_size).multisampled(4);
        let color = pass.output("samples", desc);
        let depth = pass.transient("depth", desc.format(Format::Depth32Float));
        let draw = pass.draw(&LIGHT, "from_camera").fragment("shaded");
        let draw = draw.color(color, Load::Clear([0.16, 0.2, 0.3, 0.0])).depth(depth, DepthTest::default());
        let raster = Raster { cull: Cull::Back, ..Raster::default() };
        draw.raster(raster).vertices(vertices, &VERTEX).indices(indices).record(count, 1);
        let glass = Mesh::glass();
        let vertices = pass.constant_buffer("glass_vertices", glass.vertex_bytes());
        let indices = pass.constant_buffer("glass_indices", glass.index_bytes());
        let draw = pass.draw(&LIGHT, "from_camera").fragment("tinted").label("glass");
        // Filters before a light have no order. Alpha stays: what is seen through them emits light as before.
        let draw = draw.color(color, Load::Keep).blend(Blend::MULTIPLY).writes(WriteMask::COLOR);
        let draw = draw.depth(depth, DepthTest { load: Load::Keep, write: false, ..DepthTest::default() });
        draw.vertices(vertices, &VERTEX).indices(indices).record(glass.count(), 1);
    }
}

node_kind! {
    /// Icosahedra at growing distances, with an image whose mip levels are drawn one by one in a color each.
    pub struct MipSolids {}

    const OUTPUTS: &'static [Output] =
        &[Output::new("samples", PortType::Multisampled, OutputState::Always(ColorState::Scene), "The solids.")];
}

/// Colors of the levels, from the finest.
const COLORS: [[f64; 3]; 10] = [
    [0.9, 0.1, 0.1],
    [0.95, 0.5, 0.1],
    [0.9, 0.85, 0.1],
    [0.3, 0.8, 0.15],
    [0.1, 0.75, 0.7],
    [0.1, 0.35, 0.9],
    [0.4, 0.15, 0.85],
    [0.85, 0.2, 0.75],
    [0.6, 0.6, 0.6],
    [1.0, 1.0, 1.0],
];

impl Node for MipSolids {
    fn record(&self, pass: &mut Recorder<'_>) {
        let picture = ImageDesc::new(Size::new(512, 512)).format(Format::Rgba8Unorm).with_levels(10);
        let picture = pass.transient("picture", picture);
        for (level, [red, green, blue]) in (0..).zip(COLORS) {
            let clear = pass.clear(format!("level {level}"));
            clear.color(picture.level(level), Load::Clear([red, green, blue, 1.0])).record();
        }
        let places: Vec<f32> = icosahedron().into_iter().flatten().flatten().collect();
        let count = places.len() as u32 / 3;
        let vertices =
            pass.constant_buffer("vertices", places.into_iter().flat_map(f32::to_le_bytes).collect::<Vec<_>>());
        let centers: Vec<[f32; 4]> = (0..8_u8).map(|at| center(f32::from(at))).collect();
        let instances =
            pass.constant_buffer("centers", centers.iter().flatten().flat_map(|n| n.to_le_bytes()).collect::<Vec<_>>());
        let desc = ImageDesc::new(pass.frame_size).multisampled(4);
        let color = pass.output("samples", desc);
        let depth = pass.transient("depth", desc.format(Format::Depth32Float));
        let draw = pass.draw(&SOLIDS, "solid").fragment("banded").image("picture", picture);
        let draw = draw.color(color, Load::Clear([0.02, 0.02, 0.03, 1.0])).depth(depth, DepthTest::default());
        let draw = draw.vertices(vertices, &VERTEX[..1]).instances(instances, &[VertexFormat::Float32x4]);
        draw.raster(Raster { cull: Cull::Back, ..Raster::default() }).record(count, centers.len() as u32);
    }
}

/// Where an icosahedron stands, and its radius: each half as far again as the one before it.
fn center(at: f32) -> [f32; 4] {
    let distance = 2.2 * 1.45_f32.powf(at);
    [distance * (-0.74 + 0.21 * at), distance * (0.04 - 0.01 * at), -distance, 0.45]
}
