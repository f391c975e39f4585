//! Fog, depth of field and motion blur on the GPU: what their CPU references do not say.

use afterimage_graph::image::Size;

use crate::reference::image::center_uv;
use crate::reference::math::{Rgb, dot, mix};
use crate::support::gpu::{Picture, Run};
use crate::support::harness::Nodes;

/// A floor that recedes, and an object before it that is off the focus, in meters.
pub(super) fn depths([width, height]: [u32; 2]) -> Picture {
    Picture::new(width, height, |x, y| {
        let is_object = x * 3 > width && x * 2 < width && y * 3 > height;
        let floor = 20.0 - 17.0 * (y as f32 + 0.37) / height as f32;
        [if is_object { 1.513 } else { floor }, 0.0, 0.0, 1.0]
    })
}

/// An object that moves to the right before a background that turns, in pixels.
pub(super) fn motions([width, height]: [u32; 2]) -> Picture {
    Picture::new(width, height, |x, y| {
        let is_object = x * 3 > width && x * 2 < width && y * 3 > height;
        let turn = [0.11 * (y as f32 - 0.45 * height as f32), 0.07 * (0.55 * width as f32 - x as f32)];
        let [u, v] = if is_object { [5.23, -1.37] } else { turn };
        [u, v, 0.0, 1.0]
    })
}

fn hash(v: u32) -> u32 {
    let state = v.wrapping_mul(747796405).wrapping_add(2891336453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277803737);
    (word >> 22) ^ word
}

/// The random number of a pixel, from -0.5 to 0.5.
pub(super) fn shift(x: usize, y: usize) -> f64 {
    f64::from(hash(x as u32 ^ hash(y as u32)) >> 8) / 16777216.0 - 0.5
}

/// The result of a node that reads `in` and `data`.
fn run(node: &str, source: &Picture, data: &Picture) -> Picture {
    let node = node.replacen('(', "(source: \"in\", ", 1);
    Nodes::new(&format!("\"result\": {node}"), &[("in", "Exposed"), ("data", "Data")]).exact(&[source, data])
}

fn sum(picture: &Picture) -> f64 {
    picture.pixels.iter().map(|pixel| f64::from(pixel[0])).sum()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_light_out_of_focus_becomes_a_disc_with_all_of_its_light() {
    let light = Picture::new(61, 61, |x, y| if (x, y) == (30, 30) { [1000.0; 4] } else { [0.0, 0.0, 0.0, 1.0] });
    let far = Picture::new(61, 61, |_, _| [100.0, 0.0, 0.0, 1.0]);
    let disc =
        run("DepthOfField(depth: \"data\", focus: 2.0, focal_length: 200.0, rings: 16, largest: 0.1)", &light, &far);
    // 0.1 heights are 6.1 pixels.
    let lit = |x: u32| disc.at(x, 30)[0] > 1.0;
    let row: Vec<u32> = (0..61).filter(|x| lit(*x)).collect();
    let radius = 6.1_f64;
    assert!((row.len() as f64 - 2.0 * radius).abs() <= 1.5, "{row:?}");
    assert!((sum(&disc) / 1000.0 - 1.0).abs() < 0.03, "{}", sum(&disc));
    let middle = f64::from(disc.at(30, 30)[0]);
    assert!((middle / (1000.0 / (std::f64::consts::PI * radius * radius)) - 1.0).abs() < 0.25, "{middle}");
    // An oval has the same height, half of the width and all of the light.
    let lens = "DepthOfField(depth: \"data\", focus: 2.0, focal_length: 200.0, rings: 16, largest: 0.1, squeeze: 2.0)";
    let oval = run(lens, &light, &far);
    let lit = |pixel: [f32; 4]| pixel[0] > 2.0;
    let width = (0..61).filter(|x| lit(oval.at(*x, 30))).count() as f64;
    let height = (0..61).filter(|y| lit(oval.at(30, *y))).count() as f64;
    assert!((width - radius).abs() <= 1.5 && (height - 2.0 * radius).abs() <= 1.5, "{width} and {height}");
    assert!((sum(&oval) / 1000.0 - 1.0).abs() < 0.05, "{}", sum(&oval));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_bright_background_does_not_bleed_over_a_sharp_foreground() {
    let edge = |x: u32| x < 32;
    let scene = Picture::new(64, 48, |x, _| if edge(x) { [0.1, 0.1, 0.1, 1.0] } else { [50.0, 50.0, 50.0, 1.0] });
    let depth = Picture::new(64, 48, |x, _| if edge(x) { [2.0, 0.0, 0.0, 1.0] } else { [40.0, 0.0, 0.0, 1.0] });
    let lens = "DepthOfField(depth: \"data\", focus: 2.0, focal_length: 200.0, largest: 0.1)";
    let found = run(lens, &scene, &depth);
    assert!((0..32).all(|x| (found.at(x, 24)[0] - 0.1).abs() < 1e-5), "{:?}", found.at(31, 24));
    // The other way round, the foreground that is out of focus covers a part of the sharp background.
    let near = run(&lens.replace("focus: 2.0", "focus: 40.0"), &scene, &depth);
    let covered = near.at(33, 24)[0];
    assert!((5.0..45.0).contains(&covered), "{covered}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_focus_is_found_where_it_is_looked_for() {
    let scene = Picture::new(64, 48, |x, y| [((x * 7 + y * 3) % 23) as f32, x as f32, y as f32, 1.0]);
    // A floor at eight meters, a post at three of four columns, and a hole in the depth.
    let depth = Picture::new(64, 48, |x, _| {
        let distance = match x {
            20..=23 => 3.0,
            50 => 0.0,
            _ => 8.0,
        };
        [distance, 0.0, 0.0, 1.0]
    });
    let lens =
        |focus: &str| run(&format!("DepthOfField(depth: \"data\", focal_length: 200.0, {focus})"), &scene, &depth);
    let at = |u: f32, area: f32| lens(&format!("autofocus: true, place: ({u:?}, 0.5), area: {area:?}"));
    let (near, far) = (lens("focus: 3.0"), lens("focus: 8.0"));
    assert!(near != far);
    assert!(at(0.34, 0.0) == near, "on the post");
    assert!(at(0.6, 0.0) == far, "beside it");
    assert!(at(0.5, 0.05) == far, "the post is 8 pixels away, and 2.4 count");
    assert!(at(0.5, 0.25) == near, "12 pixels count");
    // What has no distance is far away.
    assert!(at(0.785, 0.1) == far);
    assert!(at(0.785, 0.0) == lens("focus: 10000.0"));
}

/// A pixel that shows a bar and the sky has the sky's depth, as a renderer with one sample for depth may write it.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_smooth_edge_of_a_sharp_bar_stays_before_a_blurred_sky() {
    let light = |x: u32| match x {
        30..=32 => 0.1,
        33 => 25.0,
        _ => 50.0,
    };
    let scene = Picture::new(64, 48, |x, _| [light(x), light(x), light(x), 1.0]);
    let depth = Picture::new(64, 48, |x, _| [if (30..=32).contains(&x) { 2.0 } else { 40.0 }, 0.0, 0.0, 1.0]);
    let found = run("DepthOfField(depth: \"data\", focus: 2.0, focal_length: 200.0, largest: 0.1)", &scene, &depth);
    assert!((found.at(33, 24)[0] - 25.0).abs() < 0.1, "{:?}", found.at(33, 24));
    assert!((35..64).all(|x| (found.at(x, 24)[0] - 50.0).abs() < 0.1), "{:?}", found.at(35, 24));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_moves_is_drawn_out_as_far_as_the_shutter_is_open() {
    let dot = Picture::new(64, 32, |x, _| if x == 32 { [1.0; 4] } else { [0.0, 0.0, 0.0, 1.0] });
    let motion = Picture::new(64, 32, |_, _| [0.25, 0.0, 0.0, 1.0]);
    // Half of a frame of 16 pixels, so four pixels to each side.
    let node = "MotionBlur(motion: \"data\", shutter: 180.0, largest: 0.1, samples: 64)";
    let large = |shutter: &str| run(&node.replace("180.0", shutter), &dot, &motion);
    let reach = |picture: &Picture| (0..64).filter(|x| (8..24).any(|y| picture.at(*x, y)[0] > 0.02)).count();
    // The longest half path is 0.1 of 32 pixels: 3.2.
    assert!((6..=8).contains(&reach(&large("180.0"))), "{}", reach(&large("180.0")));
    assert!((3..=6).contains(&reach(&large("90.0"))), "{}", reach(&large("90.0")));
    assert_eq!(large("0.0").pixels, dot.pixels);
    let light = sum(&large("180.0")) / sum(&dot);
    assert!((light - 1.0).abs() < 0.1, "{light}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_bar_that_moves_covers_each_pixel_for_the_time_that_it_is_there() {
    let is_bar = |x: u32| (40..52).contains(&x);
    let scene = Picture::new(96, 48, |x, _| if is_bar(x) { [1.0; 4] } else { [0.2, 0.2, 0.2, 1.0] });
    // 16 pixels in a frame, so four to each side in half of one.
    let motion = Picture::new(96, 48, |x, _| [if is_bar(x) { 16.0 / 96.0 } else { 0.0 }, 0.0, 0.0, 1.0]);
    let depth = Picture::new(96, 48, |x, _| [if is_bar(x) { 2.0 } else { 8.0 }, 0.0, 0.0, 1.0]);
    let inputs = [("in", "Color"), ("data", "Motion"), ("depth", "Depth")];
    let row = |wires: &str, count: usize| {
        let node =
            format!("\"result\": MotionBlur(source: \"in\", motion: \"data\", {wires} largest: 0.1, samples: 64)");
        let found = Nodes::new(&node, &inputs[..count]).exact(&[&scene, &motion, &depth][..count]);
        (30..62).map(|x| (x, found.at(x, 24)[0])).collect::<Vec<_>>()
    };
    // Without a depth, what moves faster counts as nearer.
    for row in [row("depth: \"depth\",", 3), row("", 2)] {
        for (x, found) in row {
            // The share of the shutter in which the bar is at the pixel, of starts from -4 to 4.
            let (first, last) = ((f64::from(x) - 51.5).max(-4.0), (f64::from(x) - 39.5).min(4.0));
            let wanted = mix(0.2, 1.0, ((last - first) / 8.0).clamp(0.0, 1.0));
            assert!((f64::from(found) - wanted).abs() < 0.06, "{x}: {found} instead of {wanted}");
        }
    }
}

/// An output of the built-in scene.
fn scene(output: &str, walk: f32, step: f32) -> Picture {
    let text = format!("\"room\": DemoScene(walk: {walk:?}, step: {step:?}) -> room.{output}");
    let graph = Nodes::new(&text, &[]).graph();
    let mut run = Run::new(&graph).exact();
    run.size = Size::new(160, 90);
    run.frame(&[]).remove(0)
}

/// The position of the camera of the built-in scene, and its axes: right, up, backwards. The path is a part of the
/// scene.
fn camera(walk: f64) -> (Rgb, [Rgb; 3]) {
    let w = walk * walk * (3.0 - 2.0 * walk);
    let along = |a: Rgb, b: Rgb| [0, 1, 2].map(|i| mix(a[i], b[i], w));
    let eye = along([1.75, 1.55, 4.7], [-0.45, 1.62, -2.3]);
    let aim = along([0.15, 1.72, -4.0], [-1.6, 2.0, -8.0]);
    let unit = |v: Rgb| v.map(|x| x / dot(v, v).sqrt());
    let cross = |a: Rgb, b: Rgb| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let back = unit([0, 1, 2].map(|i| eye[i] - aim[i]));
    let right = unit(cross([0.0, 1.0, 0.0], back));
    (eye, [right, cross(back, right), back])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_motion_of_the_scene_leads_to_where_surfaces_were() {
    let (depth, motion) = (scene("depth", 0.52, 0.0), scene("motion", 0.52, 0.02));
    let (eye, axes) = camera(f64::from(0.52_f32));
    let (before, axes_before) = camera(f64::from(0.52_f32 - 0.02));
    let (aspect, tan) = (160.0 / 90.0, f64::from(0.4245_f32));
    for (index, (depth, found)) in depth.pixels.iter().zip(&motion.pixels).enumerate() {
        let [u, v] = center_uv(index % 160, index / 160, 160, 90);
        let depth = f64::from(depth[0]);
        let ray = [(2.0 * u - 1.0) * aspect * tan, (1.0 - 2.0 * v) * tan, -1.0].map(|x| x * depth);
        let place = |i: usize| axes[0][i] * ray[0] + axes[1][i] * ray[1] + axes[2][i] * ray[2];
        // The sky is at an infinite distance.
        let moved = |i: usize| if depth > 999.0 { 0.0 } else { eye[i] - before[i] };
        let way = [0, 1, 2].map(|i| place(i) + moved(i));
        let [x, y, z] = axes_before.map(|axis| dot(axis, way));
        let there = [0.5 - 0.5 * x / (z * aspect * tan), 0.5 + 0.5 * y / (z * tan)];
        let wanted = [u - there[0], v - there[1]];
        let is_close = (0..2).all(|i| (f64::from(found[i]) - wanted[i]).abs() < 2e-5 + 1e-4 * wanted[i].abs());
        assert!(is_close, "{index}: {found:?} instead of {wanted:?}");
    }
    let longest = motion.pixels.iter().map(|pixel| pixel[0].hypot(pixel[1])).fold(0.0, f32::max);
    assert!(longest > 0.01, "{longest}");
    assert!(scene("motion", 0.52, 0.0).pixels.iter().all(|pixel| pixel[..2].iter().all(|x| x.abs() < 1e-6)));
}
