//! Extract, Downsample, Upsample, Gaussian and Composite on the GPU, compared with their CPU references.

use std::sync::Arc;

use super::probes::sanitized;
use crate::reference::bloom::{self, composite_add, composite_lerp, gate_weight, knee_weight, select_emissive};
use crate::reference::color::luminance;
use crate::reference::gaussian;
use crate::reference::image::{Image, rgb};
use crate::reference::math::largest;
use crate::reference::resample::{Down, Firefly, Up, upsample};
use crate::support::gpu::{Picture, Run, gpu};
use crate::support::harness::{Nodes, Scale, Tolerance, assert_close, image};
use crate::support::numbers::Numbers;
use crate::support::player::Player;

/// One texel, thinner than a filter, odd in both directions, a power of two, a frame with odd sides.
const SIZES: [[u32; 2]; 5] = [[1, 1], [2, 3], [5, 3], [64, 64], [641, 359]];

/// The brightest number that a half float holds.
const BRIGHTEST: f64 = 65504.0;

/// Tolerances relative to the brightest expected number within four pixels.
#[derive(Clone, Copy)]
pub(super) struct Precision {
    /// With 32 bits between the passes.
    pub(super) exact: f64,
    /// With half floats between the passes.
    half: f64,
    reason: &'static str,
}

impl Precision {
    pub(super) fn within(&self, relative: f64, absolute: f64) -> Tolerance {
        Tolerance { absolute, relative, of: Scale::Neighbourhood, reason: self.reason }
    }
}

pub(super) const WHOLE: Precision = Precision { exact: 1e-5, half: 2e-3, reason: "texels are loaded: only rounding" };
pub(super) const SAMPLED: Precision =
    Precision { exact: 4e-3, half: 7e-3, reason: "a sampler may round its weights to 1/256" };

/// Scene light up to 8 with alpha in 0..1. Each of the `spikes` is the brightest number, in one channel of one pixel in
/// fifty.
pub(super) fn picture([width, height]: [u32; 2], spikes: bool) -> Picture {
    let mut numbers = Numbers(0x2545_f491_4f6c_dd1d);
    Picture::new(width, height, |x, y| {
        let light = 8.0 * numbers.next() * numbers.next();
        let mut pixel = [light * numbers.next(), light * numbers.next(), light * numbers.next(), numbers.next()];
        if spikes && numbers.next() < 0.02 {
            pixel[(x + y) as usize % 3] = BRIGHTEST;
        }
        pixel.map(|v| v as f32)
    })
}

fn bounded(image: Image) -> Image {
    image.map(|pixel| pixel.map(|v| v.min(BRIGHTEST)))
}

const SCENE: &[(&str, &str)] = &[("scene", "Color")];

/// A texture unit weighs two texels in steps of 1/256. Exact pipelines compute the weights: a tap is misplaced by less
/// than a hundredth of that.
const WEIGHT_STEPS: f64 = 100.0;

/// The error that misplaced taps cause: a GPU divides with an error of two and a half units in the last place, which
/// at a side of 641 texels moves a tap by 0.00005 texels.
fn misplaced(scene: &Picture) -> f64 {
    let brightest = scene.pixels.iter().flat_map(|pixel| &pixel[..3]).copied().fold(0.0, f32::max);
    if gpu().is_processor() { 0.0 } else { 5e-5 * f64::from(brightest) }
}

/// Compares `nodes` with the expected image, with 32 bits between passes and with 16.
fn check_on(nodes: &str, scene: &Picture, expected: &Image, precision: Precision) {
    let what = format!("{}x{}: {nodes}", scene.width, scene.height);
    let (nodes, slack) = (Nodes::new(nodes, SCENE), misplaced(scene));
    let (exact, half) =
        (precision.within(precision.exact, slack), precision.within(precision.half, slack * WEIGHT_STEPS));
    assert_close(&format!("exact {what}"), &nodes.exact(&[scene]), expected, &exact);
    assert_close(&what, &nodes.half(&[scene]), expected, &half);
}

/// Runs `nodes` at every size, without and with spikes.
fn check(nodes: &str, precision: Precision, reference: impl Fn(&Image) -> Image) {
    for size in SIZES {
        for spikes in [false, true] {
            let scene = picture(size, spikes);
            check_on(nodes, &scene, &bounded(reference(&image(&scene))), precision);
        }
    }
}

fn scaled(weight: impl Fn([f64; 4]) -> f64) -> impl Fn(&Image) -> Image {
    move |image| {
        image.map(|pixel| {
            let weight = weight(pixel);
            [pixel[0] * weight, pixel[1] * weight, pixel[2] * weight, pixel[3]]
        })
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn extract_weighs_as_its_cpu_reference() {
    type Brightness = fn([f64; 3]) -> f64;
    let brightness: [(&str, Brightness); 2] = [("Max", largest), ("Luminance", luminance)];
    for (name, of) in brightness {
        let text = |method| {
            format!(
                r#""result": Extract(source: "scene", method: {method}, brightness: {name},
                    threshold: 0.5, knee: 0.25, intensity: 1.5)"#
            )
        };
        check(&text("Knee"), WHOLE, scaled(|pixel| 1.5 * knee_weight(of(rgb(pixel)), 0.5, 0.25)));
        check(&text("Gate"), WHOLE, scaled(|pixel| 1.5 * gate_weight(of(rgb(pixel)), 0.5, 0.25)));
    }
    check(r#""result": Extract(source: "scene", method: All, intensity: 0.25)"#, WHOLE, scaled(|_| 0.25));
    let hard = scaled(|pixel| knee_weight(largest(rgb(pixel)), 1.0, 0.0));
    check(r#""result": Extract(source: "scene", knee: 0.0)"#, WHOLE, hard);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn extract_takes_emission_from_alpha() {
    let nodes = r#""result": Extract(source: "scene", method: Emissive, threshold: 0.5, intensity: 2.0)"#;
    check(nodes, WHOLE, |image| {
        image.map(|pixel| {
            let [r, g, b] = select_emissive(pixel, 0.5, 2.0);
            [r, g, b, pixel[3]]
        })
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_gate_without_edges_lets_all_but_black_pass() {
    let scene = Picture::new(2, 1, |x, _| [x as f32 * 1e-3, 0.0, 0.0, 1.0]);
    let nodes = r#""result": Extract(source: "scene", method: Gate, threshold: 0.0, knee: 0.0)"#;
    check_on(nodes, &scene, &image(&scene), WHOLE);
}

/// The deck's clamp is the exponential curve and then a gate: the vectors `glare_extract` of the formula book.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_clamp_after_the_exponential_curve_is_the_deck_s() {
    let scene = Picture::new(6, 1, |x, _| {
        [[0.0; 3], [1.0; 3], [2.0; 3], [3.0; 3], [10.0; 3], [5.0, 0.2, 0.1]].map(|[r, g, b]| [r, g, b, 1.0])[x as usize]
    });
    let nodes = r#"
        "exposed": Exposure(source: "scene", stops: 0.0),
        "mapped": ToneMap(source: "exposed", curve: Exponential),
        "result": Extract(source: "mapped", method: Clamp)"#;
    let result = &Nodes::new(nodes, SCENE).exact(&[&scene]);
    let printed = [0.0, 0.0, 0.425441201, 1.6057573, 1.99990889, 0.0];
    for (x, want) in printed.into_iter().enumerate() {
        let got = f64::from(result.pixels[x][0]);
        assert!((got - want).abs() <= 2e-6 + 1e-5 * want, "{x}: {got}, expected {want}");
        let reference = bloom::glare(rgb(scene.pixels[x].map(f64::from)), 1.0)[0];
        assert!((got - reference).abs() <= 2e-6 + 1e-5 * reference, "{x}: {got}, the CPU reference has {reference}");
    }
}

const FILTERS: [(&str, Down); 4] =
    [("Box", Down::Box), ("Tap4", Down::FourTap), ("Tap9", Down::NineTap), ("Tap13", Down::ThirteenTap)];

/// As many levels as are asked for and the size allows.
pub(super) fn levels(image: &Image, asked: usize, filter: Down, firefly: Firefly) -> Vec<Image> {
    let most = image.width.max(image.height).ilog2() as usize;
    bloom::levels(image, asked.min(most).max(1), filter, firefly)
}

fn coarsest(image: &Image, asked: usize, filter: Down, firefly: Firefly) -> Image {
    levels(image, asked, filter, firefly).pop().expect("a pyramid has a level")
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn downsample_filters_as_its_cpu_reference() {
    for (name, filter) in FILTERS {
        for count in [1, 3] {
            let nodes =
                format!(r#""mips": Downsample(source: "scene", levels: {count}, filter: {name}) -> mips.coarsest"#);
            check(&nodes, SAMPLED, |image| coarsest(image, count, filter, Firefly::Off));
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn downsample_weighs_fireflies_as_its_cpu_reference() {
    for (name, filter) in FILTERS {
        for (how, firefly) in [("Groups", Firefly::Groups), ("Taps", Firefly::Taps)] {
            let nodes = format!(
                r#""mips": Downsample(source: "scene", levels: 2, filter: {name}, firefly: {how}) -> mips.coarsest"#
            );
            for size in SIZES {
                // A light leaks out of its texel by the rounding of the sampler's weights; next to the brightest number
                // that is light enough to change what its neighbours weigh, except where taps fall on corners.
                let steady = size.iter().all(|side| side % 2 == 0 || *side == 1);
                for spikes in [false, true].into_iter().filter(|spikes| steady || !spikes) {
                    let scene = picture(size, spikes);
                    check_on(&nodes, &scene, &coarsest(&image(&scene), 2, filter, firefly), SAMPLED);
                }
            }
        }
    }
}

/// A dim picture with a lamp of many pixels and single bright pixels at every place that a filter tells apart.
fn lamps() -> Picture {
    Picture::new(64, 64, |x, y| {
        let lamp = (20..28).contains(&x) && (36..44).contains(&y);
        let spark = y % 16 == x / 16 && x % 16 == 5 + y / 16;
        let light = if spark { 500.0 } else { f32::from(u8::from(lamp)) * 30.0 + 0.1 };
        [light, 0.5 * light, 0.25 * light, 1.0]
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_cheaper_filter_holds_fireflies_back_as_the_thirteen_taps_do() {
    let lamps = lamps();
    let glow = |filter: &str, firefly: &str| {
        let nodes = format!(
            r#""mips": Downsample(source: "scene", levels: 4, filter: {filter}, firefly: {firefly}) -> mips.coarsest"#
        );
        let level = Nodes::new(&nodes, SCENE).half(&[&lamps]);
        level.pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>()
    };
    let wanted = glow("Tap13", "Groups");
    for filter in ["Tap9", "Tap4", "Box"] {
        let ratio = glow(filter, "Groups") / wanted;
        assert!((0.85..1.15).contains(&ratio), "{filter}: {ratio}");
    }
    // Each tap by itself dims more, and no weights at all far less.
    assert!(glow("Tap4", "Taps") < 0.8 * wanted && glow("Tap4", "Off") > 1.2 * wanted);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn upsample_joins_levels_as_its_cpu_reference() {
    let nodes = |rest: &str| {
        format!(
            r#""mips": Downsample(source: "scene", levels: 4, filter: Tap4),
            "result": Upsample(source: "mips", {rest})"#
        )
    };
    let mips = |image: &Image| levels(image, 4, Down::FourTap, Firefly::Off);
    for (name, up) in [("Tent", Up::Tent), ("Bilinear", Up::Bilinear)] {
        let mixed = nodes(&format!("blend: Mix, spread: 0.7, filter: {name}, radius: 0.85"));
        check(&mixed, SAMPLED, |image| bloom::lerp_chain(&mips(image), 0.7, up, 0.85));
        let added = nodes(&format!("blend: Add, filter: {name}, radius: 1.25"));
        check(&added, SAMPLED, |image| bloom::additive_chain(&mips(image), up, 1.25));
    }
    check(&nodes("spread: 0.0"), SAMPLED, |image| mips(image).swap_remove(0));
    check(&nodes("spread: 1.0"), SAMPLED, |image| bloom::lerp_chain(&mips(image), 1.0, Up::Tent, 1.0));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn levels_that_are_not_normalised_are_summed() {
    let nodes = r#"
        "mips": Downsample(source: "scene", levels: 3, filter: Tap4),
        "result": Upsample(source: "mips", blend: Add, normalize: false)"#;
    let scene = picture([40, 24], false);
    let mips = levels(&image(&scene), 3, Down::FourTap, Firefly::Off);
    let sum = bloom::additive_chain(&mips, Up::Tent, 1.0).map(|pixel| pixel.map(|v| 3.0 * v));
    check_on(nodes, &scene, &sum, SAMPLED);
}

pub(super) fn blurred(half: &[f64]) -> impl Fn(&Image) -> Image {
    move |image| gaussian::blur_axis(&gaussian::blur_axis(image, half, [1, 0]), half, [0, 1])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn gaussian_blurs_as_its_cpu_reference() {
    let nodes = |rest: &str| format!(r#""result": Gaussian(source: "scene", {rest})"#);
    for (taps, tolerance) in [("Exact", WHOLE), ("Linear", SAMPLED)] {
        for sigma in [0.6, 2.5] {
            let half = gaussian::taps(sigma, gaussian::radius(sigma));
            check(&nodes(&format!("sigma: {sigma}, taps: {taps}")), tolerance, blurred(&half));
        }
        let caracal = caracal_taps();
        check(&nodes(&format!("kernel: Caracal9, taps: {taps}")), tolerance, blurred(&caracal));
    }
}

/// Half of the nine taps that Caracal uses.
pub(super) fn caracal_taps() -> Vec<f64> {
    printed(&[0.227027, 0.194596, 0.121621, 0.054054, 0.016216])
}

/// Half a kernel as a document prints it, made to sum to 1.
fn printed(half: &[f64]) -> Vec<f64> {
    let total = half[0] + 2.0 * half[1..].iter().sum::<f64>();
    half.iter().map(|weight| weight / total).collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_deck_s_33_taps_are_those_it_prints() {
    let deck = printed(&[
        0.113597, 0.109084, 0.096593, 0.07887, 0.059384, 0.04123, 0.026396, 0.015583, 0.008483, 0.004258, 0.001971,
        0.000841, 0.000331, 0.00012, 0.00004, 0.000012, 0.000004,
    ]);
    // Without spikes: six printed digits of a weight are too few for them.
    for (taps, tolerance) in [("Exact", WHOLE), ("Linear", SAMPLED)] {
        let nodes = format!(r#""result": Gaussian(source: "scene", kernel: Course33, taps: {taps})"#);
        for size in SIZES {
            let scene = picture(size, false);
            check_on(&nodes, &scene, &blurred(&deck)(&image(&scene)), tolerance);
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_widest_blur_is_still_a_gaussian() {
    let half = gaussian::taps(64.0, 256);
    let scene = picture([64, 64], false);
    let nodes = r#""result": Gaussian(source: "scene", sigma: 64.0, reach: 4.0)"#;
    check_on(nodes, &scene, &blurred(&half)(&image(&scene)), WHOLE);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pyramid_is_blurred_level_by_level() {
    let nodes = r#"
        "mips": Downsample(source: "scene", levels: 3, filter: Tap4),
        "soft": GaussianPyramid(source: "mips", kernel: Caracal9),
        "result": Upsample(source: "soft", spread: 0.85, filter: Bilinear)"#;
    let half = caracal_taps();
    check(nodes, SAMPLED, |image| {
        let soft: Vec<Image> = levels(image, 3, Down::FourTap, Firefly::Off).iter().map(blurred(&half)).collect();
        bloom::lerp_chain(&soft, 0.85, Up::Bilinear, 1.0)
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn composite_adds_and_mixes_light_as_its_cpu_reference() {
    for ([width, height], spikes) in SIZES.into_iter().flat_map(|size| [(size, false), (size, true)]) {
        let scene = picture([width, height], spikes);
        let light = picture([width.div_ceil(2), height.div_ceil(2)], spikes);
        for (filter, up) in [("Tent", Up::Tent), ("Bilinear", Up::Bilinear)] {
            let large = upsample(&image(&light), [width as usize, height as usize], up, 1.0);
            for (blend, reference) in [("Add", composite_add as fn(_, _, _) -> _), ("Mix", composite_lerp)] {
                let nodes = format!(
                    r#""result": Composite(base: "scene", bloom: "light",
                        blend: {blend}, filter: {filter}, strength: 0.3)"#
                );
                let pairs = scene.pixels.iter().zip(&large.pixels);
                let pixels = pairs.map(|(base, light)| {
                    let base = base.map(f64::from);
                    let [r, g, b] = reference(rgb(base), rgb(*light), 0.3);
                    [r, g, b, base[3]]
                });
                let want = Image { pixels: pixels.collect(), ..large };
                let got = Nodes::new(&nodes, &[("scene", "Color"), ("light", "Color")]).exact(&[&scene, &light]);
                let tolerance = SAMPLED.within(SAMPLED.exact, 0.0);
                assert_close(&format!("{width}x{height}: {nodes}"), &got, &bounded(want), &tolerance);
            }
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_brightest_lights_stay_within_half_range() {
    let scene = Picture::new(9, 7, |_, _| [BRIGHTEST as f32, BRIGHTEST as f32, 0.0, 1.0]);
    let nodes = r#"
        "bright": Extract(source: "scene", intensity: 64.0),
        "mips": Downsample(source: "bright", levels: 3),
        "bloom": Upsample(source: "mips", blend: Add, normalize: false),
        "result": Composite(base: "scene", bloom: "bloom", strength: 8.0)"#;
    check_on(nodes, &scene, &image(&scene), WHOLE);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn nan_and_infinity_of_a_picture_do_not_spread() {
    let mut scene = picture([37, 21], false);
    scene.pixels[37 * 10 + 18] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    let guarded = sanitized(&scene);
    let nodes = r#"
        "mips": Downsample(source: "scene", levels: 3, filter: Tap13),
        "result": Upsample(source: "mips", spread: 0.5)"#;
    let mips = levels(&guarded, 3, Down::ThirteenTap, Firefly::Off);
    check_on(nodes, &scene, &bloom::lerp_chain(&mips, 0.5, Up::Tent, 1.0), SAMPLED);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn bloom_is_the_same_drawn_and_dispatched() {
    let nodes = r#"
        "bright": Extract(source: "scene", method: Gate),
        "mips": Downsample(source: "bright", levels: 4, firefly: Groups),
        "soft": GaussianPyramid(source: "mips", kernel: Caracal9, taps: Linear),
        "bloom": Upsample(source: "soft", blend: Add),
        "result": Composite(base: "scene", bloom: "bloom")"#;
    let graph = Nodes::new(nodes, SCENE).graph();
    let scene = picture([97, 51], false);
    let dispatched = Run::new(&graph).frame(&[("scene", &scene)]);
    let drawn = Run { prefer_fragment: true, ..Run::new(&graph) }.frame(&[("scene", &scene)]);
    assert_close("drawn", &drawn[0], &image(&dispatched[0]), &WHOLE.within(WHOLE.half, 0.0));
}

/// Black with a square light of `side` pixels and the light of `side` squared pixels of `brightness`, `at` pixels right
/// of and below (20, 20).
fn light(side: f64, brightness: f64, at: f64) -> Picture {
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
    let mut player = Player::new();
    let plan = Run::new(&graph).plan(&player.gpu, &[("scene", &frames[0])]);
    player.executor.load(Arc::new(plan)).unwrap_or_else(|error| panic!("{error}"));
    let mut sums = Vec::new();
    for (index, frame) in frames.iter().enumerate() {
        player.frame(&[("scene", frame)], 0.0, index == 0);
        sums.push(player.output("out").pixels.iter().map(|pixel| f64::from(pixel[0])).sum());
    }
    sums
}

/// The largest difference from the mean, as a share of it.
fn variation(sums: &[f64]) -> f64 {
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

/// What `fireflies: Limit` makes of an image, with the frame before if there is one.
fn limited(image: &Image, before: Option<&Image>) -> Image {
    let bright = |image: &Image, x: i64, y: i64| largest(rgb(image.texel(x, y)));
    Image::new(image.width, image.height, |x, y| {
        let (x, y) = (x as i64, y as i64);
        let inside = |i: i64, j: i64| (0..image.width as i64).contains(&i) && (0..image.height as i64).contains(&j);
        let around = (-1..=1).flat_map(|j| (-1..=1).map(move |i| (x + i, y + j)));
        let near = around.filter(|&(i, j)| (i, j) != (x, y) && inside(i, j)).map(|(i, j)| bright(image, i, j));
        let past = before.map_or(0.0, |before| {
            let cell = |at: i64, side: usize| (at.max(0) / 2).min(side as i64 / 2 - 1);
            let columns = [cell(x - 1, image.width), cell(x + 1, image.width)];
            let rows = [cell(y - 1, image.height), cell(y + 1, image.height)];
            let cells = columns.into_iter().flat_map(|i| rows.map(|j| (i, j)));
            cells.map(|(i, j)| peak(before, i, j)).fold(0.0, f64::max)
        });
        let (limit, own) = (4.0 * near.fold(past, f64::max), bright(image, x, y));
        let [r, g, b, a] = image.texel(x, y);
        let factor = if own <= limit || image.pixels.len() == 1 { 1.0 } else { limit / own };
        [r * factor, g * factor, b * factor, a]
    })
}

/// The largest channel of the 2x2 pixels of a cell; up to 3x3 at odd sizes.
fn peak(image: &Image, i: i64, j: i64) -> f64 {
    let pixels = |cell: i64, side: usize| {
        let (side, half) = (side as i64, (side as i64 / 2).max(1));
        cell * side / half..((cell + 1) * side + half - 1) / half
    };
    let places = pixels(j, image.height).flat_map(|y| pixels(i, image.width).map(move |x| (x, y)));
    places.map(|(x, y)| largest(rgb(image.texel(x, y)))).fold(0.0, f64::max)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn fireflies_are_limited_as_in_the_cpu_reference() {
    let nodes = r#""result": Extract(source: "scene", method: All, fireflies: Limit)"#;
    check(nodes, WHOLE, |image| limited(image, None));
    let nodes = r#""bright": Extract(source: "scene", method: All, fireflies: Limit, before: "bright.peaks@previous")
        -> bright"#;
    for size in [[64, 64], [61, 39]] {
        let (first, mut second) = (picture(size, true), picture(size, false));
        // One spark beside one of the frame before, and one by itself.
        second.pixels[(5 + 9 * size[0]) as usize] = [900.0; 4];
        let graph = Nodes::new(nodes, SCENE).graph();
        let mut player = Player::new();
        let plan = Run::new(&graph).exact().plan(&player.gpu, &[("scene", &first)]);
        player.executor.load(Arc::new(plan)).unwrap_or_else(|error| panic!("{error}"));
        player.frame(&[("scene", &first)], 0.0, true);
        player.frame(&[("scene", &second)], 0.0, false);
        let wanted = limited(&image(&second), Some(&image(&first)));
        assert!(wanted != image(&second), "something is limited");
        assert_close("history", &player.output("out"), &wanted, &WHOLE.within(WHOLE.half, 0.0));
    }
}
