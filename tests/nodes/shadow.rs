//! Shadows on the GPU, against rays in the built-in scene, and what their CPU reference does not say.

use afterimage_graph::image::Size;
use afterimage_graph::node::{CAMERA, Camera, NodeKind, Registry};
use afterimage_graph::prelude::*;
use afterimage_nodes::DemoScene;
use glam::camera::rh::proj::directx;
use glam::camera::rh::view::look_at_mat4;
use glam::{Mat4, Vec3, vec3};

use super::surface::eye;
use crate::support::gpu::{Picture, Run};
use crate::support::harness::Nodes;

params! {
    /// The depth map that a light sees of the built-in scene, by rays.
    pub struct DepthMap {
        /// The map's side.
        pub side: u32 = 512 => within(1.0..=4096.0);
    }
}

params! {
    /// The share of a light that the built-in scene blocks, by rays to it: 0 or 1.
    pub struct ShadowRays {
    }
}

static ROOM: Library = Library::new(afterimage_shaders::DEMO);
static RAYS: Shader = Shader::new(
    "shadow_rays.wgsl",
    "#import camera
#import loft
#import loft_pose
#import ray
#import surface
fn depth_map(light: Camera, at: Point) -> vec4f {
    let place = camera_place(light, at.uv, 1.0);
    let is_perspective = light.projection[2].w != 0.0;
    let start = camera_world(light, select(vec3f(place.xy, 0.0), vec3f(), is_perspective));
    let there = camera_world(light, place);
    let hit = loft_trace(Ray(start, ray_direction(normalize(there - start))), loft_pose(0.0, 0));
    let found = light.view * vec4f(start + normalize(there - start) * hit.distance, 1.0);
    let clip = light.projection * found;
    return vec4f(clip.z / clip.w, 0.0, 0.0, 1.0);
}
fn shadow_rays(depth: vec4f, normal: vec4f, camera: Camera, light: Camera, at: Point) -> vec4f {
    let place = camera_world(camera, camera_place(camera, at.uv, depth.x));
    let n = normalize((camera.inverse_view * vec4f(normal.xyz, 0.0)).xyz);
    let is_perspective = light.projection[2].w != 0.0;
    let seen = (light.view * vec4f(place, 1.0)).xyz;
    let lamp = select(place - seen.z * light.inverse_view[2].xyz, light.inverse_view[3].xyz, is_perspective);
    let way = lamp - place;
    let far = loft_trace(Ray(place + n * 2e-3, ray_direction(normalize(way))), loft_pose(0.0, 0)).distance;
    let is_blocked = dot(n, way) <= 0.0 || far < length(way) - 4e-3;
    let uv = camera_uv(light, seen).xy;
    let is_shown = seen.z < 0.0 && all(abs(uv - 0.5) < vec2f(0.5));
    return vec4f(select(0.0, 1.0, dot(n, way) <= 0.0 || (is_blocked && is_shown)), 0.0, 0.0, 1.0);
}",
)
.with_library(&ROOM);

impl Node for DepthMap {
    const INPUTS: &'static [Input] = &[Input::block("light", &CAMERA, "The camera at the light.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Data), "The depth map.")];

    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = ImageDesc::new(Size::new(self.side, self.side)).format(Format::R32Float);
        pass.function(&RAYS, "depth_map").write("result", desc);
    }
}

impl Node for ShadowRays {
    const INPUTS: &'static [Input] = &[
        Input::image("depth", "Distances.").accepts(&[ColorState::Data]),
        Input::image("normal", "Normals.").accepts(&[ColorState::Data]),
        Input::block("camera", &CAMERA, "The camera."),
        Input::block("light", &CAMERA, "The camera at the light."),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Data), "The share.").or_input("depth")];

    fn record(&self, pass: &mut Recorder<'_>) {
        let size = pass.frame_size();
        pass.function(&RAYS, "shadow_rays").write("result", ImageDesc::new(size));
    }
}

const SIZE: Size = Size { width: 240, height: 135, depth: 1 };

/// Lights of the room: a lamp under the ceiling, with the near plane at depth 1, and parallel light from the ceiling, with
/// the near plane at depth 0.
fn lights() -> [(&'static str, Camera); 2] {
    let lamp = look_at_mat4(vec3(-0.8, 3.2, 2.6), vec3(0.6, 0.4, -1.2), Vec3::Y);
    let sun = look_at_mat4(vec3(0.9, 3.1, 1.2), vec3(-0.3, 0.0, 0.0), Vec3::Y);
    let of = |view: Mat4, projection: Mat4| Camera::still(view.to_cols_array_2d(), projection.to_cols_array_2d());
    [
        ("a lamp", of(lamp, directx::perspective_infinite_reverse(1.7, 1.0, 0.1))),
        ("parallel light", of(sun, directx::orthographic(-1.8, 1.8, -1.8, 1.8, 0.0, 8.0))),
    ]
}

/// Shares of a light that the scene blocks: by rays, and by `ShadowMask` with these parameters.
fn shares(light: &Camera, side: u32, parameters: &str) -> [Picture; 2] {
    let text = format!(
        r#"Pipeline(inputs: {{ "camera": Camera, "light": Camera }}, nodes: {{
            "room": DemoScene(walk: 0.15),
            "map": DepthMap(light: "light", side: {side}),
            "rays": ShadowRays(depth: "room.depth", normal: "room.normal", camera: "camera", light: "light"),
            "mask": ShadowMask(source: "room", depth: "room.depth", camera: "camera", map: "map", light: "light",
                               {parameters}),
        }}, outputs: {{ "rays": "rays", "mask": "mask.shadow" }})"#
    );
    let own = &[NodeKind::of::<DepthMap>(), NodeKind::of::<ShadowRays>()];
    let registry = Registry::new(&[afterimage_nodes::ALL, own]).expect("kinds of their own");
    let document = afterimage_graph::document::parse("test.ron", &text).unwrap_or_else(|errors| panic!("{errors}"));
    let checked = afterimage_graph::check::check(&document, &registry, &Default::default());
    let graph = checked.unwrap_or_else(|errors| panic!("{errors}")).0;
    let camera = DemoScene { walk: 0.15, ..DemoScene::default() }.camera(SIZE);
    let mut run = Run::new(&graph).camera(Some(&camera)).block("light", light);
    run.size = SIZE;
    run.frame(&[]).try_into().expect("two outputs")
}

/// Root mean square of the error of a share, over all pixels; the first is without a shadow.
fn errors([rays, mask]: &[Picture; 2]) -> [f64; 2] {
    let square = |off: f32| f64::from(off).powi(2);
    let pairs = || rays.pixels.iter().zip(&mask.pixels);
    let sums = [
        pairs().map(|(rays, _)| square(rays[0])).sum::<f64>(),
        pairs().map(|(rays, mask)| square(mask[0] - rays[0])).sum(),
    ];
    sums.map(|sum| (sum / rays.pixels.len() as f64).sqrt())
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/depth.md")]
fn shadows_are_near_to_those_of_rays() {
    // The most that is left of the error, as a share of that without a shadow. Without a bias all surfaces shadow
    // themselves.
    let table = [
        ("kernel: 1", 0.5),
        ("kernel: 3", 0.5),
        ("kernel: 7", 0.55),
        ("kernel: 3, pattern: Disc", 0.5),
        ("normal: \"room.normal\"", 0.5),
        ("slope_bias: 0.0, normal_bias: 1.5, normal: \"room.normal\"", 0.5),
        ("slope_bias: 0.0, bias: 0.0", f64::INFINITY),
    ];
    for (name, light) in lights() {
        for side in [512, 2048] {
            let errors = table.map(|(parameters, most)| {
                let [none, with] = errors(&shares(&light, side, parameters));
                println!("{name}, {side}, {parameters}: {with:.4} instead of {none:.4}");
                assert!(with < most * none, "{name}, {parameters}: {with} instead of {none}");
                with
            });
            assert!(errors[6] > 1.5 * errors[1], "{name}: a bias helps");
        }
    }
}

/// A plane as the eye sees it: the inverse of the distance is linear in the image.
fn plane(side: u32, [across, down]: [f32; 2]) -> Picture {
    Picture::new(side, side, |x, y| {
        let [u, v] = [x, y].map(|at| (at as f32 + 0.5) / side as f32);
        [1.0 / (0.3 + across * u + down * v), 0.0, 0.0, 1.0]
    })
}

/// What the eye's projection, whose near plane is at depth 1, writes for distances.
fn written(distances: &Picture) -> Picture {
    Picture::new(distances.width, distances.height, |x, y| [0.1 / distances.at(x, y)[0], 0.0, 0.0, 1.0])
}

/// The share of the eye's own light that is blocked.
fn shadow(parameters: &str, depth: &Picture, map: &Picture) -> Picture {
    let text = format!(
        "\"mask\": ShadowMask(source: \"in\", depth: \"depth\", camera: \"camera\", map: \"map\", light: \"camera\", \
         {parameters}) -> mask.shadow"
    );
    let inputs = [("in", "Color"), ("depth", "Depth"), ("map", "Depth")];
    let grey = Picture::new(depth.width, depth.height, |_, _| [0.5, 0.4, 0.3, 0.2]);
    Nodes::new(&text, &inputs).camera(Some(&eye())).exact(&[&grey, depth, map])
}

/// The light sees a sloping plane in texels that are six times as large as pixels.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_plane_never_shadows_itself_with_a_slope_bias_of_one() {
    for slope in [[0.0, 0.0], [0.25, 0.0], [0.0, -0.2], [0.4, 0.3], [1.5, -0.1]] {
        let (depth, map) = (plane(96, slope), written(&plane(16, slope)));
        for kernel in 1..=7 {
            for pattern in ["Square", "Disc"] {
                let of = |bias: &str| {
                    let found = shadow(&format!("kernel: {kernel}, pattern: {pattern}, {bias}"), &depth, &map);
                    found.pixels.iter().map(|pixel| pixel[0]).fold(0.0, f32::max)
                };
                assert_eq!(of("bias: 0.001"), 0.0, "{slope:?}, {kernel}, {pattern}");
                let acne = of("bias: 0.001, slope_bias: 0.0");
                assert!(slope == [0.0; 2] || acne > 0.1, "{slope:?}, {kernel}, {pattern}: {acne} without a slope bias");
            }
        }
    }
}

/// A wall one metre before the plane, in the left half of the map.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_shadow_has_its_sides_and_an_edge_as_wide_as_the_kernel() {
    let depth = Picture::new(64, 16, |_, _| [3.0, 0.0, 0.0, 1.0]);
    let map = Picture::new(64, 16, |x, _| [0.1 / if x < 32 { 2.0 } else { 3.0 }, 0.0, 0.0, 1.0]);
    for kernel in [1, 2, 5] {
        let found = shadow(&format!("kernel: {kernel}"), &depth, &map);
        let row: Vec<f32> = (0..64).map(|x| found.at(x, 8)[0]).collect();
        let soft = row.iter().filter(|share| (0.001..0.999).contains(*share)).count();
        assert!(row[8..24].iter().all(|share| *share == 1.0) && row[40..].iter().all(|share| *share == 0.0));
        assert!(row[8..].is_sorted_by(|a, b| a >= b) && soft < kernel + 1, "{kernel}: {row:?}");
    }
}

/// What the map does not show is lit, and so is the sky.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_the_map_does_not_show_is_lit() {
    let near = Picture::new(16, 16, |_, _| [1.0, 0.0, 0.0, 1.0]);
    let sky = Picture::new(16, 16, |x, _| [if x < 8 { 65504.0 } else { 5.0 }, 0.0, 0.0, 1.0]);
    let found = shadow("kernel: 1", &sky, &near);
    assert!((0..8).all(|x| found.at(x, 3)[0] == 0.0) && (8..16).all(|x| found.at(x, 3)[0] == 1.0));
}

/// Depths and normals that are not finite, and maps of nothing: the shares are shares.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn broken_depths_and_maps_give_shares_from_0_to_1() {
    let odd = [f32::NAN, f32::INFINITY, -5.0, 0.0, 1e30, 65504.0, 1e-30, 2.0, 1.0];
    let data = Picture::new(24, 16, |x, y| [odd[((3 * x + 5 * y) % 9) as usize]; 4]);
    for parameters in
        ["kernel: 7", "pattern: Disc", "normal: \"depth\", normal_bias: 8.0", "slope_bias: 8.0, bias: 100.0"]
    {
        let found = shadow(parameters, &data, &data);
        assert!(found.pixels.iter().all(|pixel| (0.0..=1.0).contains(&pixel[0])), "{parameters}");
    }
}

/// A fallback without a shadow: nothing is blocked, and the light is the source.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_amount_of_nothing_blocks_nothing() {
    let depth = plane(16, [0.2, 0.1]);
    let found = shadow("amount: 0.0", &depth, &depth);
    assert!(found.pixels.iter().all(|pixel| pixel[..3] == [0.0; 3]));
}
