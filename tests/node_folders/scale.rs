//! Upscaling and its sharpening.

use afterimage_gpu::Gpu;
use afterimage_graph::node::{NodeKind, folder_kind_of};
use afterimage_plan::Options;

use crate::reference::image::Image;
use crate::support::gpu::{Picture, Run, gpu, graph_with};
use crate::support::harness::{Nodes, image};
use crate::support::player::Player;

fn made(node: &str, picture: &Picture) -> Picture {
    let text = format!("\"result\": {node}");
    Nodes::new(&text, &[("in", "Encoded")]).exact(&[picture])
}

/// Lines and disks with smooth edges, as a renderer with many samples draws them.
fn drawn(width: u32, height: u32) -> Picture {
    let covered = |x: f64, y: f64| {
        let disk = (x - 0.31).hypot(y - 0.42) < 0.2;
        let line = (x - 0.5 - 0.37 * y).abs() < 0.02;
        let ring = ((x - 0.72).hypot(y - 0.63) - 0.18).abs() < 0.015;
        if disk || line || ring { 0.9 } else { 0.15 }
    };
    Picture::new(width, height, |x, y| {
        let samples = (0..64).map(|k| [x * 8 + k % 8, y * 8 + k / 8].map(|at| (f64::from(at) + 0.5) / 8.0));
        let sum: f64 = samples.map(|[x, y]| covered(x / f64::from(height), y / f64::from(height))).sum();
        let light = (sum / 64.0) as f32;
        [light, light, light, 1.0]
    })
}

fn error(found: &[[f32; 4]], wanted: &[[f32; 4]]) -> f64 {
    let squares = found.iter().zip(wanted).map(|(found, wanted)| f64::from(found[1] - wanted[1]).powi(2));
    (squares.sum::<f64>() / found.len() as f64).sqrt()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_small_image_becomes_the_large_one_better_than_by_bilinear_taps() {
    let (small, large) = (drawn(96, 64), drawn(192, 128));
    let found = made("Fsr1(source: \"in\")", &small);
    assert_eq!((found.width, found.height), (192, 128));
    let source = image(&small);
    let bilinear = Image::from_uv(192, 128, |uv| source.tap(uv));
    let bilinear: Vec<[f32; 4]> = bilinear.pixels.iter().map(|pixel| pixel.map(|x| x as f32)).collect();
    let (own, simple) = (error(&found.pixels, &large.pixels), error(&bilinear, &large.pixels));
    assert!(own < 0.85 * simple, "{own} and {simple} by bilinear taps");
    let sharp = made("Rcas(source: \"twice\"), \"twice\": Fsr1(source: \"in\")", &small);
    assert!(error(&sharp.pixels, &large.pixels) < own, "sharpening takes it further away");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn upscaling_does_not_ring_and_knows_no_direction() {
    let small = drawn(48, 48);
    let found = made("Fsr1(source: \"in\")", &small);
    for y in 0..96 {
        for x in 0..96 {
            let first = [x, y].map(|at: u32| (0.5 * f64::from(at) - 0.25).floor() as i64);
            let near =
                [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[i, j]| image(&small).texel(first[0] + i, first[1] + j)[1]);
            let (least, most) = near.iter().fold((1.0_f64, 0.0_f64), |(low, high), v| (low.min(*v), high.max(*v)));
            let own = f64::from(found.at(x, y)[1]);
            assert!((least - 1e-6..=most + 1e-6).contains(&own), "{own} at {x}, {y} of {near:?}");
        }
    }
    let transposed = Picture::new(48, 48, |x, y| small.at(y, x));
    let turned = made("Fsr1(source: \"in\")", &transposed);
    let mirrored = made("Fsr1(source: \"in\")", &Picture::new(48, 48, |x, y| small.at(47 - x, y)));
    for (x, y) in (0..96).flat_map(|y| (0..96).map(move |x| (x, y))) {
        let own = found.at(x, y)[1];
        assert!((own - turned.at(y, x)[1]).abs() < 1e-4, "transposed at {x}, {y}");
        assert!((own - mirrored.at(95 - x, y)[1]).abs() < 1e-4, "mirrored at {x}, {y}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn sharpening_is_as_strong_as_keeps_the_result_in_range() {
    // A pixel of 0.7 in neighbors of 0.4, 0.5, 0.5 and 0.6. A negative lobe of 0.3 / (4 - 4 * 0.4) cannot take anything
    // above 1, nor one of 0.4 / (4 * 0.6) below 0; the first is smaller: (0.7 - 0.125 * 2) / (1 - 4 * 0.125).
    let values = [[0.5, 0.4, 0.5], [0.5, 0.7, 0.5], [0.5, 0.6, 0.5]];
    let picture = Picture::new(3, 3, |x, y| {
        let value = values[y as usize][x as usize];
        [value, value, value, 1.0]
    });
    let found = made("Rcas(source: \"in\", sharpness: 1.0)", &picture).at(1, 1)[0];
    assert!((found - 0.9).abs() < 1e-5, "{found} instead of 0.9");
    let sharp = made("Rcas(source: \"in\", sharpness: 1.0)", &drawn(64, 48));
    assert!(sharp.pixels.iter().all(|pixel| (-1e-6..=1.0 + 1e-6).contains(&pixel[1])));
}

/// Reads of a few texels repair a picture of the host as a copy of it would be repaired.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_sharpener_sees_a_damaged_picture_as_its_repaired_copy_is() {
    const SAME: &str = r#"Kind(name: "Same", doc: "An image.",
        inputs: { "source": Image(doc: "The image.", accepts: [Encoded]) },
        outputs: { "result": Image(doc: "The image.", state: Same("source")) })"#;
    let shader = "fn same(source: vec4f) -> vec4f { return source; }";
    let kind: NodeKind =
        folder_kind_of(("node.ron", SAME), &[("same.wgsl", shader)]).unwrap_or_else(|errors| panic!("{errors}"));
    let text = r#"Pipeline(inputs: { "in": Encoded }, nodes: {
        "copy": Same(source: "in", format: Rgba32Float),
        "of_copy": Rcas(source: "copy", sharpness: 0.7, format: Rgba32Float),
        "itself": Rcas(source: "in", sharpness: 0.7, format: Rgba32Float),
        }, outputs: { "of_copy": "of_copy", "itself": "itself" })"#;
    let graph = graph_with(text, &[kind]);
    let mut picture = drawn(64, 48);
    for (at, pixel) in picture.pixels.iter_mut().enumerate() {
        let (x, y) = (at % 64, at / 64);
        match (x + 5 * y) % 37 {
            0 => *pixel = [f32::NAN; 4],
            1 if y % 3 == 0 => pixel[1] = f32::INFINITY,
            2 => pixel[0] = f32::NEG_INFINITY,
            3 => pixel[2] = -3.0,
            _ if y == 24 || x == 0 => pixel[0] = f32::NAN,
            _ => {}
        }
    }
    let mut run = Run::new(&graph);
    run.options = Options { fuse: false, ..Options::default() };
    let mut gpu: Gpu = (*gpu()).clone();
    gpu.caps.fast_workgroup_memory = true;
    let mut player = Player::on(gpu);
    let plan = player.load(&run, &[("in", &picture)]);
    assert!(plan.work().all(|pass| pass.label != "sanitize"), "{}", plan.to_text());
    player.frame(&[("in", &picture)], 0.0, true);
    let [of_copy, itself] = ["of_copy", "itself"].map(|output| player.output(output));
    assert!(of_copy.pixels.iter().flatten().all(|number| number.is_finite()));
    assert_eq!(of_copy, itself);
}
