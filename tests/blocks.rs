//! Host blocks: the camera that kinds read and hosts give for each frame.

use std::sync::Arc;

use afterimage::Post;
use afterimage::host::PostError;
use afterimage_generators::Rng;
use afterimage_gpu::{Frame, Gpu, GpuError, Texels, download, upload, wgpu};
use afterimage_graph::check::{CheckOptions, Graph, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{Format, Size};
use afterimage_graph::node::{BlockData, CAMERA, Camera, NodeKind, Registry, contract, folder_kind_of};
use afterimage_graph::prelude::*;
use afterimage_plan::HostInputs;
use glam::camera::rh::proj::directx;
use glam::camera::rh::view::look_to_mat4;
use glam::{DMat4, DVec2, DVec4, Mat4, vec3};

use crate::support::gpu::{Picture, Shared, gpu};

const FOG: [&str; 2] =
    [include_str!("folders/ground_fog/node.ron"), include_str!("folders/ground_fog/ground_fog.wgsl")];

const VIEW_DEPTH: [&str; 2] =
    [include_str!("folders/view_depth/node.ron"), include_str!("folders/view_depth/view_depth.wgsl")];

fn view_depth() -> NodeKind {
    let shader = ("view_depth.wgsl", VIEW_DEPTH[1]);
    folder_kind_of(("node.ron", VIEW_DEPTH[0]), &[shader]).unwrap_or_else(|errors| panic!("{errors}"))
}

fn fog() -> NodeKind {
    let shader = ("ground_fog.wgsl", FOG[1]);
    folder_kind_of(("node.ron", FOG[0]), &[shader]).unwrap_or_else(|errors| panic!("{errors}"))
}

node_kind! {
    /// The distance of what is seen, by a compute kernel.
    pub struct Distance {
        /// A factor.
        pub scale: f32 = 1.0 => within(0.0..=10.0);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("depth", "Depth as the projection writes it.").accepts(&[ColorState::Data]),
        Input::block("eye", &CAMERA, "The camera."),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Data), "The distance.").or_input("depth")];
}

static DISTANCE: Shader = Shader::new(
    "distance.wgsl",
    "import afterimage::camera::{Camera, camera_distance};
struct Distance { scale: f32 }
@group(0) @binding(0) var<uniform> eye: Camera;
@group(0) @binding(1) var<uniform> params: Distance;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var result: texture_storage_2d<rgba16float, write>;
@compute @workgroup_size(8, 8)
fn distance_of(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(result);
    if any(id.xy >= size) { return; }
    let uv = (vec2f(id.xy) + 0.5) / vec2f(size);
    let far = camera_distance(eye, uv, texel(depth, vec2i(id.xy)).x);
    textureStore(result, id.xy, vec4f(params.scale * far, 0.0, 0.0, 1.0));
}",
);

impl Node for Distance {
    fn record(&self, pass: &mut Recorder<'_>) {
        let depth = pass.image("depth");
        let desc = pass.desc(depth).format(Format::Rgba16Float);
        let result = pass.output("result", desc);
        let groups = desc.size.div_up(8);
        pass.compute(&DISTANCE, "distance_of").image("result", result).dispatch([groups.width, groups.height, 1]);
    }
}

fn registry() -> Registry {
    Registry::new(&[afterimage_nodes::ALL, &[fog(), view_depth(), NodeKind::of::<Distance>()]])
        .expect("no two kinds share a name")
}

fn errors_of(text: &str) -> String {
    let document = parse("test.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
    let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
    check(&document, &registry(), &options).expect_err("it has an error").to_string()
}

fn graph(text: &str) -> Graph {
    let document = parse("test.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
    let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
    check(&document, &registry(), &options).unwrap_or_else(|errors| panic!("{errors}")).0
}

/// Two layers of fog, which are fused, and distances.
const BOTH: &str = r#"Pipeline(
    inputs: { "scene": Color, "depth": Depth, "camera": Camera(optional: true), "light": Camera },
    nodes: {
        "low":  GroundFog(source: "scene", depth: "depth", camera: "camera", height: 0.8),
        "high": GroundFog(source: "low", depth: "depth", camera: "light", height: 3.0, color: (0.1, 0.2, 0.9)),
        "far":  Distance(depth: "depth", eye: "light"),
        "view": ViewDepth(depth: "depth", camera: "light", format: R32Float),
    },
    outputs: { "display": "high", "far": "far", "view": "view" },
)"#;

const SIZE: Size = Size { width: 24, height: 16, depth: 1 };

struct Host {
    gpu: Shared,
    post: Post,
    images: [wgpu::TextureView; 2],
}

fn scene(x: u32, y: u32) -> [f32; 4] {
    [0.2 + x as f32 * 0.1, 0.4 + y as f32 * 0.05, (x * y) as f32 * 0.01, 1.0]
}

/// From the near plane to one texel that is infinitely far.
fn depth(x: u32, y: u32) -> [f32; 4] {
    [if (x, y) == (3, 2) { 0.0 } else { 0.01 + 0.04 * x as f32 / (1.0 + y as f32) }, 0.0, 0.0, 1.0]
}

fn camera(height: f32, turn: f32) -> Camera {
    let eye = vec3(1.0, height, 4.0);
    let view = look_to_mat4(eye, vec3(turn, -0.3, -1.0).normalize(), vec3(0.0, 1.0, 0.0));
    let projection = directx::perspective_infinite_reverse(1.1, SIZE.aspect() as f32, 0.1);
    Camera::still(view.to_cols_array_2d(), projection.to_cols_array_2d())
}

impl Host {
    fn new(text: &str) -> Self {
        let gpu = gpu();
        let post = Post::new(&gpu, graph(text));
        let image = |pixel: fn(u32, u32) -> [f32; 4]| {
            let picture = Picture::new(SIZE.width, SIZE.height, pixel);
            let texels = Texels::from_floats(SIZE.width, SIZE.height, &picture.pixels);
            let texture = upload(&gpu.device, &gpu.queue, &texels).unwrap_or_else(|error| panic!("{error}"));
            texture.create_view(&Default::default())
        };
        let images = [image(scene), image(depth)];
        Self { gpu, post, images }
    }

    fn frame(&mut self, blocks: &[(&str, &BlockData)]) -> Result<(), PostError> {
        let Gpu { device, queue, .. } = &*self.gpu;
        let mut encoder = device.create_command_encoder(&Default::default());
        let inputs = &[("scene", &self.images[0]), ("depth", &self.images[1])];
        let recorded = self.post.encode(&mut encoder, &Frame { inputs, blocks, ..Frame::default() });
        queue.submit([encoder.finish()]);
        recorded
    }

    fn shown(&self, name: &str) -> Picture {
        let texels = download(&self.gpu.device, &self.gpu.queue, self.post.output(name).unwrap());
        Picture::of(&texels.unwrap_or_else(|error| panic!("{error}")))
    }
}

/// The place in the world and the distance of what is seen at a pixel.
fn place(camera: &Camera, x: u32, y: u32) -> (DVec4, f64) {
    let matrix = |columns: [[f32; 4]; 4]| DMat4::from_cols_array_2d(&columns.map(|column| column.map(f64::from)));
    let uv = DVec2::new((f64::from(x) + 0.5) / 24.0, (f64::from(y) + 0.5) / 16.0);
    let clip = DVec4::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, f64::from(depth(x, y)[0]), 1.0);
    let seen = matrix(camera.projection).inverse() * clip;
    let seen = (seen / seen.w.max(1e-7)).truncate();
    (matrix(camera.view).inverse() * seen.extend(1.0), -seen.z)
}

fn fogged(light: [f64; 3], height: f64, ends: f64, color: [f64; 3]) -> [f64; 3] {
    let density = (1.0 - height / ends).clamp(0.0, 1.0);
    std::array::from_fn(|i| light[i] + (color[i] - light[i]) * density)
}

fn compare(host: &Host, eye: Option<&Camera>, light: &Camera) {
    let (display, far, view) = (host.shown("display"), host.shown("far"), host.shown("view"));
    let mut fog = 0;
    for (x, y) in (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y))) {
        let source = scene(x, y);
        let mut wanted = [0, 1, 2].map(|i| f64::from(source[i]));
        if let Some(eye) = eye {
            wanted = fogged(wanted, place(eye, x, y).0.y, 0.8, [0.5, 0.6, 0.7]);
        }
        let (world, distance) = place(light, x, y);
        wanted = fogged(wanted, world.y, 3.0, [0.1, 0.2, 0.9]);
        let got = display.at(x, y);
        for i in 0..3 {
            let near = (f64::from(got[i]) - wanted[i]).abs() <= 2e-3 * wanted[i].max(0.1);
            assert!(near, "({x}, {y}): {got:?}, not {wanted:?}");
            fog += usize::from(f64::from(source[i]) != wanted[i]);
        }
        let (got, wanted) = (f64::from(view.at(x, y)[0]), distance.min(65504.0));
        assert!((got - wanted).abs() <= 1e-5 * wanted, "({x}, {y}): {got} m, not {wanted}");
        let got = f64::from(far.at(x, y)[0]);
        assert!((got - wanted).abs() <= 2e-3 * wanted, "({x}, {y}): {got} m, not {wanted}");
    }
    assert!(fog > 100, "there is fog to be seen");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_camera_moves_without_a_plan() {
    let mut host = Host::new(BOTH);
    let cameras = [camera(1.2, 0.1), camera(2.0, -0.4), camera(0.5, 0.3)];
    let mut plan = None;
    for (eye, light) in [(0, 1), (2, 1), (1, 0), (1, 1)] {
        let (eye, light) = (cameras[eye], cameras[light]);
        let blocks = [eye, light].map(|camera| camera.data().expect("its matrices have inverses"));
        host.frame(&[("camera", &blocks[0]), ("light", &blocks[1])]).unwrap_or_else(|error| panic!("{error}"));
        compare(&host, Some(&eye), &light);
        let now = host.post.plan().expect("it renders").clone();
        assert!(Arc::ptr_eq(&now, plan.get_or_insert_with(|| now.clone())), "no plan is made");
    }
    let plan = plan.expect("it renders");
    let labels: Vec<_> = plan.work().map(|pass| pass.label.clone()).collect();
    // Fused, they have uniform buffers for two cameras, their parameters and the size.
    let is_one = labels.contains(&"ground_fog + ground_fog".to_owned());
    assert_eq!(is_one, host.gpu.caps.max_fused_uniform_buffers >= 4, "both layers of fog: {labels:?}");
    assert_eq!(plan.blocks.iter().map(|planned| planned.name.as_str()).collect::<Vec<_>>(), ["camera", "light"]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn without_a_camera_its_nodes_are_skipped_or_it_is_an_error() {
    let mut host = Host::new(BOTH);
    let light = camera(2.0, -0.4);
    let data = light.data().expect("its matrices have inverses");
    host.frame(&[("light", &data)]).unwrap_or_else(|error| panic!("{error}"));
    compare(&host, None, &light);
    let skipped = &host.post.plan().expect("it renders").savings.skipped;
    assert_eq!(skipped[0].why, "nothing arrives at its input `camera`");
    let error = host.frame(&[("camera", &data)]).expect_err("`light` is not optional").to_string();
    assert_eq!(error, "no Camera was given for input `light`: set it in `Frame::blocks`");
    let given = HostInputs::none(SIZE);
    assert!(host.post.plan_for(given).is_err());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_parameter_that_changes_leaves_the_camera_as_it_is() {
    let mut host = Host::new(BOTH);
    let (eye, light) = (camera(1.2, 0.1), camera(2.0, -0.4));
    let blocks = [eye, light].map(|camera| camera.data().expect("its matrices have inverses"));
    let blocks = [("camera", &blocks[0]), ("light", &blocks[1])];
    host.frame(&blocks).unwrap_or_else(|error| panic!("{error}"));
    let height = host.post.parameter::<f32>("low.height").expect("there is one");
    host.frame(&blocks).unwrap_or_else(|error| panic!("{error}"));
    host.post.finish_changes().unwrap_or_else(|error| panic!("{error}"));
    host.post.set(height, 50.0).expect("it is in its domain");
    host.frame(&blocks).unwrap_or_else(|error| panic!("{error}"));
    let raised = host.shown("display");
    host.post.set(height, 0.8).expect("it is in its domain");
    host.frame(&blocks).unwrap_or_else(|error| panic!("{error}"));
    compare(&host, Some(&eye), &light);
    assert!(raised.pixels != host.shown("display").pixels);
}

#[test]
fn the_kinds_keep_the_contract() {
    assert_eq!(contract(&[fog(), view_depth(), NodeKind::of::<Distance>()]), Ok(Vec::new()));
}

#[test]
fn mistakes_with_blocks_are_diagnostics() {
    let unknown = errors_of(&BOTH.replace("\"light\": Camera", "\"light\": Camra"));
    assert!(unknown.contains("no input type is called `Camra`") && unknown.contains("`Camera`?"), "{unknown}");
    let image = errors_of(&BOTH.replace("camera: \"light\"", "camera: \"scene\""));
    assert!(image.contains("accepts a Block, but the input `scene` is an Image"), "{image}");
    let block = errors_of(&BOTH.replace("source: \"scene\"", "source: \"light\""));
    assert!(block.contains("is a Block"), "{block}");
    let shown = errors_of(&BOTH.replace("\"far\": \"far\",", "\"far\": \"light\","));
    assert!(shown.contains("is a Block"), "{shown}");
    let shader = (
        "ground_fog.wgsl",
        "struct Eye { view: mat4x4f }
fn ground_fog(source: vec4f, depth: texture_2d<f32>, camera: Eye) -> vec4f { return camera.view * source; }",
    );
    let errors = folder_kind_of(("node.ron", FOG[0]), &[shader]).expect_err("its struct is another one").to_string();
    assert!(errors.contains("has not the members of the block `Camera`"), "{errors}");
}

#[test]
fn numbers_of_blocks_are_checked() {
    let mut data = BlockData::new(&CAMERA);
    assert_eq!(data.get("view"), Some(Mat4::IDENTITY.to_cols_array().to_vec()));
    assert_eq!(data.set("jitter", &[0.5, -0.25]), Ok(()));
    assert_eq!(data.get("jitter"), Some(vec![0.5, -0.25]));
    assert!(data.set("jitter", &[f32::NAN, 0.0]).is_err_and(|why| why.contains("NaN")));
    assert!(data.set("jitter", &[0.0]).is_err_and(|why| why == "`Camera.jitter` takes 2 numbers, not 1"));
    assert!(data.set("jiter", &[0.0]).is_err_and(|why| why.contains("jitter")));
    let flat = Camera { view: [[0.0; 4]; 4], ..camera(1.0, 0.0) };
    assert_eq!(flat.data(), Err("`Camera.view` has no inverse".into()));
    assert_eq!(CAMERA.bytes(), 400);
}

/// Values that a host may put into a block one by one: any finite numbers.
const HOSTILE: [f32; 10] = [0.0, -0.0, 1.0, -1.0, 1e-45, 1e-7, 1e30, -1e30, f32::MAX, f32::MIN];

/// A camera of such numbers: matrices without an inverse, of zeros, and of numbers beyond half floats.
fn hostile_camera(rng: &mut Rng) -> BlockData {
    let mut data = camera(1.2, 0.1).data().expect("its matrices have inverses");
    for field in CAMERA.fields {
        let known = data.get(field.name).expect("it is a field");
        let number = HOSTILE[rng.below(HOSTILE.len())];
        let numbers: Vec<f32> = match rng.below(5) {
            0 => known.clone(),
            1 => vec![0.0; known.len()],
            2 => vec![number; known.len()],
            3 => known.iter().enumerate().map(|(at, known)| if at % 4 == 2 { 0.0 } else { *known }).collect(),
            _ => known.iter().map(|_| HOSTILE[rng.below(HOSTILE.len())]).collect(),
        };
        data.set(field.name, &numbers).expect("they are finite");
        let mut wrong = numbers.clone();
        wrong[rng.below(numbers.len())] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][rng.below(3)];
        assert!(data.set(field.name, &wrong).is_err(), "`{}` takes {wrong:?}", field.name);
        assert_eq!(data.get(field.name), Some(numbers), "what is refused changes nothing");
    }
    data
}

/// Whatever the host's camera and depth hold, the kinds of folders give finite pixels, and the device lives.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn no_camera_and_no_depth_make_a_pixel_that_is_not_finite() {
    const BAD: [f32; 8] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 0.0, -1.0, 1e-45];
    let mut host = Host::new(BOTH);
    let (gpu, good) = (gpu(), host.images.clone());
    let light = camera(2.0, -0.4);
    let tame = light.data().expect("its matrices have inverses");
    let mut rng = Rng::new(17);
    for round in 0..60 {
        let image = |rng: &mut Rng| {
            let pixels = (0..SIZE.width * SIZE.height * 4).map(|_| BAD[rng.below(BAD.len())]).collect::<Vec<f32>>();
            let texels = Texels::from_floats(SIZE.width, SIZE.height, pixels.as_chunks().0);
            let texture = upload(&gpu.device, &gpu.queue, &texels).unwrap_or_else(|error| panic!("{error}"));
            texture.create_view(&Default::default())
        };
        host.images = if round % 3 == 0 { [image(&mut rng), image(&mut rng)] } else { good.clone() };
        let blocks = [hostile_camera(&mut rng), if round % 2 == 0 { tame.clone() } else { hostile_camera(&mut rng) }];
        host.frame(&[("camera", &blocks[0]), ("light", &blocks[1])]).unwrap_or_else(|error| panic!("{error}"));
        for name in ["display", "view"] {
            let shown = host.shown(name);
            let bad = shown.pixels.iter().position(|pixel| pixel.iter().any(|number| !number.is_finite()));
            assert_eq!(bad, None, "`{name}` of round {round}: {:?}", bad.map(|at| shown.pixels[at]));
        }
    }
    host.images = good;
    host.frame(&[("light", &tame)]).unwrap_or_else(|error| panic!("{error}"));
    compare(&host, None, &light);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_block_that_is_missing_is_an_error_of_its_frame() {
    let mut host = Host::new(BOTH);
    let data = camera(2.0, -0.4).data().expect("its matrices have inverses");
    host.frame(&[("camera", &data), ("light", &data)]).unwrap_or_else(|error| panic!("{error}"));
    let Gpu { device, queue, .. } = (*host.gpu).clone();
    let mut encoder = device.create_command_encoder(&Default::default());
    let inputs = &[("scene", &host.images[0]), ("depth", &host.images[1])];
    let blocks = &[("light", &data)];
    let error = host.post.executor().encode(&mut encoder, &Frame { inputs, blocks, ..Frame::default() });
    assert!(matches!(&error, Err(GpuError::MissingBlock { port, ty: "Camera" }) if port == "camera"), "{error:?}");
    queue.submit([encoder.finish()]);
}
