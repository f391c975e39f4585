//! Ambient occlusion and bilateral blurs on the GPU: what their CPU references do not say.

use afterimage_graph::image::Size;
use afterimage_graph::node::{CAMERA, Camera, NodeKind, Registry};
use afterimage_graph::prelude::*;
use afterimage_nodes::DemoScene;
use glam::camera::rh::proj::directx;
use glam::{Mat4, Quat, Vec3, vec3};

use super::surface::{eye, scene};
use crate::support::gpu::{Picture, Run};
use crate::support::harness::Nodes;

/// A surface that rises and falls before a step, in meters, and in all three numbers normals that turn with it.
pub(super) fn surfaces([width, height]: [u32; 2]) -> Picture {
    Picture::new(width, height, |x, y| {
        let (u, v) = (x as f32 / width as f32, y as f32 / height as f32);
        let step = if 2 * x > width { 1.7 } else { 0.0 };
        let depth = 3.0 + 0.9 * (9.0 * u + 3.0 * v).sin() + step;
        [depth, 3.1 * (7.0 * u).cos() + 2.0 * v, 4.3 + 2.0 * v, 1.0]
    })
}

node_kind! {
    /// The openness of the built-in scene by rays: the cosine-weighted mean, with the fading of `Gtao`.
    pub struct Rays {
        /// The distance from which nothing occludes.
        pub radius: f32 = 0.6 => within(0.0..=10.0);
        /// The last part of it, over which occluders fade out.
        pub falloff: f32 = 0.6 => within(0.0..=1.0);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("depth", "Distances.").accepts(&[ColorState::Data]),
        Input::image("normal", "Normals.").accepts(&[ColorState::Data]),
        Input::block("camera", &CAMERA, "The camera."),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Data), "The visibility.").or_input("depth")];
}

static ROOM: Library = Library::new(afterimage_shaders::DEMO);
static RAYS: Shader = Shader::new(
    "rays.wgsl",
    "import afterimage::camera::{Camera, camera_place, camera_world};
import package::loft::loft_trace;
import package::loft_pose::loft_pose;
import package::ray::{Ray, ray_direction};
struct Rays { radius: f32, falloff: f32 }
fn rays(depth: vec4f, normal: vec4f, camera: Camera, at: Point, params: Rays) -> vec4f {
    let eye = camera_world(camera, camera_place(camera, at.uv, depth.x));
    let n = normalize((camera.inverse_view * vec4f(normal.xyz, 0.0)).xyz);
    let aside = normalize(cross(n, select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(n.y) > 0.9)));
    var sum = 0.0;
    for (var i = 0; i < 256; i++) {
        let turn = 6.2831853 * fract(f32(i) * 0.618034);
        let square = (f32(i) + 0.5) / 256.0;
        let flat = sqrt(square) * (cos(turn) * aside + sin(turn) * cross(n, aside));
        let ray = Ray(eye + n * 2e-3, ray_direction(flat + n * sqrt(1.0 - square)));
        let far = loft_trace(ray, loft_pose(0.0, 0)).distance;
        sum += 1.0 - clamp((params.radius - far) / (params.falloff * params.radius), 0.0, 1.0);
    }
    return vec4f(sum / 256.0, 0.0, 0.0, 1.0);
}",
)
.with_library(&ROOM);

impl Node for Rays {
    fn record(&self, pass: &mut Recorder<'_>) {
        let size = pass.frame_size;
        pass.function(&RAYS, "rays").write("result", ImageDesc::new(size));
    }
}

const SIZE: Size = Size { width: 240, height: 135, depth: 1 };

/// The visibilities of the scene: by rays, and by a kind with these parameters.
fn visibilities(kind: &str, parameters: &str) -> [Picture; 2] {
    let text = format!(
        r#"Pipeline(inputs: {{ "camera": Camera }}, nodes: {{
            "room": DemoScene(walk: 0.15),
            "rays": Rays(depth: "room.depth", normal: "room.normal", camera: "camera"),
            "ao": {kind}(source: "room", depth: "room.depth", camera: "camera", radius: 0.6, {parameters}),
        }}, outputs: {{ "rays": "rays", "occlusion": "ao.occlusion" }})"#
    );
    let registry = Registry::new(&[afterimage_nodes::ALL, &[NodeKind::of::<Rays>()]]).expect("kinds of their own");
    let document = afterimage_graph::document::parse("test.ron", &text).unwrap_or_else(|errors| panic!("{errors}"));
    let checked = afterimage_graph::check::check(&document, &registry, &Default::default());
    let graph = checked.unwrap_or_else(|errors| panic!("{errors}")).0;
    let camera = DemoScene { walk: 0.15, ..DemoScene::default() }.camera(SIZE);
    let mut run = Run::new(&graph).camera(Some(&camera));
    run.size = SIZE;
    run.frame(&[]).try_into().expect("two outputs")
}

/// Root mean square, over the pixels of the room, of the error of a visibility; the first is 1 everywhere.
fn errors([rays, occlusion]: &[Picture; 2], depth: &Picture) -> [f64; 2] {
    let mut sums = [0.0, 0.0];
    let mut count = 0.0;
    for ((rays, occlusion), depth) in rays.pixels.iter().zip(&occlusion.pixels).zip(&depth.pixels) {
        // The sky, and glass of thin bars before it.
        if depth[0] > 900.0 {
            continue;
        }
        let off = [1.0 - rays[0], 1.0 - occlusion[0] - rays[0]].map(f64::from);
        (0..2).for_each(|i| sums[i] += off[i] * off[i]);
        count += 1.0;
    }
    sums.map(|sum| (sum / count).sqrt())
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/depth.md")]
fn occlusion_from_depth_is_near_to_that_of_rays() {
    let depth = scene("depth", "walk: 0.15", SIZE);
    // The most that is left of the error, as a share of that without occlusion.
    let table = [
        ("Gtao", "slices: 4, steps: 8", 0.55),
        ("Gtao", "slices: 2", 0.6),
        ("Gtao", "normal: \"room.normal\"", 0.6),
        ("Gtao", "size: Half", 0.66),
        ("Ssao", "samples: 64", 0.8),
        ("Ssao", "samples: 16", 0.8),
        ("Ssao", "samples: 8", 0.8),
        ("Ssao", "normal: \"room.normal\"", 0.8),
        ("Ssao", "size: Half", 0.8),
    ];
    for (kind, parameters, most) in table {
        let [none, with] = errors(&visibilities(kind, parameters), &depth);
        println!("{kind}, {parameters}: {with:.4} instead of {none:.4}");
        assert!(with < most * none, "{kind}, {parameters}: {with} instead of {none}");
    }
}

const NODE: &str = "Gtao(source: \"in\", depth: \"data\", camera: \"camera\", radius: 3.0, normal: \"normal\")";

fn lit(node: &str, camera: &Camera, data: &Picture, normal: &Picture) -> Picture {
    let gray = Picture::new(data.width, data.height, |_, _| [0.5, 0.4, 0.3, 0.2]);
    let inputs = [("in", "Color"), ("data", "Depth"), ("normal", "Normals")];
    Nodes::new(&format!("\"result\": {node}"), &inputs).camera(Some(camera)).exact(&[&gray, data, normal])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn normals_of_the_world_are_those_of_the_view_turned() {
    let data = surfaces([40, 30]);
    let turn = Mat4::from_quat(Quat::from_rotation_y(0.7) * Quat::from_rotation_x(-0.4));
    let camera = Camera::still(turn.to_cols_array_2d(), eye().projection);
    let world = Picture::new(40, 30, |x, y| {
        let [a, b, c, _] = data.at(x, y);
        let turned = turn.inverse().transform_vector3(vec3(a, b, c));
        [turned.x, turned.y, turned.z, 1.0]
    });
    let in_view = lit(NODE, &camera, &data, &data);
    let in_world = lit(&NODE.replace("radius", "space: World, radius"), &camera, &data, &world);
    for (a, b) in in_view.pixels.iter().zip(&in_world.pixels) {
        assert!((a[0] - b[0]).abs() < 2e-3, "{a:?} and {b:?}");
    }
    assert!(in_view.pixels.iter().any(|pixel| pixel[0] < 0.4) && in_view.pixels.iter().all(|pixel| pixel[3] == 0.2));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_sky_and_a_single_pixel_are_open() {
    let sky = Picture::new(24, 16, |_, _| [65504.0, 0.0, 0.0, 1.0]);
    let front = Picture::new(24, 16, |_, _| [0.0, 0.0, 1.0, 0.0]);
    for node in [NODE.to_owned(), NODE.replace("Gtao", "Ssao")] {
        assert!(lit(&node, &eye(), &sky, &front).pixels.iter().all(|pixel| *pixel == [0.5, 0.4, 0.3, 0.2]));
        let one = lit(&node, &eye(), &surfaces([1, 1]), &Picture::new(1, 1, |_, _| [0.0, 0.0, 1.0, 0.0]));
        assert!((one.pixels[0][0] - 0.5).abs() < 1e-3, "{one:?}");
    }
}

/// The distances of a plane at `apart` meters whose normal, toward the camera, is this one, and the normals.
fn plane(camera: &Camera, [width, height]: [u32; 2], normal: Vec3, apart: f32) -> [Picture; 2] {
    let projection = Mat4::from_cols_array_2d(&camera.projection);
    let back = projection.inverse();
    let distance = |x: u32, y: u32| {
        let [u, v] = [(x, width), (y, height)].map(|(at, side)| (2.0 * at as f32 + 1.0) / side as f32 - 1.0);
        let [a, b] = [0.5, 0.25].map(|depth| back.project_point3(vec3(u, -v, depth)));
        let way = (b - a) / (a.z - b.z);
        let start = a + a.z * way;
        // Behind the camera, or beside the plane, is the sky.
        let far = -(apart + start.dot(normal)) / way.dot(normal);
        if (0.0..60000.0).contains(&far) { far } else { 65504.0 }
    };
    let normals = Picture::new(width, height, |_, _| [normal.x, normal.y, normal.z, 0.0]);
    [Picture::new(width, height, |x, y| [distance(x, y), 0.0, 0.0, 1.0]), normals]
}

/// No part of a plane hides another: walls that face the camera, tilted ones and floors to the horizon, in narrow, wide
/// and high pictures, in each of their corners.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn planes_are_open_wherever_they_are_seen() {
    let view = Mat4::IDENTITY.to_cols_array_2d();
    let lens = |field: f32, aspect: f32| {
        let projection = directx::perspective_infinite_reverse(field.to_radians(), aspect, 0.1);
        Camera::still(view, projection.to_cols_array_2d())
    };
    let parallel = directx::orthographic(-3.0, 3.0, -2.0, 2.0, 0.1, 50.0).to_cols_array_2d();
    let cameras = [
        ("37 degrees", lens(37.0, 1.5), [96, 64]),
        ("58 degrees", lens(58.0, 1.5), [96, 64]),
        ("90 degrees", lens(90.0, 1.5), [97, 63]),
        ("90 degrees, portrait", lens(90.0, 0.5), [48, 96]),
        ("a shifted lens", eye(), [96, 64]),
        ("parallel", Camera::still(view, parallel), [96, 64]),
    ];
    let planes = [
        ("a wall", Vec3::Z, 3.0),
        ("a tilted wall", vec3(0.5, -0.3, 0.8), 3.0),
        ("a side", vec3(1.0, 0.0, 0.05), 2.0),
        ("a floor", Vec3::Y, 1.6),
        ("a slope", vec3(0.1, 1.0, 0.2), 1.6),
    ];
    let mut farthest = 0.0_f32;
    for ((lens, camera, size), (name, normal, apart)) in cameras.iter().flat_map(|a| planes.iter().map(move |b| (a, b)))
    {
        let [data, normals] = plane(camera, *size, normal.normalize(), *apart);
        let seen = data.pixels.iter().map(|pixel| pixel[0]).filter(|far| *far < 60000.0);
        farthest = seen.fold(farthest, f32::max);
        for (kind, options) in [("Ssao", ""), ("Gtao", ""), ("Gtao", "slices: 1, denoise: 0,"), ("Gtao", "size: Half,")]
        {
            for (radius, given) in [("0.6", ", normal: \"normal\""), ("3.0", ", normal: \"normal\""), ("3.0", "")] {
                let node = NODE.replace("Gtao", kind).replace("3.0, normal: \"normal\"", &format!("{radius}{given}"));
                let node = node.replace("radius", &format!("{options} radius"));
                let light = lit(&node, camera, &data, &normals);
                let darkest = light.pixels.iter().map(|pixel| pixel[0] / 0.5).fold(1.0, f32::min);
                assert!(darkest > 0.999, "{name}, {lens}, {node}: {darkest}");
            }
        }
    }
    assert!(farthest > 50.0, "seen at less than two degrees: {farthest} m");
}

/// A wider picture of the same scene shows the same in its middle.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_longest_way_is_a_share_of_the_height() {
    let of_width = |width: u32| {
        let projection = directx::perspective_infinite_reverse(0.8, width as f32 / 48.0, 0.1);
        let camera = Camera::still(Mat4::IDENTITY.to_cols_array_2d(), projection.to_cols_array_2d());
        let (seen, beside) = (surfaces([32, 48]), (width - 32) / 2);
        let data = Picture::new(width, 48, |x, y| match x.checked_sub(beside) {
            Some(x) if x < 32 => seen.at(x, y),
            _ => [65504.0, 0.0, 1.0, 0.0],
        });
        let light = |largest: f32| {
            let node = NODE.replace("radius: 3.0", &format!("radius: 3.0, largest: {largest:?}"));
            let node = node.replace(", normal: \"normal\"", "");
            let found = lit(&node, &camera, &data, &data);
            Picture::new(24, 48, |x, y| found.at(beside + 4 + x, y))
        };
        [light(0.06), light(0.18)]
    };
    let (narrow, wide) = (of_width(32), of_width(96));
    for (narrow, wide) in narrow.iter().zip(&wide) {
        let off = super::lens::apart(narrow, wide);
        assert!(off < 5e-3, "{off}");
    }
    let off = super::lens::apart(&narrow[0], &narrow[1]);
    assert!(off > 0.03, "a longer way finds more: {off}");
}

/// What is far away, infinite, or not finite: the places are garbage, the numbers are not.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn broken_depths_and_normals_give_light_within_its_bounds() {
    let odd = [f32::NAN, f32::INFINITY, -5.0, 0.0, 1e30, 65504.0, 1e-30, 2.0];
    let data = Picture::new(24, 16, |x, y| [odd[((3 * x + 5 * y) % 8) as usize]; 4]);
    let half = |node: &str| node.replace("radius", "size: Half, radius");
    let points = NODE.replace("Gtao", "Ssao");
    for node in [NODE.to_owned(), half(NODE), points.clone(), half(&points)] {
        let found = lit(&node, &eye(), &data, &data);
        let is_bounded = |pixel: &[f32; 4]| (0.0..=0.5).contains(&pixel[0]) && pixel[3] == 0.2;
        assert!(found.pixels.iter().all(is_bounded), "{node}");
    }
}

/// Noise on a sloping floor is removed, and the edge of the object before it stays.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_bilateral_blur_takes_noise_and_leaves_edges() {
    let depth = Picture::new(64, 48, |x, y| {
        let floor = 1.0 / (0.05 + 0.004 * y as f32);
        [if (20..40).contains(&x) { 0.8 * floor } else { floor }, 0.0, 0.0, 1.0]
    });
    let clean = |x: u32| if (20..40).contains(&x) { 1.0 } else { 0.25 };
    let noisy = Picture::new(64, 48, |x, y| {
        let noise = super::camera::shift(x as usize, y as usize) as f32;
        [clean(x) + 0.2 * noise, 0.0, 0.0, 1.0]
    });
    let node = "\"result\": BilateralBlur(source: \"in\", depth: \"data\", radius: 8, depth_threshold: 0.02)";
    let found = Nodes::new(node, &[("in", "Color"), ("data", "Depth")]).exact(&[&noisy, &depth]);
    let deviation = |picture: &Picture| {
        let off = |(index, pixel): (usize, &[f32; 4])| f64::from(pixel[0] - clean(index as u32 % 64)).powi(2);
        (picture.pixels.iter().enumerate().map(off).sum::<f64>() / picture.pixels.len() as f64).sqrt()
    };
    let (before, after) = (deviation(&noisy), deviation(&found));
    assert!(after < 0.2 * before, "{before} becomes {after}");
}
