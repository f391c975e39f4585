//! Images and cameras of the built-in scene for the inputs of a kind.

use afterimage::offline::Session;
use afterimage_gpu::{FrameStep, Gpu, InputImage, Texels, input_image};
use afterimage_graph::check::{Facts, Graph, GraphInput};
use afterimage_graph::image::{ColorState, ImageDesc, Size};
use afterimage_graph::node::{BlockData, Camera, HostBlock, Registry, TypedKind as _};
use afterimage_graph::value::Value;
use afterimage_lab::LabError;
use afterimage_lab::scene::graph;
use afterimage_nodes::DemoScene;
use afterimage_plan::Options;

/// Objects move, and samples lie beside the centers of pixels, as a renderer does for anti-aliasing over time.
const SCENE: &str = r#"Pipeline(
    inputs: {},
    nodes: {
        "scene": DemoScene(samples: 1, objects: 2, time: 1.0),
        "exposed": Exposure(source: "scene", stops: 1.0),
        "around": LogGaussian(source: "exposed"),
        "mapped": ToneMap(source: "exposed"),
        "display": Encode(source: "mapped"),
    },
    outputs: {
        "result": "scene", "depth": "scene.depth", "projected": "scene.projected", "normal": "scene.normal",
        "albedo": "scene.albedo", "motion": "scene.motion", "exposed": "exposed", "around": "around",
        "mapped": "mapped", "display": "display",
    },
)"#;
/// The camera's place in the frame, and how far it moves in one: 0.07 m.
const WALK: f64 = 0.3;
const STEP: f64 = 0.01;
/// The camera's place that casts shadows.
const LIGHT: f64 = 0.22;
const DT: f64 = 1.0 / 60.0;
/// Where samples lie in this frame, and of four samples of a pixel: the usual pattern of devices.
const JITTER: [f64; 2] = [0.25, -0.125];
const SAMPLES: [[f64; 2]; 4] = [[-0.125, -0.375], [0.375, -0.125], [-0.375, 0.125], [0.125, 0.375]];
/// A volume as renderers have for fog.
const VOLUME: Size = Size { width: 160, height: 90, depth: 64 };
/// The first number of the noise in it.
const SEED: u32 = 1;

/// The images.
pub(super) struct SceneImages<'a> {
    gpu: &'a Gpu,
    registry: &'a Registry,
    size: Size,
    now: Session,
    before: Session,
    light: Session,
    /// The eye.
    pub(super) camera: Camera,
    light_camera: Camera,
}

impl<'a> SceneImages<'a> {
    pub(super) fn new(gpu: &'a Gpu, registry: &'a Registry, size: Size) -> Result<Self, LabError> {
        let now = scene(registry, WALK, JITTER)?;
        let before = scene(registry, WALK - STEP, [0.0; 2])?;
        let light = scene(registry, LIGHT, [0.0; 2])?;
        let (camera, light_camera) = (camera(&now, size), camera(&light, size));
        let [now, before, light] = [render(gpu, now, size)?, render(gpu, before, size)?, render(gpu, light, size)?];
        Ok(Self { gpu, registry, size, now, before, light, camera, light_camera })
    }

    /// An image for each input of a kind that takes one.
    pub(super) fn of(&self, kind: &str, inputs: &[GraphInput]) -> Result<Vec<InputImage>, LabError> {
        let images = inputs.iter().filter(|input| input.block.is_none());
        images.map(|input| Ok(InputImage { finite: true, ..self.image(kind, input)? })).collect()
    }

    fn image(&self, kind: &str, input: &GraphInput) -> Result<InputImage, LabError> {
        if input.multisampled {
            return self.multisampled(&input.name);
        }
        if input.volume {
            return Ok(input_image(self.gpu, &input.name, ImageDesc::volume(VOLUME), &fog().bytes)?);
        }
        // Inputs of nodes that make a port's value have the name of the port before their own.
        let port = input.name.rsplit('-').next().unwrap_or_default();
        let (session, output) = match (port, input.state) {
            ("history", _) => (&self.before, "result"),
            ("previous_depth", _) => (&self.before, "depth"),
            ("map", _) => (&self.light, "projected"),
            ("depth", _) if kind == "LinearDepth" => (&self.now, "projected"),
            ("depth" | "normal" | "motion", _) => (&self.now, port),
            (_, ColorState::Scene) => (&self.now, "result"),
            (_, ColorState::Exposed) => (&self.now, "exposed"),
            (_, ColorState::LogLuminance) => (&self.now, "around"),
            (_, ColorState::DisplayLinear) => (&self.now, "mapped"),
            (_, ColorState::Encoded) => (&self.now, "display"),
            _ => (&self.now, "albedo"),
        };
        Ok(session.output_image(output, &input.name))
    }

    fn multisampled(&self, input: &str) -> Result<InputImage, LabError> {
        let mut bytes = Vec::new();
        let mut desc = ImageDesc::new(self.size);
        for place in SAMPLES {
            let texels = render(self.gpu, scene(self.registry, WALK, place)?, self.size)?.output("result")?;
            bytes.extend(&texels.bytes);
            desc = texels.desc;
        }
        Ok(input_image(self.gpu, input, desc.multisampled(SAMPLES.len() as u32), &bytes)?)
    }

    /// The numbers of a host block.
    pub(super) fn block(&self, input: &str, block: &'static HostBlock, is_camera: bool) -> Result<BlockData, LabError> {
        if !is_camera {
            return Ok(BlockData::new(block));
        }
        let camera = if input.ends_with("light") { self.light_camera } else { self.camera };
        camera.data().map_err(LabError::request)
    }
}

/// The scene with the camera at this place.
fn scene(registry: &Registry, walk: f64, [x, y]: [f64; 2]) -> Result<Graph, LabError> {
    let mut scene = graph(registry, "scene.ron", SCENE)?;
    let node = scene.nodes.iter_mut().find(|node| node.name == "scene").expect("it is in the text");
    let jitter = Value::Vector([x, y, 0.0, 0.0], 2);
    let values = [("walk", Value::Float(walk)), ("step", Value::Float(STEP)), ("dt", Value::Float(DT))];
    for (name, value) in values.into_iter().chain([("jitter", jitter)]) {
        let (at, _) = node.kind().param(name).expect("a parameter of the scene");
        node.instance.set(at, value);
    }
    Ok(scene)
}

/// The camera of the scene.
fn camera(graph: &Graph, size: Size) -> Camera {
    let node = graph.nodes.iter().find(|node| node.name == "scene").expect("it is in the text");
    DemoScene::from_values(node.instance.values()).expect("the values are checked").camera(size)
}

fn render(gpu: &Gpu, graph: Graph, size: Size) -> Result<Session, LabError> {
    let mut session = Session::new(gpu, graph, Facts::default(), Options::default());
    session.render(size, &[], FrameStep::FIRST)?;
    Ok(session)
}

/// Light that fog scatters and the share that it lets pass, less with each slice, with noise of a fixed seed.
fn fog() -> Texels {
    let Size { width, height, depth } = VOLUME;
    let mut state = SEED;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let texel = |at: u32| {
        let passed = 1.0 - 0.8 * (at / (width * height)) as f32 / depth as f32;
        let light = (1.0 - passed) * (0.1 + 0.1 * random());
        [light, light, 0.8 * light, passed]
    };
    let texels: Vec<[f32; 4]> = (0..width * height * depth).map(texel).collect();
    Texels::from_floats_as_half(width, height * depth, &texels)
}
