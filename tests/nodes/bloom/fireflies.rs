//! Single bright pixels, and lights that move.

use super::{SCENE, WHOLE, check, picture};
use crate::reference::bloom::without_fireflies;
use crate::support::gpu::{Picture, Run};
use crate::support::harness::{Nodes, assert_close, image};
use crate::support::sequence::Sequence;

/// Black with a square light of `side` pixels and the light of `side` squared pixels of `brightness`, `at` pixels right
/// of and below (20, 20).
pub(super) fn light(side: f64, brightness: f64, at: f64) -> Picture {
    let share = |pixel: u32| {
        let (start, pixel) = (20.0 + at, f64::from(pixel));
        ((start + side).min(pixel + 1.0) - start.max(pixel)).max(0.0)
    };
    Picture::new(64, 64, |x, y| {
        let light = (brightness * share(x) * share(y)) as f32;
        [light, 0.5 * light, 0.25 * light, 1.0]
    })
}

/// The sum of the red channel of `result` in each frame of a sequence.
fn glow(nodes: &str, frames: &[Picture]) -> Vec<f64> {
    let graph = Nodes::new(nodes, SCENE).graph();
    let run = Run::new(&graph);
    let mut sequence = Sequence::new(&run);
    let mut sums = Vec::new();
    for (index, frame) in frames.iter().enumerate() {
        sequence.frame(&[("scene", frame)], 0.0, index == 0);
        sums.push(sequence.output("out").pixels.iter().map(|pixel| f64::from(pixel[0])).sum());
    }
    sums
}

/// The largest difference from the mean, as a share of it.
pub(super) fn variation(sums: &[f64]) -> f64 {
    let mean = sums.iter().sum::<f64>() / sums.len() as f64;
    sums.iter().map(|sum| (sum / mean - 1.0).abs()).fold(0.0, f64::max)
}

/// The bloom of `lynx.ron` (a gate, five levels) and of `tsushima.ron` (a knee, six levels).
fn blooms(extract: &str, downsample: &str) -> [String; 2] {
    [("method: Gate, threshold: 1.0, knee: 0.1", 5), ("method: Knee, threshold: 1.0, knee: 0.5", 6)].map(
        |(method, levels)| {
            format!(
                r#""bright": Extract(source: "scene", {method}, {extract}),
                "mips": Downsample(source: "bright", levels: {levels}, filter: Tap13, {downsample}),
                "result": Upsample(source: "mips", blend: Add)"#
            )
        },
    )
}

const HISTORY: &str = r#"fireflies: Limit, before: "bright.peaks@previous""#;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/color.md")]
fn a_moving_light_keeps_its_glow() {
    for side in [1.0, 2.0, 3.0] {
        let frames: Vec<Picture> = (0..12).map(|frame| light(side, 200.0, 0.25 * f64::from(frame))).collect();
        for (extract, downsample) in [("", "firefly: Groups"), ("fireflies: Limit", ""), (HISTORY, "")] {
            for nodes in blooms(extract, downsample) {
                // The history begins with the first frame.
                let sums = &glow(&nodes, &frames)[1..];
                println!("{side} px, {extract} {downsample}: {:.1} %, {sums:.0?}", 100.0 * variation(sums));
                if extract == HISTORY || side >= 2.0 && !extract.is_empty() {
                    assert!(variation(sums) < 0.05, "{side} {nodes}: {sums:?}");
                }
                if extract.is_empty() && side == 2.0 {
                    assert!(variation(sums) > 0.15, "the weights remove energy: {sums:?}");
                }
            }
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/color.md")]
fn an_outlier_of_one_frame_does_not_glow() {
    let dim = |spark: bool| {
        Picture::new(64, 64, |x, y| {
            let light = if spark && (x, y) == (37, 22) { 5000.0 } else { 0.25 };
            [light, light, light, 1.0]
        })
    };
    let frames = [dim(false), dim(true), dim(false)];
    for nodes in blooms("fireflies: Limit", "").into_iter().chain(blooms(HISTORY, "")) {
        let sums = glow(&nodes, &frames);
        let kept = sums[1] / glow(&nodes.replace("Limit", "Keep"), &frames)[1];
        println!("{:.5} % of an outlier's glow are left", 100.0 * kept);
        assert!(kept < 0.001, "{nodes}: {sums:?}");
        assert!(sums[2] < 1e-3 * 5000.0, "it leaves nothing behind: {sums:?}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn fireflies_are_limited_as_in_the_cpu_reference() {
    let nodes = r#""result": Extract(source: "scene", method: All, fireflies: Limit)"#;
    check(nodes, WHOLE, |image| without_fireflies(image, None));
    let nodes = r#""bright": Extract(source: "scene", method: All, fireflies: Limit, before: "bright.peaks@previous")
        -> bright"#;
    for size in [[64, 64], [61, 39]] {
        let (mut first, mut second) = (picture(size, true), picture(size, false));
        for (x, y) in (0..26).flat_map(|y| (0..22).map(move |x| (x, y))) {
            first.pixels[x + y * size[0] as usize] = [0.1; 4];
        }
        // A spark where the frame before was dark.
        second.pixels[(5 + 9 * size[0]) as usize] = [900.0; 4];
        let graph = Nodes::new(nodes, SCENE).graph();
        let run = Run::new(&graph).exact();
        let mut sequence = Sequence::new(&run);
        sequence.frame(&[("scene", &first)], 0.0, true);
        sequence.frame(&[("scene", &second)], 0.0, false);
        let wanted = without_fireflies(&image(&second), Some(&image(&first)));
        assert!(wanted != image(&second), "something is limited");
        assert_close("history", &sequence.output("out"), &wanted, &WHOLE.within(WHOLE.half, 0.0));
    }
}
