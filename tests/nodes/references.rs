//! Depth of field, fog and occlusion of the built-in scene, against many samples of a lens, of a pixel and of rays.

use afterimage_graph::image::Size;
use afterimage_graph::node::{Camera, NodeKind};
use afterimage_lab::metrics::{PIXELS_PER_DEGREE, Range, Shown, flip, mean, psnr};
use afterimage_nodes::DemoScene;
use glam::{DMat4, DVec3, Vec4Swizzles as _};

use super::occlusion::Rays;
use crate::support::docs;
use crate::support::gpu::{Picture, Run, graph, graph_with};
use crate::support::sweep;

/// That of the figures and of the picture in the documentation, or a small one.
fn size() -> Size {
    if docs::are_written() { Size::new(320, 180) } else { Size::new(192, 108) }
}

/// Places of the camera, and what is in focus there, in meters: the table, and the window.
const PLACES: [(f32, f32); 2] = [(0.15, 4.5), (0.6, 2.5)];

fn camera(walk: f32) -> Camera {
    DemoScene { walk, ..DemoScene::default() }.camera(size())
}

/// The outputs of nodes in the scene, in the order of their names.
fn outputs(walk: f32, (nodes, own): (&str, &[NodeKind]), outputs: &[&str]) -> Vec<Picture> {
    let outputs: String = outputs.iter().enumerate().map(|(i, wire)| format!("\"out{i}\": \"{wire}\", ")).collect();
    let text = format!("Pipeline(inputs: {{ \"camera\": Camera }}, nodes: {{ {nodes} }}, outputs: {{ {outputs} }})");
    let graph = graph_with(&text, own);
    let camera = camera(walk);
    let mut run = Run::new(&graph).camera(Some(&camera)).exact();
    run.size = size();
    run.frame(&[])
}

/// As a display shows light: exposed by 1 stop, through the default curve, encoded.
fn shown(light: &Picture) -> Picture {
    let graph = graph(
        r#"Pipeline(inputs: { "scene": Color }, nodes: {
            "exposed": Exposure(source: "scene", stops: 1.0),
            "mapped": ToneMap(source: "exposed"),
            "encoded": Encode(source: "mapped"),
        }, outputs: { "out": "encoded" })"#,
    );
    let mut run = Run::new(&graph).exact();
    run.size = size();
    run.frame(&[("scene", light)]).remove(0)
}

/// PSNR in dB and the mean of FLIP.
fn errors(reference: &Picture, found: &Picture) -> [f64; 2] {
    let of = |picture: &Picture| Shown {
        width: picture.width as usize,
        height: picture.height as usize,
        range: Range::Sdr,
        pixels: picture.pixels.iter().map(|[r, g, b, _]| [*r, *g, *b].map(|x| x.clamp(0.0, 1.0))).collect(),
    };
    let (reference, found) = (of(reference), of(found));
    [psnr(&reference.pixels, &found.pixels, 1.0), mean(&flip(&reference, &found, PIXELS_PER_DEGREE))]
}

/// Compares light as a display shows it: see [`compare_shown`].
fn compare(name: &str, light: [&Picture; 3], (gain, left): (f64, f64)) -> [Picture; 3] {
    compare_shown(name, light.map(shown), (gain, left))
}

/// Prints the errors without a node and with it, and panics unless the node brings these many dB and leaves less than
/// this share of FLIP. The pictures: without, with, reference.
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/depth.md")]
fn compare_shown(name: &str, pictures: [Picture; 3], (gain, left): (f64, f64)) -> [Picture; 3] {
    let [none, some] = [&pictures[0], &pictures[1]].map(|found| errors(&pictures[2], found));
    println!("{name}: {:.1} dB, {:.4} without; {:.1} dB, {:.4} with", none[0], none[1], some[0], some[1]);
    assert!(some[0] > none[0] + gain, "{name}: {} dB instead of {} dB", some[0], none[0]);
    assert!(some[1] < left * none[1], "{name}: FLIP of {} instead of {}", some[1], none[1]);
    pictures
}

fn mean_of(pictures: &[Picture]) -> Picture {
    Picture::new(pictures[0].width, pictures[0].height, |x, y| {
        let sum = pictures.iter().map(|picture| glam::Vec4::from(picture.at(x, y))).sum::<glam::Vec4>();
        (sum / pictures.len() as f32).to_array()
    })
}

/// The diameter of the lens in meters.
const APERTURE: f32 = 0.15;

/// A lens of this diameter whose image of the focus fills a sensor of 24 mm with the scene's field of view.
fn lens(focus: f32) -> String {
    let sensor_distance = 12.0 / 0.4245;
    let focal_length = sensor_distance / (1.0 + sensor_distance / (1000.0 * focus));
    let f_stop = 4.0 * focal_length / (1000.0 * APERTURE);
    format!("amount: 4.0, focus: {focus}, f_stop: {f_stop}, focal_length: {focal_length}, largest: 0.06")
}

fn depth_of_field(walk: f32, focus: f32) -> [Picture; 3] {
    let ray = |first: u32| {
        format!(
            "\"lens{first}\": DemoScene(walk: {walk}, samples: 64, first: {first}, aperture: {APERTURE}, \
             focus: {focus}),"
        )
    };
    let rays: String = [0, 64, 128, 192].map(ray).concat();
    let nodes = format!(
        "{rays} \"sharp\": DemoScene(walk: {walk}, samples: 64), \
         \"made\": DepthOfField(source: \"sharp\", depth: \"sharp.depth\", {})",
        lens(focus)
    );
    let found = outputs(walk, (&nodes, &[]), &["sharp", "made", "lens0", "lens64", "lens128", "lens192"]);
    let reference = mean_of(&found[2..]);
    compare(&format!("DepthOfField at {walk}"), [&found[0], &found[1], &reference], (2.0, 0.8))
}

/// Thickens downwards, and glows toward the window.
const DENSITY: f64 = 0.12;
const FALLOFF: f64 = 0.4;
const COLOR: DVec3 = DVec3::new(0.2, 0.25, 0.3);

/// Light through the fog from the end of a ray to the eye: absorbed and scattered step by step.
fn marched(light: DVec3, eye: DVec3, end: DVec3) -> DVec3 {
    const STEPS: i32 = 64;
    let step = (end - eye) / f64::from(STEPS);
    let passed = |i: i32| (-DENSITY * step.length() * (-FALLOFF * (eye + step * (f64::from(i) + 0.5)).y).exp()).exp();
    (0..STEPS).rev().fold(light, |light, i| light * passed(i) + COLOR * (1.0 - passed(i)))
}

/// The place of sample `i` in a pixel, as in `DemoScene`.
fn offset(i: u32) -> [f32; 2] {
    [0.7548777, 0.5698403].map(|part: f32| (0.5 + i as f32 * part).fract() - 0.5)
}

/// The mean of the light of 16 samples, each behind the fog before its own surface.
fn fogged(walk: f32) -> Picture {
    let node = |i: u32| {
        let [x, y] = offset(i);
        format!("\"s{i}\": DemoScene(walk: {walk}, samples: 1, jitter: ({x:.7}, {y:.7})),")
    };
    let (view, aspect) = (camera(walk).view, f64::from(size().width) / f64::from(size().height));
    let to_world = DMat4::from_cols_array_2d(&view.map(|column| column.map(f64::from))).inverse();
    let sample = |i: u32| {
        let found = outputs(walk, (&node(i), &[]), &[&format!("s{i}"), &format!("s{i}.depth")]);
        let (light, depth) = (&found[0], &found[1]);
        Picture::new(light.width, light.height, |x, y| {
            let [dx, dy] = offset(i).map(f64::from);
            let across = 2.0 * (f64::from(x) + 0.5 + dx) / f64::from(light.width) - 1.0;
            let up = 1.0 - 2.0 * (f64::from(y) + 0.5 + dy) / f64::from(light.height);
            let place = DVec3::new(across * aspect * 0.4245, up * 0.4245, -1.0) * f64::from(depth.at(x, y)[0]);
            let [r, g, b, a] = light.at(x, y);
            let end = (to_world * place.extend(1.0)).xyz();
            let lit = marched(DVec3::new(r.into(), g.into(), b.into()), to_world.w_axis.xyz(), end);
            [lit.x as f32, lit.y as f32, lit.z as f32, a]
        })
    };
    mean_of(&(0..16).map(sample).collect::<Vec<_>>())
}

fn fog(walk: f32) -> [Picture; 3] {
    let nodes = format!(
        "\"clear\": DemoScene(walk: {walk}, samples: 16), \"made\": Fog(source: \"clear\", depth: \"clear.depth\", \
         camera: \"camera\", density: {DENSITY}, falloff: {FALLOFF}, color: ({}, {}, {}))",
        COLOR.x, COLOR.y, COLOR.z
    );
    let found = outputs(walk, (&nodes, &[]), &["clear", "made"]);
    compare(&format!("Fog at {walk}"), [&found[0], &found[1], &fogged(walk)], (10.0, 0.3))
}

/// The light of a pixel times the openness of its middle by 256 rays, with the radius and the fading of the node.
fn occlusion(walk: f32) -> [Picture; 3] {
    let nodes = format!(
        "\"open\": DemoScene(walk: {walk}, samples: 16), \
         \"rays\": Rays(depth: \"open.depth\", normal: \"open.normal\", camera: \"camera\"), \
         \"made\": Gtao(source: \"open\", depth: \"open.depth\", camera: \"camera\", normal: \"open.normal\")"
    );
    let found = outputs(walk, (&nodes, &[NodeKind::of::<Rays>()]), &["open", "made", "rays", "open.depth"]);
    let reference = Picture::new(found[0].width, found[0].height, |x, y| {
        // Rays of the sky begin nowhere.
        let open = if found[3].at(x, y)[0] > 900.0 { 1.0 } else { found[2].at(x, y)[0] };
        let [r, g, b, a] = found[0].at(x, y);
        [open * r, open * g, open * b, a]
    });
    compare(&format!("Gtao at {walk}"), [&found[0], &found[1], &reference], (2.0, 0.85))
}

/// One sample in the middle of each pixel, smoothed as it is shown, against 64.
fn smoothed(walk: f32, node: &str, limits: (f64, f64)) {
    let nodes = format!(
        "\"one\": DemoScene(walk: {walk}, samples: 1), \"many\": DemoScene(walk: {walk}, samples: 64), \
         \"exposed\": Exposure(source: \"one\", stops: 1.0), \"mapped\": ToneMap(source: \"exposed\"), \
         \"smooth\": {node}(source: \"mapped\"), \"made\": Encode(source: \"smooth\")"
    );
    let found = outputs(walk, (&nodes, &[]), &["one", "made", "many"]);
    let [one, made, many] = <[Picture; 3]>::try_from(found).expect("three outputs");
    compare_shown(&format!("{node} at {walk}"), [shown(&one), made, shown(&many)], limits);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn smoothed_edges_are_nearer_to_many_samples() {
    for (walk, _) in PLACES {
        // FLIP finds softer textures as bad as steps are.
        smoothed(walk, "Smaa", (1.0, 1.06));
        smoothed(walk, "Fxaa", (1.0, 1.06));
    }
}

/// With `AFTERIMAGE_WRITE_DOCS=1` at the size of the figures, which writes a picture of the second place: a row for
/// each effect, without it, with it and the reference.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn effects_are_nearer_to_many_samples_than_the_scene_without_them() {
    for (walk, focus) in sweep::some(PLACES, 1) {
        let row = [depth_of_field(walk, focus), fog(walk), occlusion(walk)].concat();
        if (walk, focus) == PLACES[1] {
            docs::write_panels("effects.jpg", 3, &row);
        }
    }
}

/// The mean over an image of the largest difference of a channel, relative to the brighter of both.
fn difference(a: &Picture, b: &Picture) -> f64 {
    let of = |(a, b): (&[f32; 4], &[f32; 4])| {
        let off = |c: usize| f64::from((a[c] - b[c]).abs() / a[c].abs().max(b[c].abs()).max(1e-6));
        (0..3).map(off).fold(0.0, f64::max)
    };
    a.pixels.iter().zip(&b.pixels).map(of).sum::<f64>() / a.pixels.len() as f64
}

/// Samples go on where others end, a lens without a width is a pinhole, and another one is not.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_samples_of_the_scene_are_one_sequence_through_one_lens() {
    let node = |name: &str, more: &str| format!("\"{name}\": DemoScene(walk: 0.6, {more}),");
    let wide = "aperture: 0.15, focus: 2.5";
    let nodes = [
        node("all", &format!("samples: 16, {wide}")),
        node("one", &format!("samples: 8, {wide}")),
        node("two", &format!("samples: 8, first: 8, {wide}")),
        node("none", "samples: 16, aperture: 0.0, focus: 0.1"),
        node("pinhole", "samples: 16"),
    ];
    let found = outputs(0.6, (&nodes.concat(), &[]), &["all", "one", "two", "none", "pinhole"]);
    let [all, one, two, none, pinhole] = <[Picture; 5]>::try_from(found).expect("five outputs");
    assert!(difference(&all, &mean_of(&[one.clone(), two])) < 1e-5, "two halves are the whole");
    assert!(difference(&all, &one) > 1e-2, "a half is not");
    assert_eq!(none, pinhole);
    assert!(difference(&all, &pinhole) > 1e-2, "a lens is no pinhole");
}
