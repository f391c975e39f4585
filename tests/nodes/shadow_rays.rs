//! Shadows on the GPU, against rays in the built-in scene.

use std::ops::RangeInclusive;

use afterimage_graph::image::Size;
use afterimage_graph::node::{CAMERA, Camera, NodeKind};
use afterimage_graph::prelude::*;
use afterimage_nodes::DemoScene;
use glam::camera::rh::proj::directx;
use glam::camera::rh::view::look_at_mat4;
use glam::{Vec3, vec3};

use super::surface::scene;
use crate::support::docs;
use crate::support::gpu::{Picture, Run, graph_with};

node_kind! {
    /// The depth map that a light sees of the built-in scene, by rays.
    pub struct DepthMap {
        /// The map's side.
        pub side: u32 = 512 => within(1.0..=4096.0);
    }

    const INPUTS: &'static [Input] = &[Input::block("light", &CAMERA, "The camera at the light.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Data), "The depth map.")];
}

node_kind! {
    /// The share of a light that the built-in scene blocks, by rays to it: 0 or 1 for a light without a size.
    pub struct ShadowRays {
        /// The diameter of a light with a perspective, in meters: a disc across its axis.
        pub diameter: f32 = 0.0 => within(0.0..=10.0);
        /// The angular diameter of a light with parallel rays, in degrees.
        pub angular_diameter: f32 = 0.0 => within(0.0..=90.0);
        /// Rays for each pixel.
        pub rays: u32 = 1 => within(1.0..=256.0);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("depth", "Distances.").accepts(&[ColorState::Data]),
        Input::image("normal", "Normals.").accepts(&[ColorState::Data]),
        Input::block("camera", &CAMERA, "The camera."),
        Input::block("light", &CAMERA, "The camera at the light."),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Data), "The share.").or_input("depth")];
}

static ROOM: Library = Library::new(afterimage_shaders::DEMO);
static RAYS: Shader = Shader::new(
    "shadow_rays.wgsl",
    "import afterimage::camera::{Camera, camera_place, camera_uv, camera_world};
import package::loft::loft_trace;
import package::loft_pose::loft_pose;
import package::ray::{Ray, ray_direction};
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
struct ShadowRays { diameter: f32, tangent: f32, rays: i32 }
// Textures and not pixels: the module shall not have the uniform of the scene, too, because Mesa 22 crashes with four.
fn shadow_rays(
    depth: texture_2d<f32>,
    normal: texture_2d<f32>,
    camera: Camera,
    light: Camera,
    at: Point,
    params: ShadowRays,
) -> vec4f {
    let place = camera_world(camera, camera_place(camera, at.uv, texel(depth, at.pixel).x));
    let n = normalize((camera.inverse_view * vec4f(texel(normal, at.pixel).xyz, 0.0)).xyz);
    let is_perspective = light.projection[2].w != 0.0;
    let seen = (light.view * vec4f(place, 1.0)).xyz;
    let way = light.inverse_view[3].xyz - place;
    let toward = select(light.inverse_view[2].xyz, normalize(way), is_perspective);
    let uv = camera_uv(light, seen).xy;
    let is_shown = seen.z < 0.0 && all(abs(uv - 0.5) < vec2f(0.5));
    if dot(n, toward) <= 0.0 { return vec4f(1.0, 0.0, 0.0, 1.0); }
    if !is_shown { return vec4f(0.0, 0.0, 0.0, 1.0); }
    // To points on a disc across the axis of the light, which is at its camera.
    let radius = select(params.tangent * -seen.z, 0.5 * params.diameter, is_perspective);
    let middle = select(-seen.z * toward, way, is_perspective);
    var blocked = 0.0;
    for (var i = 0; i < params.rays; i++) {
        let angle = 6.2831853 * fract(f32(i) * 0.618034);
        let far = radius * sqrt((f32(i) + 0.5) / f32(params.rays));
        let aside = light.inverse_view[0].xyz * cos(angle) + light.inverse_view[1].xyz * sin(angle);
        let point = middle + far * aside;
        let hit = loft_trace(Ray(place + n * 2e-3, ray_direction(point)), loft_pose(0.0, 0)).distance;
        blocked += select(0.0, 1.0, hit < length(point) - 4e-3);
    }
    return vec4f(blocked / f32(params.rays), 0.0, 0.0, 1.0);
}
",
)
.with_library(&ROOM);

impl Node for DepthMap {
    fn record(&self, pass: &mut Recorder<'_>) {
        let desc = ImageDesc::new(Size::new(self.side, self.side)).format(Format::R32Float);
        pass.function(&RAYS, "depth_map").write("result", desc);
    }
}

impl Node for ShadowRays {
    fn record(&self, pass: &mut Recorder<'_>) {
        let tangent = f64::from(0.5 * self.angular_diameter).to_radians().tan();
        let size = pass.frame_size;
        pass.function(&RAYS, "shadow_rays").set("tangent", tangent).write("result", ImageDesc::new(size));
    }
}

const SIZE: Size = Size { width: 240, height: 135, depth: 1 };

/// A lamp under the ceiling, with the near plane at depth 1.
pub(super) fn lamp() -> Camera {
    let view = look_at_mat4(vec3(-0.8, 3.2, 2.6), vec3(0.6, 0.4, -1.2), Vec3::Y);
    let projection = directx::perspective_infinite_reverse(1.7, 1.0, 0.1);
    Camera::still(view.to_cols_array_2d(), projection.to_cols_array_2d())
}

/// Parallel rays past the lantern, the table and the pouf to the wall on the right, with the near plane at depth 0.
fn sun() -> Camera {
    let view = look_at_mat4(vec3(-2.5, 2.6, -0.3), vec3(4.0, 1.2, -1.0), Vec3::Y);
    let projection = directx::orthographic(-2.4, 2.4, -1.3, 1.3, 0.0, 8.0);
    Camera::still(view.to_cols_array_2d(), projection.to_cols_array_2d())
}

/// Shares of a light that the scene blocks: by rays, and by `ShadowMask`, with these parameters.
fn shares(light: &Camera, (side, size): (u32, Size), [rays, mask]: [&str; 2]) -> [Picture; 2] {
    let text = format!(
        r#"Pipeline(inputs: {{ "camera": Camera, "light": Camera }}, nodes: {{
            "room": DemoScene(walk: 0.15),
            "map": DepthMap(light: "light", side: {side}),
            "rays": ShadowRays(depth: "room.depth", normal: "room.normal", camera: "camera", light: "light", {rays}),
            "mask": ShadowMask(source: "room", depth: "room.depth", camera: "camera", map: "map", light: "light",
                               {mask}),
        }}, outputs: {{ "rays": "rays", "mask": "mask.shadow" }})"#
    );
    let own = &[NodeKind::of::<DepthMap>(), NodeKind::of::<ShadowRays>()];
    let camera = DemoScene { walk: 0.15, ..DemoScene::default() }.camera(size);
    let graph = graph_with(&text, own);
    let mut run = Run::new(&graph).camera(Some(&camera)).block("light", light);
    run.size = size;
    run.frame(&[]).try_into().expect("two outputs")
}

/// Root mean square of the error of a share over the pixels of the room whose share by rays is in a range; the first is
/// without a shadow.
fn errors([rays, mask]: [&Picture; 2], depth: &Picture, among: RangeInclusive<f32>) -> [f64; 2] {
    let square = |off: f32| f64::from(off).powi(2);
    let mut sums = [0.0; 2];
    let mut count = 0.0;
    for ((rays, mask), depth) in rays.pixels.iter().zip(&mask.pixels).zip(&depth.pixels) {
        // The sky has no normal.
        if depth[0] < 900.0 && among.contains(&rays[0]) {
            sums = [sums[0] + square(rays[0]), sums[1] + square(mask[0] - rays[0])];
            count += 1.0;
        }
    }
    sums.map(|sum| (sum / count).sqrt())
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/depth.md")]
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
            let [rays, mask] = shares(&lamp(), (side, SIZE), ["", parameters]);
            let [none, with] = errors([&rays, &mask], &depth, 0.0..=1.0);
            println!("{side}, {parameters}: {with:.4} instead of {none:.4}");
            assert!(with < most * none, "{parameters}: {with} instead of {none}");
            with
        });
        assert!(errors[6] > 1.5 * errors[1], "a bias helps");
    }
}

/// Lights of some size: the name, the camera, and the size as rays and `ShadowMask` take it.
fn wide_lights() -> [(&'static str, Camera, [&'static str; 2]); 2] {
    [
        ("lamp", lamp(), ["diameter: 0.3", "light_diameter: 0.3"]),
        ("sun", sun(), ["angular_diameter: 6.0", "angular_diameter: 6.0, largest: 0.15"]),
    ]
}

/// Root mean squares of the errors in the room, and in the penumbrae alone.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/depth.md")]
fn a_search_of_blockers_comes_nearer_to_lights_of_some_size() {
    let depth = scene("depth", "walk: 0.15", SIZE);
    for (name, light, [rays, size]) in wide_lights() {
        let found = |more: &str| {
            let mask = format!("normal: \"room.normal\", {more}");
            let [rays, mask] = shares(&light, (1024, SIZE), [&format!("{rays}, rays: 128"), &mask]);
            let room = errors([&rays, &mask], &depth, 0.0..=1.0);
            let soft = errors([&rays, &mask], &depth, 0.02..=0.98);
            println!("{name}, {more}: {:.4} and {:.4} instead of {:.4} and {:.4}", room[1], soft[1], room[0], soft[0]);
            [room[1], soft[1]]
        };
        let hard = ["kernel: 1", "kernel: 3", "kernel: 7"].map(found);
        let least = [0, 1].map(|of| hard.iter().map(|errors| errors[of]).fold(f64::INFINITY, f64::min));
        let most = found(&format!("{size}, blocker_taps: 64, taps: 64"));
        for (more, [room, soft]) in
            [("", [0.9, 0.95]), (", blocker_taps: 16", [0.95, 1.0]), (", blocker_taps: 8", [1.0, 1.3])]
        {
            let errors = found(&format!("{size}{more}"));
            assert!(errors[0] < room * least[0] && errors[1] < soft * least[1], "{name}{more}: {errors:?}, {least:?}");
            assert!(most[1] < errors[1], "{name}{more}: more taps are better");
        }
    }
}

/// With `AFTERIMAGE_WRITE_DOCS=1` this writes a picture of parallel light: rays, no search, a search, more taps.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_picture_of_penumbrae_is_drawn() {
    let size = if docs::are_written() { Size::new(480, 270) } else { Size::new(48, 27) };
    let depth = scene("depth", "walk: 0.15", size);
    let [_, (_, light, [rays, angle])] = wide_lights();
    let shares = |mask: &str| {
        let mask = format!("normal: \"room.normal\", {mask}");
        shares(&light, (1024, size), [&format!("{rays}, rays: 128"), &mask])
    };
    let ([rays, hard], [_, soft]) = (shares("kernel: 3"), shares(angle));
    let [_, best] = shares(&format!("{angle}, blocker_taps: 64, taps: 64"));
    assert!(soft.pixels != hard.pixels, "the search does something");
    let panels = [rays, hard, soft, best].map(|shares| {
        Picture::new(size.width, size.height, |x, y| {
            // The sky is no surface.
            let share = if depth.at(x, y)[0] > 900.0 { 0.0 } else { shares.at(x, y)[0] };
            [0.9 - 0.8 * share, 0.9 - 0.8 * share, 0.9 - 0.8 * share, 1.0]
        })
    });
    docs::write_panels("penumbrae.jpg", 2, &panels);
}
