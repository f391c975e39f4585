//! Half floats and subgroups against floats of 32 bits and workgroup memory.

use afterimage_graph::check::Graph;
use afterimage_graph::image::Size;
use afterimage_plan::{Options, When};

use super::probes::{pipeline, scene};
use crate::support::gpu::{Picture, Run, built_in};

/// The largest half float.
const LARGEST: f32 = 65504.0;
/// Below this half floats have fewer digits, and devices may take them for 0; on their way into a sum taps are
/// quarters.
const LEAST: f32 = 4.0 / 16384.0;

/// Light over sixteen stops, no two texels alike, and a few as bright as they can be.
fn light(width: u32, height: u32) -> Picture {
    let hash =
        |x: u32, y: u32| (x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77)).wrapping_mul(0xC2B2_AE3D) >> 8;
    Picture::new(width, height, |x, y| {
        let noise = |n: u32| hash(x + 977 * n, y) as f32 / (1 << 24) as f32;
        let scale = (16.0 * noise(0) - 8.0).exp2();
        let dim = [noise(1) * scale, noise(2) * scale, noise(3) * scale, 0.75];
        if noise(4) < 0.004 { [LARGEST, LARGEST * noise(1), 1.0, 1.0] } else { dim }
    })
}

/// The first output without a switch and with it, from half-float inputs.
fn both(graph: &Graph, picture: &Picture, options: Options, switched: Options) -> [Picture; 2] {
    [options, switched].map(|options| {
        let mut run = Run::new(graph);
        run.half_inputs = true;
        run.options = options;
        run.frame(&[("scene", picture)]).remove(0)
    })
}

/// The same without and with half floats.
fn whole_and_half(nodes: &str, picture: &Picture, row_downsample: When) -> [Picture; 2] {
    let whole = Options { row_downsample, ..Options::default() };
    both(&pipeline(nodes), picture, whole, Options { half: true, ..whole })
}

/// The largest difference, as a share of the brightest number within `reach` pixels.
fn difference([a, b]: &[Picture; 2], reach: i64) -> f32 {
    assert_eq!((a.width, a.height), (b.width, b.height));
    let brightest = |x: i64, y: i64| {
        let near = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (x + dx, y + dy)));
        let inside = near.filter(|(x, y)| (0..a.width.into()).contains(x) && (0..a.height.into()).contains(y));
        inside.flat_map(|(x, y)| a.at(x as u32, y as u32)).fold(LEAST, f32::max)
    };
    let mut worst = 0.0_f32;
    for (x, y) in (0..a.height).flat_map(|y| (0..a.width).map(move |x| (x, y))) {
        let (p, q) = (a.at(x, y), b.at(x, y));
        assert!(q.iter().all(|q| q.is_finite() && q.abs() <= LARGEST), "({x}, {y}): {q:?}");
        let off = p.iter().zip(q).map(|(p, q)| (p - q).abs()).fold(0.0, f32::max);
        if off > 0.0 {
            worst = worst.max(off / brightest(x.into(), y.into()));
        }
    }
    worst
}

/// Nodes up to `result` that sum in half floats, and the number of sums one after the other.
fn sums() -> Vec<(String, f32)> {
    let mut all = Vec::new();
    for filter in ["Box", "Tap4", "Tap9", "Tap13"] {
        for firefly in ["Off", "Groups", "Taps"] {
            let mips =
                format!(r#""mips": Downsample(source: "scene", filter: {filter}, firefly: {firefly}, levels: 2)"#);
            all.push((format!(r#"{mips}, "result": Upsample(source: "mips", spread: 1.0, filter: Bilinear)"#), 2.0));
        }
    }
    for radius in [0.7, 1.0, 3.0] {
        let mips = r#""mips": Downsample(source: "scene", filter: Box, levels: 3)"#;
        all.push((format!(r#"{mips}, "result": Upsample(source: "mips", spread: 0.9, radius: {radius:?})"#), 3.0));
        let bloom = r#""mips": Downsample(source: "scene", filter: Box, levels: 2), "bloom": Upsample(source: "mips", spread: 0.5)"#;
        let lit = format!(r#"Composite(base: "scene", bloom: "bloom", blend: Mix, strength: 0.5, radius: {radius:?})"#);
        all.push((format!(r#"{bloom}, "result": {lit}"#), 3.0));
    }
    for taps in ["Exact", "Linear"] {
        all.push((format!(r#""result": Gaussian(source: "scene", kernel: Caracal9, taps: {taps})"#), 2.0));
    }
    all
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn sums_in_half_floats_are_off_by_two_of_their_last_digits() {
    for (nodes, sums) in sums() {
        let mut any = 0.0_f32;
        for row_downsample in [When::Never, When::Always] {
            for (width, height) in [(64, 64), (37, 23), (5, 3), (1, 1)] {
                let off = difference(&whole_and_half(&nodes, &light(width, height), row_downsample), 8);
                assert!(off <= sums * 2.0 / 1024.0, "{nodes} at {width}x{height}, {row_downsample:?}: off by {off}");
                any = any.max(off);
            }
        }
        assert!(any > 0.0, "{nodes}: the switch changes no bit");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn constants_stay_in_half_floats() {
    for (nodes, _) in sums() {
        for value in [0.0, 0.02, 1.0, 1000.0, 60000.0, LARGEST] {
            let picture = Picture::new(37, 23, |_, _| [value, 0.5 * value, 0.0, 1.0]);
            let [_, half] = whole_and_half(&nodes, &picture, When::WhereItPays);
            let off = difference(&[Picture::new(half.width, half.height, |_, _| picture.at(0, 0)), half], 0);
            assert!(off <= 1.5 / 1024.0, "{nodes} of {value}: off by {off}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn pictures_of_built_in_pipelines_are_within_a_code() {
    let demo = crate::support::gpu::graph(
        r#"Pipeline(inputs: {}, nodes: { "scene": DemoScene() }, outputs: { "scene": "scene" })"#,
    );
    let mut run = Run::new(&demo);
    run.size = Size::new(320, 180);
    let picture = run.frame(&[]).remove(0);
    let half = Options { half: true, ..Options::default() };
    let subgroups = Options { subgroups: true, ..Options::default() };
    for name in ["lynx.ron", "caracal.ron", "glare.ron", "tsushima.ron"] {
        // A value in fifty is so near to the border of two codes that it falls to the other one.
        for (switch, options, most) in [("half", half, 0.02), ("subgroups", subgroups, 0.002)] {
            let [a, b] = both(&built_in(name, None), &picture, Options::default(), options);
            let pairs = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
            let codes: Vec<f32> = pairs.map(|(a, b)| 255.0 * (a - b).abs()).collect();
            let worst = codes.iter().copied().fold(0.0, f32::max);
            let mean = codes.iter().sum::<f32>() / codes.len() as f32;
            assert!(worst < 1.01 && mean < most, "{name}, {switch}: off by {worst} codes, {mean} on average");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn subgroups_add_up_to_the_same() {
    let exact = Options { exact: true, ..Options::default() };
    let subgroups = Options { subgroups: true, ..exact };
    let counted = r#""h": Histogram(source: "scene")"#;
    let metered = |mean: &str| {
        format!(
            r#""mean": MeanLuminance(source: "scene", mean: {mean}), "auto": Adapt(mean: "mean"), "result": ProbeValue(value: "auto")"#
        )
    };
    let mut differ = 0;
    for (nodes, most) in [
        (format!(r#"{counted}, "result": ProbeTable(table: "h")"#), 0.0),
        (format!(r#"{counted}, "auto": AutoExposure(histogram: "h"), "result": ProbeValue(value: "auto")"#), 1e-6),
        (metered("Log"), 1e-6),
        (metered("Linear"), 1e-6),
        (r#""result": LogGaussian(source: "scene", sigma: 0.0, width: 16, height: 8)"#.into(), 1e-6),
    ] {
        for (width, height) in [(641, 359), (64, 64), (2, 3), (1, 1)] {
            let [a, b] = both(&pipeline(&nodes), &scene(width, height), exact, subgroups);
            assert!(b.pixels.as_flattened().iter().all(|x| x.is_finite()), "{nodes}");
            let off = |(a, b): (&f32, &f32)| (a - b).abs() / a.abs().max(1.0);
            let worst = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened()).map(off).fold(0.0, f32::max);
            assert!(worst <= most, "{nodes} at {width}x{height}: off by {worst}");
            differ += usize::from(a != b);
        }
    }
    assert!(differ > 0, "the switch changes no bit");
}
