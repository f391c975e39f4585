//! Kinds that read depth with a camera, on the GPU: what their CPU references do not say.

use afterimage_graph::image::Size;
use afterimage_graph::node::{Camera, Matrix};
use afterimage_nodes::DemoScene;
use glam::camera::rh::proj::directx;
use glam::{Mat4, vec3};

use crate::support::gpu::{Picture, Run};
use crate::support::harness::Nodes;

/// A camera whose image plane is shifted, with the near plane at 1 and an infinite far plane at 0.
pub(super) fn eye() -> Camera {
    let mut projection = directx::perspective_infinite_reverse(1.1, 1.5, 0.1).to_cols_array_2d();
    (projection[2][0], projection[2][1]) = (0.15, -0.1);
    let view = Mat4::from_translation(vec3(0.5, -1.5, -4.0));
    Camera::still(view.to_cols_array_2d(), projection)
}

/// Depths from the near plane to one texel that is infinitely far.
pub(super) fn projected([width, height]: [u32; 2]) -> Picture {
    Picture::new(width, height, |x, y| {
        let depth = 0.9 * (x + 1) as f32 / (width + 2 * y) as f32;
        [if (x, y) == (width / 2, height / 2) { 0.0 } else { depth }, 0.0, 0.0, 1.0]
    })
}

fn projections() -> [(&'static str, Mat4); 6] {
    let orthographic = directx::orthographic(-3.0, 4.0, -2.0, 2.5, 0.1, 50.0);
    let reversed = Mat4::from_cols_array_2d(&[
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0, 1.0],
    ]);
    let perspective = directx::perspective(1.2, 1.5, 0.1, 50.0);
    [
        ("perspective", perspective),
        ("perspective, reversed", reversed * perspective),
        ("infinite", directx::perspective_infinite(1.2, 1.5, 0.1)),
        ("infinite, reversed", directx::perspective_infinite_reverse(1.2, 1.5, 0.1)),
        ("orthographic", orthographic),
        ("orthographic, reversed", reversed * orthographic),
    ]
}

/// What a projection writes for a floor that recedes is the floor again.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_projection_leads_back_to_the_distance() {
    let distance = |x: u32, y: u32| 0.2 + 0.7 * (x + 3 * y) as f32;
    for (name, projection) in projections() {
        let written = Picture::new(24, 16, |x, y| {
            let clip = projection * glam::vec4(0.0, 0.0, -distance(x, y), 1.0);
            [clip.z / clip.w, 0.0, 0.0, 1.0]
        });
        let camera = Camera::still(Mat4::IDENTITY.to_cols_array_2d(), projection.to_cols_array_2d());
        let node = "\"result\": LinearDepth(depth: \"in\", camera: \"camera\")";
        let found = Nodes::new(node, &[("in", "Depth")]).camera(Some(&camera)).exact(&[&written]);
        for (x, y) in (0..16).flat_map(|y| (0..24).map(move |x| (x, y))) {
            let (found, wanted) = (found.at(x, y)[0], distance(x, y));
            // A depth near the far plane has few bits left.
            assert!((found / wanted - 1.0).abs() < 2e-3, "{name}: {found} m instead of {wanted}");
        }
    }
}

/// An output of the built-in scene.
pub(super) fn scene(output: &str, parameters: &str, size: Size) -> Picture {
    let text = format!("\"room\": DemoScene({parameters}) -> room.{output}");
    let graph = Nodes::new(&text, &[]).graph();
    let mut run = Run::new(&graph).exact();
    run.size = size;
    run.frame(&[]).remove(0)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_depth_of_the_scene_is_what_its_camera_projects() {
    let size = Size::new(64, 36);
    let [depth, projected] = ["depth", "projected"].map(|output| scene(output, "walk: 0.4", size));
    let camera = DemoScene { walk: 0.4, ..DemoScene::default() }.camera(size);
    let node = "\"result\": LinearDepth(depth: \"in\", camera: \"camera\")";
    let found = Nodes::new(node, &[("in", "Depth")]).camera(Some(&camera)).exact(&[&projected]);
    for (found, wanted) in found.pixels.iter().zip(&depth.pixels) {
        let wanted = if wanted[0] > 999.0 { 65504.0 } else { wanted[0] };
        assert!((found[0] / wanted - 1.0).abs() < 1e-4, "{found:?}, not {wanted}");
    }
    assert!(depth.pixels.iter().any(|pixel| pixel[0] > 999.0), "the sky is seen");
}

fn matrix(columns: Matrix) -> Mat4 {
    Mat4::from_cols_array_2d(&columns)
}

/// The place in the frame before, by the camera, for surfaces that do not move.
fn reprojected(camera: &Camera, [u, v]: [f32; 2], depth: f32) -> [f32; 2] {
    let clip = glam::vec4(2.0 * u - 1.0, 1.0 - 2.0 * v, depth, 1.0);
    let world = matrix(camera.view).inverse() * matrix(camera.projection).inverse() * clip;
    let before = matrix(camera.previous_projection) * matrix(camera.previous_view) * world;
    [0.5 + 0.5 * before.x / before.w, 0.5 - 0.5 * before.y / before.w]
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_motion_of_the_scene_is_that_of_its_camera_and_of_its_objects() {
    let size = Size::new(96, 54);
    let moving = "walk: 0.2, step: 0.01, time: 1.0, dt: 0.04, objects: 2, jitter: (0.25, -0.5)";
    let shot = |output| scene(output, moving, size);
    let [motion, projected] = ["motion", "projected"].map(shot);
    let jitter = [0.25, -0.5];
    let room = DemoScene { walk: 0.2, step: 0.01, time: 1.0, dt: 0.04, objects: 2, jitter, ..DemoScene::default() };
    let camera = room.camera(size);
    let (mut still, mut moved) = (0, 0);
    for (x, y) in (0..54).flat_map(|y| (0..96).map(move |x| (x, y))) {
        let (depth, found) = (projected.at(x, y)[0], motion.at(x, y));
        let at = [(x as f32 + 0.75) / 96.0, y as f32 / 54.0];
        let there = reprojected(&camera, at, depth.max(1e-6));
        let off = (found[0] - at[0] + there[0]).hypot(found[1] - at[1] + there[1]);
        if depth > 0.0 {
            *(if off < 2e-4 { &mut still } else { &mut moved }) += 1;
        }
    }
    // The balloon and the ball are a few percent of the picture.
    assert!(still > 3500 && (30..400).contains(&moved), "{still} pixels are still, {moved} move");
    let frozen = DemoScene { dt: 0.0, ..room };
    assert_eq!(frozen.camera(size), camera);
}

/// Objects that move are where the scene says, and shade as they do elsewhere.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn objects_change_only_what_they_cover_and_shade() {
    let size = Size::new(96, 54);
    let [empty, full] = [0, 2].map(|objects| scene("result", &format!("objects: {objects}"), size));
    let differ = empty.pixels.iter().zip(&full.pixels).filter(|(a, b)| a != b).count();
    assert!((60..1500).contains(&differ), "{differ} pixels differ");
}

/// Four samples are the mean of four images with one sample at the same places.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_jittered_sample_is_a_part_of_the_supersampled_picture() {
    let size = Size::new(32, 18);
    let whole = scene("result", "samples: 4", size);
    let places = [(0.125, 0.375), (-0.375, 0.125), (-0.125, -0.375), (0.375, -0.125)];
    let one = |(x, y): (f32, f32)| scene("result", &format!("samples: 1, jitter: ({x:?}, {y:?})"), size);
    let parts = places.map(one);
    for (index, pixel) in whole.pixels.iter().enumerate() {
        for (c, light) in pixel.iter().enumerate().take(3) {
            let mean: f32 = parts.iter().map(|part| part.pixels[index][c] / 4.0).sum();
            assert!((light - mean).abs() <= 1e-3 * mean.max(0.01), "{index}: {light} and {mean}");
        }
    }
}
