//! Shadows on the GPU, against rays in the built-in scene.

use afterimage_graph::image::Size;
use afterimage_graph::node::{CAMERA, Camera, NodeKind, Registry};
use afterimage_graph::prelude::*;
use afterimage_nodes::DemoScene;
use glam::camera::rh::proj::directx;
use glam::camera::rh::view::look_at_mat4;
use glam::{Vec3, vec3};

use super::surface::scene;
use crate::support::gpu::{Picture, Run};

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
// Textures and not pixels: the module shall not have the uniform of the scene, too, because Mesa 22 crashes with four.
fn shadow_rays(
    depth: texture_2d<f32>,
    normal: texture_2d<f32>,
    camera: Camera,
    light: Camera,
    at: Point,
) -> vec4f {
    let place = camera_world(camera, camera_place(camera, at.uv, texel(depth, at.pixel).x));
    let n = normalize((camera.inverse_view * vec4f(texel(normal, at.pixel).xyz, 0.0)).xyz);
    let is_perspective = light.projection[2].w != 0.0;
    let seen = (light.view * vec4f(place, 1.0)).xyz;
    let way = light.inverse_view[3].xyz - place;
    let towards = select(light.inverse_view[2].xyz, normalize(way), is_perspective);
    let reach = select(-seen.z, length(way), is_perspective);
    let far = loft_trace(Ray(place + n * 2e-3, ray_direction(towards)), loft_pose(0.0, 0)).distance;
    let is_blocked = far < reach - 4e-3;
    let uv = camera_uv(light, seen).xy;
    let is_shown = seen.z < 0.0 && all(abs(uv - 0.5) < vec2f(0.5));
    return vec4f(select(0.0, 1.0, dot(n, towards) <= 0.0 || (is_blocked && is_shown)), 0.0, 0.0, 1.0);
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

/// A lamp under the ceiling, with the near plane at depth 1.
fn lamp() -> Camera {
    let view = look_at_mat4(vec3(-0.8, 3.2, 2.6), vec3(0.6, 0.4, -1.2), Vec3::Y);
    let projection = directx::perspective_infinite_reverse(1.7, 1.0, 0.1);
    Camera::still(view.to_cols_array_2d(), projection.to_cols_array_2d())
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

/// Root mean square of the error of a share, over the pixels of the room; the first is without a shadow.
fn errors([rays, mask]: &[Picture; 2], depth: &Picture) -> [f64; 2] {
    let square = |off: f32| f64::from(off).powi(2);
    let mut sums = [0.0; 2];
    let mut count = 0.0;
    for ((rays, mask), depth) in rays.pixels.iter().zip(&mask.pixels).zip(&depth.pixels) {
        // The sky has no normal.
        if depth[0] < 900.0 {
            sums = [sums[0] + square(rays[0]), sums[1] + square(mask[0] - rays[0])];
            count += 1.0;
        }
    }
    sums.map(|sum| (sum / count).sqrt())
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
    let depth = scene("depth", "walk: 0.15", SIZE);
    for side in [512, 2048] {
        let errors = table.map(|(parameters, most)| {
            let [none, with] = errors(&shares(&lamp(), side, parameters), &depth);
            println!("{side}, {parameters}: {with:.4} instead of {none:.4}");
            assert!(with < most * none, "{parameters}: {with} instead of {none}");
            with
        });
        assert!(errors[6] > 1.5 * errors[1], "a bias helps");
    }
}
