//! One row for each built-in kind: nodes to run, and the image that a CPU reference makes of the same input, or pixels
//! with known values. A kind without a row fails a test.

use std::collections::BTreeSet;

use super::bloom::{self, blurred, caracal_taps, levels};
use super::color::{self, OneFile, noise, stored, stored_light, tolerance};
use super::local::{RANGE, SIGMAS, SIZE, wide};
use super::metering::{BINS, LIMITS};
use crate::reference::bloom::{additive_chain, composite_lerp, knee_weight, lerp_chain};
use crate::reference::color::{BRADFORD, luminance, white_balance_target};
use crate::reference::curves::{UCHIMURA, display, narkowicz, uchimura};
use crate::reference::exposure::{auto_exposure_stops, limit_mean, pyramid_mean};
use crate::reference::film_grain::Grain;
use crate::reference::gaussian::radius;
use crate::reference::grade::{Cdl, LiftGammaGain, balance, brightness, contrast, saturation};
use crate::reference::image::{Image, centre_uv, rgb};
use crate::reference::local::{Grid, LocalToneMap, Splat};
use crate::reference::lut::Cube;
use crate::reference::math::{Rgb, largest, transform};
use crate::reference::purkinje::{full, simple, strength_log};
use crate::reference::resample::{Down, Firefly, Up, downsample, half_size, upsample};
use crate::reference::transfer::{dither, srgb_encode};
use crate::reference::vignette;
use crate::support::gpu::{Picture, Run};
use crate::support::harness::{Nodes, Scale, Tolerance, assert_close, image};

/// Nodes from the input `scene` to the node `result`, and their CPU reference.
struct Reference {
    kind: &'static str,
    /// The state of `scene`.
    state: &'static str,
    nodes: String,
    scene: fn([u32; 2]) -> Picture,
    expected: Box<dyn Fn(&Image) -> Image>,
    tolerance: Tolerance,
}

impl Reference {
    fn new(
        (kind, state): (&'static str, &'static str),
        nodes: &str,
        scene: fn([u32; 2]) -> Picture,
        tolerance: Tolerance,
        expected: impl Fn(&Image) -> Image + 'static,
    ) -> Self {
        Self { kind, state, nodes: nodes.to_owned(), scene, expected: Box::new(expected), tolerance }
    }

    /// A kind that maps each colour by itself.
    fn colors(
        (kind, state): (&'static str, &'static str),
        parameters: &str,
        tolerance: Tolerance,
        expected: impl Fn(Rgb) -> Rgb + 'static,
    ) -> Self {
        let nodes = format!("\"result\": {kind}(source: \"scene\", {parameters})");
        let scene = if state == "Color" || state == "Exposed" { color::light } else { color::unit };
        Self::new((kind, state), &nodes, scene, tolerance, move |image| image.map_rgb(&expected))
    }
}

const ROUNDING: Tolerance = color::ARITHMETIC;
const POWERS: Tolerance = color::TRANSCENDENTAL;

/// Every row with a CPU reference.
fn references() -> Vec<Reference> {
    [exposure_and_grade(), display_kinds(), bloom_kinds(), local_kinds(), metering_kinds()]
        .into_iter()
        .flatten()
        .collect()
}

fn exposure_and_grade() -> Vec<Reference> {
    let cdl = Cdl { slope: [1.1, 1.0, 0.9], offset: [0.0; 3], power: [0.9, 1.0, 1.1], saturation: 1.2 };
    let lift = LiftGammaGain { lift: [0.1, 0.05, 0.0], gamma: [1.1, 1.0, 0.9], gain: [1.2, 1.0, 0.8] };
    let white = white_balance_target(&BRADFORD, [1.0, 0.5, 0.75], true);
    vec![
        Reference::colors(("Exposure", "Color"), "stops: -1.5", ROUNDING, |rgb| rgb.map(|x| x * (-1.5_f64).exp2())),
        Reference::colors(("WhiteBalance", "Exposed"), "target: (1.0, 0.5, 0.75)", ROUNDING, move |rgb| {
            stored_light(transform(&white, rgb))
        }),
        Reference::colors(("Saturation", "Exposed"), "amount: 0.5", ROUNDING, |rgb| stored_light(saturation(rgb, 0.5))),
        Reference::colors(("Brightness", "Encoded"), "amount: 0.1", ROUNDING, |rgb| {
            stored_light(rgb.map(|x| brightness(x, 0.1)))
        }),
        Reference::colors(("Contrast", "Encoded"), "form: Linear, amount: 1.5, pivot: 0.25", ROUNDING, |rgb| {
            stored_light(rgb.map(|x| contrast(x, 1.5, 0.25)))
        }),
        Reference::colors(("ColorBalance", "Encoded"), "multiply: (1.1, 1.0, 0.9)", ROUNDING, |rgb| {
            stored_light(balance(rgb, [1.1, 1.0, 0.9]))
        }),
        Reference::colors(
            ("Cdl", "Encoded"),
            "slope: (1.1, 1.0, 0.9), power: (0.9, 1.0, 1.1), saturation: 1.2",
            POWERS,
            move |rgb| stored(cdl.apply(rgb)),
        ),
        Reference::colors(
            ("LiftGammaGain", "DisplayLinear"),
            "lift: (0.1, 0.05, 0.0), gamma: (1.1, 1.0, 0.9), gain: (1.2, 1.0, 0.8)",
            tolerance(2e-6, 2e-5, "a power multiplies the error of its base by the inverse of gamma"),
            move |rgb| stored(lift.apply(rgb)),
        ),
    ]
}

/// Kinds that make or change an image for a display.
fn display_kinds() -> Vec<Reference> {
    let cube = Cube::new(5, color::lut::look);
    let one_code = tolerance(1.0 / 255.0, 0.0, "a value at the border of two codes may be rounded to either");
    let table = tolerance(2.0 / 255.0, 0.0, "a table of half floats, interpolated between 48 colours a side");
    let grain = Grain { amount: 0.5, size: 1.5, color: 0.5, seed: 3 };
    vec![
        Reference::colors(("ToneMap", "Exposed"), "curve: Aces", POWERS, |rgb| display(rgb.map(narkowicz))),
        Reference::colors(("Encode", "DisplayLinear"), "transfer: Srgb", POWERS, |rgb| {
            rgb.map(|x| srgb_encode(x.clamp(0.0, 1.0)))
        }),
        Reference::colors(("ColorLut", "Encoded"), "file: \"look.cube\"", color::lut::LUT, move |rgb| {
            cube.tetrahedral(rgb)
        }),
        Reference::new(
            ("BakedGrade", "Exposed"),
            "\"result\": BakedGrade(source: \"scene\", curve: Uchimura, space: Rec709)",
            |size| color::picture(size, |index| [0.05 * (1 + index % 17) as f64; 3]),
            table,
            |image| image.map_rgb(|rgb| rgb.map(|x| srgb_encode(uchimura(x, &UCHIMURA).min(1.0)))),
        ),
        Reference::new(
            ("Dither", "Encoded"),
            "\"result\": Dither(source: \"scene\", bits: 8, seed: 7)",
            color::unit,
            one_code,
            |image| {
                at_pixels(image, |rgb, [x, y]| {
                    [0, 1, 2].map(|channel| {
                        let [u1, u2] = noise::random(x as u32, y as u32, channel, 7);
                        dither(rgb[channel], u1, u2, 8) / 255.0
                    })
                })
            },
        ),
        Reference::new(
            ("FilmGrain", "Encoded"),
            "\"result\": FilmGrain(source: \"scene\", amount: 0.5, size: 1.5, color: 0.5, seed: 3, animate: false)",
            color::unit,
            tolerance(2e-5, 0.0, "the pixel is divided by the size of a grain in f32"),
            move |image| at_pixels(image, |rgb, pixel| grain.apply(rgb, pixel)),
        ),
        Reference::new(
            ("Vignette", "Exposed"),
            "\"result\": Vignette(source: \"scene\", amount: 0.75, intensity: 0.5, smoothness: 0.25)",
            color::light,
            tolerance(1e-6, 2e-5, "the fade is the cube of a distance in f32"),
            |image| {
                at_pixels(image, |rgb, [x, y]| {
                    let uv = centre_uv(x, y, image.width, image.height);
                    let factor = vignette::factor(uv, 0.5, 0.25, 1.0);
                    rgb.map(|x| x * vignette::blended(factor, 0.75))
                })
            },
        ),
    ]
}

/// An image whose colours are mapped with the place of their pixels.
fn at_pixels(image: &Image, f: impl Fn(Rgb, [usize; 2]) -> Rgb) -> Image {
    Image::new(image.width, image.height, |x, y| {
        let [r, g, b, a] = image.texel(x as i64, y as i64);
        let [r, g, b] = f([r, g, b], [x, y]);
        [r, g, b, a]
    })
}

fn bloom_kinds() -> Vec<Reference> {
    let [loaded, sampled] = [bloom::WHOLE, bloom::SAMPLED].map(|precision| precision.within(precision.exact, 0.0));
    let mips = |image: &Image| levels(image, 3, Down::FourTap, Firefly::Off);
    let downsampled = "\"mips\": Downsample(source: \"scene\", levels: 3, filter: Tap4)";
    let light = |size| bloom::picture(size, false);
    vec![
        Reference::new(
            ("Extract", "Color"),
            "\"result\": Extract(source: \"scene\", threshold: 0.5, knee: 0.25)",
            light,
            loaded,
            |image| {
                image.map_rgb(|rgb| {
                    let weight = knee_weight(largest(rgb), 0.5, 0.25);
                    rgb.map(|x| x * weight)
                })
            },
        ),
        Reference::new(
            ("Downsample", "Color"),
            &format!("{downsampled} -> mips.coarsest"),
            light,
            sampled,
            move |image| mips(image).pop().expect("a pyramid has a level"),
        ),
        Reference::new(
            ("Upsample", "Color"),
            &format!("{downsampled}, \"result\": Upsample(source: \"mips\", blend: Add)"),
            light,
            sampled,
            move |image| additive_chain(&mips(image), Up::Tent, 1.0),
        ),
        Reference::new(
            ("GaussianPyramid", "Color"),
            &format!(
                "{downsampled}, \"soft\": GaussianPyramid(source: \"mips\", kernel: Caracal9), \
                 \"result\": Upsample(source: \"soft\", spread: 0.85, filter: Bilinear)"
            ),
            light,
            sampled,
            move |image| {
                let soft: Vec<Image> = mips(image).iter().map(blurred(&caracal_taps())).collect();
                lerp_chain(&soft, 0.85, Up::Bilinear, 1.0)
            },
        ),
        Reference::new(
            ("Gaussian", "Color"),
            "\"result\": Gaussian(source: \"scene\", kernel: Caracal9, taps: Exact)",
            light,
            loaded,
            |image| blurred(&caracal_taps())(image),
        ),
        Reference::new(
            ("Composite", "Color"),
            "\"half\": Downsample(source: \"scene\", levels: 1, filter: Box), \
             \"result\": Composite(base: \"scene\", bloom: \"half.coarsest\", blend: Mix, strength: 0.25)",
            light,
            sampled,
            |image| {
                let [width, height] = half_size(image.width, image.height);
                let level = downsample(image, [width, height], Down::Box);
                let bloom = upsample(&level, [image.width, image.height], Up::Tent, 1.0);
                Image::new(image.width, image.height, |x, y| {
                    let [base, bloom] = [image, &bloom].map(|image| image.texel(x as i64, y as i64));
                    let [r, g, b] = composite_lerp(rgb(base), rgb(bloom), 0.25);
                    [r, g, b, base[3]]
                })
            },
        ),
    ]
}

/// A flat picture whose log2 luminance is at the centre of a cell of the grid: rounding moves no pixel to another cell.
fn in_one_slice([width, height]: [u32; 2]) -> Picture {
    let light = (-1.875_f32).exp2();
    Picture::new(width, height, |_, _| [light, light, light, 1.0])
}

/// The image that a probe shows of a grid: sums and weights in units of a pixel, then the range.
fn grid_image(grid: &Grid, image: &Image) -> Image {
    let capacity = image.width.div_ceil(SIZE[0]) * image.height.div_ceil(SIZE[1]);
    let unit = 512.0 / capacity as f64;
    Image::new(SIZE[0] * SIZE[1], SIZE[2], |x, y| {
        let [sum, weight] = grid.cells[x + SIZE[0] * SIZE[1] * y];
        [sum * unit, weight * unit, RANGE.low, RANGE.high]
    })
}

fn night(kind: &'static str, expected: impl Fn(Rgb) -> Rgb + 'static) -> Reference {
    let tolerance = Tolerance { of: Scale::Channel, ..tolerance(1e-6, 2e-4, "powers of small numbers in f32") };
    Reference::new(
        (kind, "Exposed"),
        &format!("\"result\": {kind}(source: \"scene\", illuminance: 0.8)"),
        color::light,
        tolerance,
        move |image| image.map_rgb(&expected).map_rgb(|rgb| rgb.map(|x| x.min(65504.0))),
    )
}

fn local_kinds() -> Vec<Reference> {
    let cell =
        |relative| Tolerance { of: Scale::Channel, ..tolerance(5.0, relative, "cells count in units of 1/512 pixel") };
    let grid = "\"grid\": GridBuild(source: \"scene\", method: Nearest)";
    let blurred = "\"blurred\": GridBlur(source: \"grid\")";
    let around = "\"around\": LogGaussian(source: \"scene\")";
    let build = |image: &Image| Grid::build(image, SIZE, RANGE, Splat::Nearest);
    let blur = move |image: &Image| build(image).blurred(SIGMAS, SIGMAS.map(radius));
    let settings = LocalToneMap { bilateral: 0.4, middle: 0.18_f64.log2(), contrast: 0.5, detail: 1.0 };
    vec![
        Reference::new(
            ("GridBuild", "Exposed"),
            &format!("{grid}, \"result\": ProbeVolume(volume: \"grid\")"),
            in_one_slice,
            cell(1e-4),
            move |image| grid_image(&build(image), image),
        ),
        Reference::new(
            ("GridBlur", "Exposed"),
            &format!("{grid}, {blurred}, \"result\": ProbeVolume(volume: \"blurred\")"),
            in_one_slice,
            cell(0.02),
            move |image| grid_image(&blur(image), image),
        ),
        Reference::new(
            ("LogGaussian", "Exposed"),
            "\"result\": LogGaussian(source: \"scene\")",
            smooth,
            tolerance(1e-3, 0.0, "half floats hold eleven bits of a logarithm"),
            |image| wide(image).map(|[l, ..]| [l, l, l, 1.0]),
        ),
        Reference::new(
            ("LocalToneMap", "Exposed"),
            &format!(
                "{grid}, {blurred}, {around}, \"result\": LocalToneMap(source: \"scene\", grid: \"blurred\", \
                 gaussian: \"around\", share: 0.4, contrast: 0.5, detail: 1.0)"
            ),
            smooth,
            Tolerance { of: Scale::Channel, ..tolerance(0.0, 1.4e-3, "0.002 stops: the grid stores half floats") },
            move |image| settings.apply(image, &blur(image), &wide(image)),
        ),
        night("Purkinje", |rgb| full(rgb, strength_log(0.8), 380.0)),
        night("PurkinjeSimple", |rgb| simple(rgb, 0.8)),
    ]
}

/// A gradient over twelve stops.
fn smooth([width, height]: [u32; 2]) -> Picture {
    Picture::new(width, height, |x, y| {
        let light = (-8.0 + 12.0 * (x + y) as f32 / (width + height) as f32).exp2();
        [light, 0.75 * light, 0.5 * light, 0.5]
    })
}

/// A flat picture at the centre of a bin: rounding moves no pixel to another bin.
fn in_one_bin([width, height]: [u32; 2]) -> Picture {
    let light = BINS.centre(150).exp2() as f32;
    Picture::new(width, height, |_, _| [light, light, light, 1.0])
}

/// The one pixel that a probe shows of an exposure: stops within the default limits of EV100, the metered mean in log2,
/// the illuminance, 1.
fn exposure(mean: f64) -> Image {
    let lux = std::f64::consts::PI / 0.18 * mean.exp2();
    Image::new(1, 1, |_, _| [auto_exposure_stops(limit_mean(mean, LIMITS[0], LIMITS[1]), 0.18, 0.0), mean, lux, 1.0])
}

/// The words of a histogram: the brightest channel, the range, the number of bins; then counts, low and high halves.
fn histogram_image(image: &Image) -> Image {
    let brightest = image.pixels.iter().flat_map(|pixel| rgb(*pixel)).fold(0.0, f64::max);
    let header = [brightest, BINS.low, BINS.high, BINS.count as f64].map(|word| [word, 0.0, 0.0, 0.0]);
    let counts = BINS.histogram(image).into_iter();
    let counts = counts.map(|count| [f64::from(count & 0xffff), f64::from(count >> 16), 0.0, 0.0]);
    Image { width: 4 + BINS.count, height: 1, pixels: header.into_iter().chain(counts).collect() }
}

fn metering_kinds() -> Vec<Reference> {
    let histogram = "\"bins\": Histogram(source: \"scene\")";
    let logarithm = Tolerance { of: Scale::Channel, ..tolerance(2e-4, 1e-4, "sums of logarithms in fixed point") };
    let mean = |image: &Image| {
        let lights: Vec<f64> = image.pixels.iter().map(|pixel| luminance(rgb(*pixel))).collect();
        pyramid_mean(&lights, BINS.low)
    };
    let metered = "\"mean\": MeanLuminance(source: \"scene\"), \"value\": Adapt(mean: \"mean\"), \
                   \"result\": ProbeValue(value: \"value\")";
    vec![
        Reference::new(
            ("Histogram", "Color"),
            &format!("{histogram}, \"result\": ProbeTable(table: \"bins\")"),
            in_one_bin,
            tolerance(0.0, 0.0, "integers"),
            histogram_image,
        ),
        Reference::new(
            ("AutoExposure", "Color"),
            &format!(
                "{histogram}, \"value\": AutoExposure(histogram: \"bins\"), \"result\": ProbeValue(value: \"value\")"
            ),
            in_one_bin,
            logarithm,
            |_| exposure(BINS.centre(150)),
        ),
        Reference::new(("MeanLuminance", "Color"), metered, smooth, logarithm, move |image| exposure(mean(image))),
        Reference::new(("Adapt", "Color"), metered, smooth, logarithm, move |image| exposure(mean(image))),
    ]
}

/// Pixels with known values, of nodes without inputs.
struct Vector {
    kind: &'static str,
    nodes: &'static str,
    frame: [u32; 2],
    /// Pixels and their values.
    pixels: &'static [([u32; 2], [f64; 4])],
    tolerance: Tolerance,
}

/// Depths of the built-in scene where rays hit planes of the room. The camera's position, its target and the planes are
/// numbers of the scene; the depths follow from the intersection of a ray with a plane.
const VECTORS: &[Vector] = &[Vector {
    kind: "DemoScene",
    nodes: "\"room\": DemoScene() -> room.depth",
    frame: [640, 360],
    pixels: &DEPTHS,
    tolerance: tolerance(0.0, 1e-5, "divisions in f32"),
}];

/// In order: the floor twice, the ceiling, the left and the right wall.
const DEPTHS: [([u32; 2], [f64; 4]); 5] = [
    ([320, 359], [3.8363649822244215, 0.0, 0.0, 1.0]),
    ([100, 350], [4.04903551600751, 0.0, 0.0, 1.0]),
    ([320, 5], [6.153237707082026, 0.0, 0.0, 1.0]),
    ([5, 100], [6.321097773706614, 0.0, 0.0, 1.0]),
    ([635, 100], [4.079100914540608, 0.0, 0.0, 1.0]),
];

#[test]
fn every_kind_has_a_cpu_reference_or_a_vector() {
    let rows = references().into_iter().map(|row| row.kind).chain(VECTORS.iter().map(|row| row.kind));
    let covered: BTreeSet<&str> = rows.collect();
    let kinds: BTreeSet<&str> = afterimage_nodes::ALL.iter().map(|kind| kind.name()).collect();
    let missing: Vec<&&str> = kinds.difference(&covered).collect();
    assert!(missing.is_empty(), "no CPU reference and no vector: {missing:?}");
    let unknown: Vec<&&str> = covered.difference(&kinds).collect();
    assert!(unknown.is_empty(), "no such kinds: {unknown:?}");
}

/// Fails unless a node of the kind runs: a skipped one proves nothing.
fn assert_runs(kind: &str, run: &Run<'_>, pictures: &[(&str, &Picture)]) {
    let plan = run.plan(&crate::support::gpu::gpu(), pictures);
    let is_of_kind = |name: &String| run.graph.nodes.iter().any(|node| node.name == *name && node.kind.name() == kind);
    let runs = plan.passes.iter().any(|pass| pass.pass.nodes.iter().any(is_of_kind));
    assert!(runs, "no pass runs a node of the kind {kind}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_kind_with_a_cpu_reference_equals_it() {
    let cube = OneFile(Cube::new(5, color::lut::look).text().into_bytes());
    for row in references() {
        let inputs = [("scene", row.state)];
        let nodes = Nodes::new(&row.nodes, &inputs).files(&cube);
        for size in color::SIZES {
            let scene = (row.scene)(size);
            // The pyramid of a picture of a few pixels has one level, and no pass joins it.
            if size[0] > 3 {
                assert_runs(row.kind, &Run::new(&nodes.graph()), &nodes.named(&[&scene]));
            }
            let expected = (row.expected)(&image(&scene));
            assert_close(&format!("{} at {size:?}", row.kind), &nodes.exact(&[&scene]), &expected, &row.tolerance);
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_kind_with_a_vector_has_its_values() {
    for row in VECTORS {
        let graph = Nodes::new(row.nodes, &[]).graph();
        let mut run = Run::new(&graph).exact();
        run.size = afterimage_graph::image::Size::new(row.frame[0], row.frame[1]);
        assert_runs(row.kind, &run, &[]);
        let found = run.frame(&[]).remove(0);
        for ([x, y], expected) in row.pixels {
            let found = Picture::new(1, 1, |_, _| found.at(*x, *y));
            let expected = Image::new(1, 1, |_, _| *expected);
            assert_close(&format!("{} at ({x}, {y})", row.kind), &found, &expected, &row.tolerance);
        }
    }
}
