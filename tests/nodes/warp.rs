//! Warps on the GPU: every formula of a lens, and warps that become one pass.

use afterimage_graph::check::Graph;
use afterimage_plan::Options;

use super::lens::lights;
use crate::reference::haze::Haze;
use crate::reference::image::{Image, rgb};
use crate::reference::warp::{Lens, Warp, aberration, inverse, warped};
use crate::support::gpu::{Picture, Run, gpu};
use crate::support::harness::{Nodes, Scale, Tolerance, assert_close, image};

/// Ripples of twelve pixels and more: a bilinear filter changes them little.
fn smooth(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let (x, y) = (f64::from(x), f64::from(y));
        let ripple = |a: f64, b: f64| (1.0 + 0.5 * (a * x + b * y).sin()) as f32;
        [ripple(0.21, 0.05), ripple(-0.1, 0.25), ripple(0.17, 0.17), ripple(0.02, 0.11)]
    })
}

/// The relative tolerance of places in f32.
const PLACES: Tolerance =
    Tolerance { absolute: 1e-4, relative: 4e-3, of: Scale::Neighborhood, reason: "places of taps in f32" };

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_formula_of_a_lens_equals_its_reference() {
    let (barrel, pincushion) = ([-0.15, 0.03, 0.0], [0.1, 0.02, 0.01]);
    let picture = lights([67, 41]);
    for (k, p) in [(barrel, [0.0; 2]), (pincushion, [0.01, -0.004])] {
        let lens = Lens { k, p };
        let brown = |place| lens.brown(place);
        let division = |place| lens.division(place);
        let cases: [(&str, &str, Warp<'_>); 4] = [
            ("BrownConrady", "Undistort", &brown),
            ("BrownConrady", "Distort", &|place| inverse(brown, place)),
            ("Division", "Distort", &division),
            ("Division", "Undistort", &|place| inverse(division, place)),
        ];
        for (model, direction, warp) in cases {
            let ([k1, k2, k3], [p1, p2]) = (k, p);
            let text = format!(
                "\"result\": LensDistortion(source: \"in\", model: {model}, direction: {direction}, \
                 k1: {k1:?}, k2: {k2:?}, k3: {k3:?}, p1: {p1:?}, p2: {p2:?})"
            );
            let found = Nodes::new(&text, &[("in", "Exposed")]).exact(&[&picture]);
            assert_close(&text, &found, &warped(&image(&picture), [warp; 3]), &PLACES);
        }
    }
}

/// A chain of warps between nodes of one pixel, as a lens has it.
const CHAIN: &str = r#"
    "exposed": Exposure(source: "scene", stops: 1.0),
    "bent": LensDistortion(source: "exposed", k1: -0.15, k2: 0.02, zoom: 1.1),
    "fringed": ChromaticAberration(source: "bent", red: 0.01, blue: -0.012),
    "dark": Vignette(source: "fringed"),
    "result": ToneMap(source: "dark", curve: AcesNarkowicz, space: Rec709, keep_hue: 0.0, gamut: Clip)"#;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn distortion_aberration_vignette_and_curve_are_one_pass_with_three_reads() {
    let nodes = Nodes::new(CHAIN, &[("scene", "Color")]);
    let (graph, picture) = (nodes.graph(), smooth(96, 54));
    let plan = Run::new(&graph).plan(&gpu(), &[("scene", &picture)]);
    let names: Vec<Vec<String>> = plan.passes.iter().map(|pass| pass.pass.nodes.clone()).collect();
    assert_eq!(names, [vec!["exposed"], vec!["bent", "fringed", "dark", "result"]], "{}", plan.to_text());
    let reads = plan.passes[1].pass.kernels.iter().filter(|kernel| kernel.reads_texture()).count();
    assert_eq!(reads, 3);
    assert!(plan.to_text().contains("bent"), "{}", plan.to_text());
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn warps_in_one_pass_equal_separate_ones_but_for_one_filter() {
    let text = r#"
        "bent": LensDistortion(source: "scene", k1: -0.15, k2: 0.02, zoom: 1.4),
        "result": ChromaticAberration(source: "bent", red: 0.02, blue: -0.03, growth: 0.0)"#;
    let nodes = Nodes::new(text, &[("scene", "Color")]);
    let (graph, picture) = (nodes.graph(), smooth(192, 108));
    let input = [("scene", &picture)];
    let fused = Run::new(&graph).exact().frame(&input).remove(0);
    let mut run = Run::new(&graph).exact();
    run.options = Options { fuse: false, ..run.options };
    let separate = run.frame(&input).remove(0);
    let lens = Lens { k: [-0.15, 0.02, 0.0], p: [0.0; 2] };
    // The image between both warps has a border.
    let half = 0.5 * 192.0_f64.hypot(108.0);
    let inside = |x: f64, pixels: f64| x.clamp(-0.5 * (pixels - 1.0) / half, 0.5 * (pixels - 1.0) / half);
    let bent = |[x, y]: [f64; 2]| inverse(|place| lens.brown(place), [inside(x, 192.0) / 1.4, inside(y, 108.0) / 1.4]);
    let [red, green, blue] = [0.02, 0.0, -0.03].map(|m| aberration(m, 0.0));
    let [red, green, blue] = [&red, &green, &blue].map(|warp| move |place| bent(warp(place)));
    let once = warped(&image(&picture), [&red, &green, &blue]);
    assert_close("one filter", &fused, &once, &PLACES);
    // A second bilinear filter lowers a ripple of 24 pixels by at most 1 - cos(pi / 24): 0.9 % of its height of 0.5.
    let twice = Tolerance { absolute: 0.006, relative: 0.0, of: Scale::Pixel, reason: "one more bilinear filter" };
    assert_close(
        "two filters",
        &separate,
        &image(&fused).map(|pixel| pixel),
        &Tolerance { of: Scale::Channel, ..twice },
    );
    assert!(error(&separate, &once) > 3.0 * error(&fused, &once), "one filter is better than two");
}

/// Hot air between a lens and its fringes: the mask is read at each of the three places, as the image is.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn hot_air_is_one_pass_with_the_warps_around_it() {
    let text = r#"
        "bent": LensDistortion(source: "scene", k1: -0.05, zoom: 1.1),
        "hot": HeatHaze(source: "bent", mask: "mask", strength: 0.03, scale: 0.3),
        "result": ChromaticAberration(source: "hot", red: 0.02, blue: -0.03, growth: 0.0)"#;
    let nodes = Nodes::new(text, &[("scene", "Color"), ("mask", "Mask")]);
    let (graph, picture) = (nodes.graph(), smooth(192, 108));
    // Another size than the image's.
    let mask = Picture::new(24, 12, |x, y| [(x as f32 / 20.0).min(1.0) * (1.0 - y as f32 / 24.0), 0.0, 0.0, 1.0]);
    let inputs = [("scene", &picture), ("mask", &mask)];
    let mut run = Run::new(&graph).exact();
    run.time = 2.0;
    let plan = run.plan(&gpu(), &inputs);
    let last = plan.passes.last().expect("it has passes");
    assert_eq!(last.pass.nodes, ["bent", "hot", "result"], "{}", plan.to_text());
    let fused = run.frame(&inputs).remove(0);
    run.options = Options { fuse: false, ..run.options };
    let separate = run.frame(&inputs).remove(0);
    // Two more bilinear filters lower a ripple of 24 pixels by at most 1.8 % of its height of 0.5, where hot air does not
    // make it shorter.
    let twice = Tolerance { absolute: 0.025, relative: 0.0, of: Scale::Channel, reason: "two more bilinear filters" };
    assert_close("separate passes", &separate, &image(&fused), &twice);
    assert!(error(&separate, &image(&fused)) < 0.01, "{}", error(&separate, &image(&fused)));
    let calm = text.replace("0.03, scale", "0.0, scale");
    let calm = Nodes::new(&calm, &[("scene", "Color"), ("mask", "Mask")]);
    let calm = image(&calm.exact(&[&picture, &mask]));
    assert!(error(&fused, &calm) > 0.05, "the air is hot");
}

/// The air rises with the time of the frame, and a mask of nothing leaves the image as it is.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn hot_air_rises_with_the_time() {
    let picture = smooth(96, 54);
    let haze = Haze { strength: 0.04, scale: 0.3, speed: 0.25, shape: 1.6, time: 0.0 };
    let graph =
        Nodes::new("\"result\": HeatHaze(source: \"in\", strength: 0.04, scale: 0.3)", &[("in", "Color")]).graph();
    for time in [0.0, 2.5, 700.0] {
        let mut run = Run::new(&graph).exact();
        run.time = time;
        let found = run.frame(&[("in", &picture)]).remove(0);
        let wanted = Haze { time, ..haze }.apply(&image(&picture), None);
        assert_close(&format!("after {time} s"), &found, &wanted, &PLACES);
    }
    let masked = "\"result\": HeatHaze(source: \"in\", mask: \"mask\", strength: 0.1)";
    let cold = Picture::new(5, 3, |_, _| [0.0, 1.0, 1.0, 1.0]);
    let found = Nodes::new(masked, &[("in", "Color"), ("mask", "Mask")]).exact(&[&picture, &cold]);
    assert_eq!(found, picture);
}

/// Mean differences between each of 16 frames and the next, at 60 in a second from a time on.
fn changes(graph: &Graph, picture: &Picture, from: f64) -> Vec<f64> {
    let shown = |frame: u32| {
        let mut run = Run::new(graph).exact();
        run.time = from + f64::from(frame) / 60.0;
        run.frame(&[("in", picture)]).remove(0)
    };
    let frames: Vec<Picture> = (0..=16).map(shown).collect();
    frames.windows(2).map(|pair| error(&pair[1], &image(&pair[0]))).collect()
}

/// The judge is the motion of the first minute: after a week it is as fast and as even.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_moves_with_the_time_moves_as_well_after_a_week() {
    const WEEK: f64 = 7.0 * 86_400.0;
    let picture = smooth(96, 54);
    let haze =
        Nodes::new("\"result\": HeatHaze(source: \"in\", strength: 0.1, scale: 0.3)", &[("in", "Color")]).graph();
    let early = changes(&haze, &picture, 10.0);
    for from in [4.0 * 3600.0, WEEK, 52.0 * WEEK] {
        let late = changes(&haze, &picture, from + 0.3);
        let [mean, first] = [&late, &early].map(|all| all.iter().sum::<f64>() / all.len() as f64);
        assert!((0.5..2.0).contains(&(mean / first)), "{from} s: {late:?} and {early:?}");
        let (least, most) = (late.iter().copied().fold(f64::MAX, f64::min), late.iter().copied().fold(0.0, f64::max));
        assert!(most < 3.0 * least, "{from} s: {late:?}");
    }
    // Thirty changes in a second, each of all blocks.
    let text = "\"result\": Glitch(source: \"in\", rate: 30.0, share: 1.0)";
    let glitch = Nodes::new(text, &[("in", "Exposed")]).graph();
    for from in [10.0, 4.0 * 3600.0, WEEK, 52.0 * WEEK] {
        let steps = changes(&glitch, &picture, from + 0.005);
        let is_each_second = |parity: usize| steps.iter().enumerate().all(|(i, off)| (*off > 0.0) == (i % 2 == parity));
        assert!(is_each_second(0) || is_each_second(1), "{from} s: {steps:?}");
    }
}

/// The mean error of the colors.
fn error(found: &Picture, wanted: &Image) -> f64 {
    let off = |(found, wanted): (&[f32; 4], &[f64; 4])| {
        let wanted = rgb(*wanted);
        (0..3).map(|c| (f64::from(found[c]) - wanted[c]).abs()).sum::<f64>()
    };
    found.pixels.iter().zip(&wanted.pixels).map(off).sum::<f64>() / found.pixels.len() as f64
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn two_aberrations_store_the_image_between_them() {
    let text = r#"
        "first": ChromaticAberration(source: "scene"),
        "result": ChromaticAberration(source: "first")"#;
    let nodes = Nodes::new(text, &[("scene", "Color")]);
    let picture = smooth(32, 18);
    let plan = Run::new(&nodes.graph()).plan(&gpu(), &[("scene", &picture)]);
    let of_first = plan.passes.iter().filter(|pass| pass.pass.nodes == ["first"]).count();
    assert_eq!(of_first, 1, "nine reads cost more than an image: {}", plan.to_text());
}
