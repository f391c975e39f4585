//! Histogram, AutoExposure, MeanLuminance and Adapt, compared with their CPU references.

mod both;
mod fixed;
mod range;

use afterimage_graph::check::{Graph, NoFiles};

use super::probes::{SIZES, pipeline, sanitized, scene, shown, shown_with};
use crate::reference::color::luminance;
use crate::reference::exposure::{
    Aim, Bins, adapt_exponential, adapt_linear, auto_exposure_stops, gray_card_luminance, limit_mean, pyramid_mean,
};
use crate::reference::image::rgb;
use crate::reference::stride::sampled;
use crate::support::gpu::{Picture, Run};
use crate::support::harness::checked;
use crate::support::sequence::Sequence;
use crate::support::sweep;

/// The defaults of the metering kinds: EV100 -10 to 19.
pub(super) const BINS: Bins = Bins { count: 384, low: -13.0, high: 16.0, black: 0.0 };
/// The default limits of a metered mean in EV100.
pub(super) const LIMITS: [f64; 2] = [-10.0, 19.0];

/// The header and the bins of a shown table.
fn read_table(shown: &Picture) -> ([f32; 4], Vec<u32>) {
    let header = [0, 1, 2, 3].map(|i| shown.at(i, 0)[0]);
    let words = (4..4 + header[3] as u32).map(|i| shown.at(i, 0));
    (header, words.map(|[low, high, ..]| low as u32 + ((high as u32) << 16)).collect())
}

/// Bins may differ where the logarithm of a pixel falls on a border: few pixels, by one bin.
fn assert_close(found: &[u32], wanted: &[u32], what: &str) {
    let total: u32 = wanted.iter().sum();
    assert_eq!(found.iter().sum::<u32>(), total, "{what}: every pixel counts once");
    // A part of a pixel may round to either side.
    assert!(found[0].abs_diff(wanted[0]) <= total / 255 / 20, "{what}: pixels that do not count");
    let mut ahead = 0_i64;
    let moved: i64 = found
        .iter()
        .zip(wanted)
        .map(|(f, w)| {
            ahead += i64::from(*f) - i64::from(*w);
            ahead.abs()
        })
        .sum();
    assert!(moved <= i64::from(total) / 2000 + 255, "{what}: {moved} of {total} in another bin");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_histogram_equals_its_cpu_reference_at_every_size_and_step() {
    // The stride is used in images of this many pixels.
    let sizes = SIZES.map(|(width, height)| (width, height, 1));
    let large = sweep::some([(1901, 1903, 2), (1283, 719, 1), (2853, 2851, 3)], 1);
    for (width, height, step) in sizes.into_iter().chain(large) {
        let scene = scene(width, height);
        for asked in std::collections::BTreeSet::from([step, 4]) {
            let nodes =
                format!("\"h\": Histogram(source: \"scene\", step: {asked}), \"result\": ProbeTable(table: \"h\")");
            let (header, bins) = read_table(&shown(&nodes, &scene));
            let image = sampled(&sanitized(&scene), step);
            assert_close(&bins, &BINS.histogram(&image), &format!("{width}x{height} step {step}"));
            let brightest = image.pixels.iter().flat_map(|p| rgb(*p)).fold(0.0, f64::max);
            assert_eq!(header, [brightest as f32, -13.0, 16.0, 384.0]);
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_histogram_has_the_requested_bins_and_range() {
    let scene = scene(97, 53);
    let text = "\"h\": Histogram(source: \"scene\", bins: 64, lo: -6.0, hi: 4.0, black: 0.0), \"result\": ProbeTable(table: \"h\")";
    let (header, bins) = read_table(&shown(text, &scene));
    assert_eq!(&header[1..], [-6.0, 4.0, 64.0]);
    let value = text.replace("ProbeTable(table: \"h\")", "ShowValue(value: \"h.brightest\")");
    assert_eq!(shown(&value, &scene).at(0, 0), header);
    let wanted = Bins { count: 64, low: -6.0, high: 4.0, black: 0.0 }.histogram(&sanitized(&scene));
    assert!(wanted[1] > 100 && wanted[63] > 0, "the range cuts both ends: {wanted:?}");
    assert_close(&bins, &wanted, "64 bins");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_albedo_meters_light_and_not_paint() {
    let painted = Picture::new(70, 41, |x, y| {
        let albedo = if (x / 7 + y / 5) % 2 == 0 { 0.06 } else { 0.8 };
        let light = (f64::from(x) / 10.0 - 4.0).exp2() as f32;
        [albedo * light, albedo * light, albedo * light, 1.0]
    });
    let albedo = Picture::new(70, 41, |x, y| {
        let albedo = if (x / 7 + y / 5) % 2 == 0 { 0.06 } else { 0.8 };
        [albedo, albedo, albedo, if y < 4 { 0.0 } else { 1.0 }]
    });
    let text = "\"h\": Histogram(source: \"scene\", albedo: \"albedo\"), \"result\": ProbeTable(table: \"h\")";
    let (_, bins) = read_table(&shown_with(text, &painted, "albedo", &albedo));
    let mut wanted = vec![0; BINS.count];
    for (surface, pixel) in sanitized(&albedo).pixels.iter().zip(&sanitized(&painted).pixels) {
        let light = gray_card_luminance(luminance(rgb(*pixel)), luminance(rgb(*surface)));
        BINS.add(&mut wanted, if surface[3] < 0.5 { 0.0 } else { light });
    }
    assert!(wanted[0] >= 255 * 4 * 70);
    // A column of the picture has one illuminance, whatever it is painted with: half the bins stay empty.
    assert_close(&bins, &wanted, "albedo");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_mask_and_the_distance_from_the_middle_weigh_pixels() {
    let scene = Picture::new(64, 48, |x, _| if x < 32 { [0.25, 0.25, 0.25, 1.0] } else { [4.0, 4.0, 4.0, 1.0] });
    let mask = Picture::new(64, 48, |x, _| if x < 32 { [1.0, 0.0, 0.0, 1.0] } else { [0.2, 0.0, 0.0, 1.0] });
    let (quarter, four) = (BINS.bin(0.25), BINS.bin(4.0));
    let text = "\"h\": Histogram(source: \"scene\", mask: \"mask\"), \"result\": ProbeTable(table: \"h\")";
    let (_, bins) = read_table(&shown_with(text, &scene, "mask", &mask));
    assert_eq!((bins[quarter], bins[four]), (32 * 48 * 255, 32 * 48 * 51));
    let text = "\"h\": Histogram(source: \"scene\", weight: Center, center: (0.25, 0.5), radius: 0.5), \
                \"result\": ProbeTable(table: \"h\")";
    let (_, bins) = read_table(&shown(text, &scene));
    let weight = |x: u32, y: u32| {
        let away = [(f64::from(x) + 0.5) / 64.0 - 0.25, (f64::from(y) + 0.5) / 48.0 - 0.5];
        let squared = ((away[0] * 64.0 / 48.0).powi(2) + away[1].powi(2)) / 0.25;
        255.0 * (-squared).exp2()
    };
    let total = |from: u32| (from..from + 32).flat_map(|x| (0..48).map(move |y| weight(x, y))).sum::<f64>();
    for (bin, wanted) in [(quarter, total(0)), (four, total(32))] {
        assert!((f64::from(bins[bin]) / wanted - 1.0).abs() < 0.003, "{} {wanted}", bins[bin]);
    }
}

/// One pixel of each frame of a sequence of pictures.
fn sequence(graph: &Graph, frames: &[(&Picture, f32, bool)]) -> Vec<[f32; 4]> {
    let run = Run::new(graph).exact();
    let mut sequence = Sequence::new(&run);
    let mut first_pixel = |(picture, dt, reset): &(&Picture, f32, bool)| {
        sequence.frame(&[("scene", picture)], *dt, *reset);
        sequence.output("out").pixels[0]
    };
    frames.iter().map(&mut first_pixel).collect()
}

/// True if the pixel at x, y is bright.
type Pattern = fn(u32, u32) -> bool;

/// Pictures of two brightnesses that are 8.6 stops apart: lines, blinds, dots and squares.
const PATTERNS: [(&str, Pattern); 9] = [
    ("lines across", |_, y| y % 2 == 0),
    ("lines down", |x, _| x % 2 == 0),
    ("lines down, 3", |x, _| x % 3 == 0),
    ("blinds, 4", |_, y| y % 4 < 2),
    ("diagonals, 2", |x, y| (x + y) % 2 == 0),
    ("diagonals, 3", |x, y| (x + 2 * y) % 3 == 0),
    ("diagonals, 5", |x, y| (x + y) % 5 < 2),
    ("dots, 3", |x, y| x % 3 == 0 && y % 3 == 0),
    ("squares, 5", |x, y| (x / 5 + y / 5) % 2 == 0),
];

fn pattern(size: [u32; 2], shift: [u32; 2], is_bright: fn(u32, u32) -> bool) -> Picture {
    Picture::new(size[0], size[1], |x, y| {
        let light = if is_bright(x + shift[0], y + shift[1]) { 8.0 } else { 0.02 };
        [light, light, light, 1.0]
    })
}

/// The most stops by which a pattern's exposure changes when it moves by a pixel.
fn jump(graph: &Graph, size: [u32; 2], is_bright: fn(u32, u32) -> bool) -> f32 {
    let pictures = [[0, 0], [1, 0], [1, 1]].map(|shift| pattern(size, shift, is_bright));
    // Each frame is the first one: nothing adapts.
    let stops = sequence(graph, &pictures.each_ref().map(|picture| (picture, 0.0, true)));
    stops.windows(2).map(|pair| (pair[1][0] - pair[0][0]).abs()).fold(0.0, f32::max)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "a figure for the log")]
fn an_exposure_stays_when_a_pattern_moves_by_a_pixel() {
    for (size, step) in sweep::some([([640, 360], 4), ([2561, 1441], 8), ([1281, 719], 2)], 2) {
        let text = auto("").replace("source: \"scene\"", &format!("source: \"scene\", step: {step}"));
        let graph = pipeline(&text);
        for (name, is_bright) in PATTERNS {
            let jump = jump(&graph, size, is_bright);
            println!("{size:?}, step {step}, {name}: {jump:.4} stops");
            assert!(jump <= 0.05, "{size:?}, step {step}, {name}: {jump} stops");
        }
    }
}

fn gray(value: f32) -> Picture {
    Picture::new(8, 8, |_, _| [value, value, value, 1.0])
}

fn auto(parameters: &str) -> String {
    format!(
        "\"h\": Histogram(source: \"scene\"), \"auto\": AutoExposure(histogram: \"h\", {parameters}), \
         \"result\": ShowValue(value: \"auto\")"
    )
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn percentiles_cut_as_in_the_cpu_reference() {
    for (width, height) in SIZES {
        let scene = scene(width, height);
        let counts = BINS.histogram(&sanitized(&scene));
        for (low, high) in [(0.4, 0.95), (0.0, 1.0), (0.5, 0.5), (0.9, 0.2), (1.0, 1.0), (0.31, 0.3100001)] {
            let value = shown(&auto(&format!("low: {low}, high: {high}")), &scene).at(0, 0);
            let Some(mean) = BINS.trimmed_mean(&counts, low, high) else { panic!("some pixels count") };
            // One bin is 0.076 stops wide; a quantile may fall on either side of a border.
            let tolerance = if low >= high || high - low < 1e-6 { 0.08 } else { 2e-4 };
            assert!((f64::from(value[1]) - mean).abs() < tolerance, "{width}x{height} {low} {high}: {value:?} {mean}");
            let stops = auto_exposure_stops(limit_mean(mean, LIMITS[0], LIMITS[1]), 0.18, 0.0);
            assert!((f64::from(value[0]) - stops).abs() < tolerance + 1e-4, "{value:?} {stops}");
            let lux = std::f64::consts::PI / 0.18 * f64::from(value[1]).exp2();
            assert!((f64::from(value[2]) / lux - 1.0).abs() < 1e-4, "{value:?} {lux}");
            assert_eq!(value[3], 1.0);
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn limits_compensation_and_highlights_move_the_exposure() {
    let center = |light: f64| BINS.center(BINS.bin(light));
    let key = 0.18_f64.log2();
    for (parameters, light, wanted) in [
        ("compensation: 1.5", 0.5, key - center(0.5) + 1.5),
        ("min_ev: 5.0", 0.5, key - 2.0),
        ("max_ev: 1.0", 0.5, key + 2.0),
        ("key: 1.0", 4.0, -center(4.0)),
        // EV100 is log2 of luminance plus 3: the light 2^-2 is at EV 1, half way from -1 (2 stops) to 3 (-1 stop).
        (
            "curve_ev: (-3.0, -1.0, 3.0, 5.0), curve_stops: (4.0, 2.0, -1.0, 0.0)",
            0.25,
            key - center(0.25) + 0.5 - 0.75 * (center(0.25) + 2.0),
        ),
        ("highlights: Protect, highlight_threshold: 0.125", 0.5, -3.0 - (center(0.5) + 0.45 * 29.0 / 383.0)),
        ("highlights: Protect, highlight_threshold: 10.0", 0.5, key - center(0.5)),
    ] {
        let value = shown(&auto(parameters), &gray(light as f32)).at(0, 0);
        assert!((f64::from(value[0]) - wanted).abs() < 1e-4, "{parameters}: {value:?} {wanted}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn exposure_snaps_holds_arrives_and_follows() {
    let (dim, bright, black) = (gray(0.25), gray(16.0), gray(0.0));
    let nothing = f32::NAN;
    let frames: Vec<(&Picture, f32, bool)> = vec![
        (&black, 0.1, true),
        (&dim, 0.0, false),
        (&bright, 0.25, false),
        (&bright, 0.0, false),
        (&bright, -1.0, false),
        (&bright, nothing, false),
        (&black, 0.25, false),
        (&dim, 0.5, false),
        (&dim, f32::INFINITY, false),
        (&dim, 0.1, false),
        (&bright, 0.1, true),
        (&black, 0.1, true),
        (&dim, 0.1, false),
    ];
    let wanted = |light: f64| 0.18_f64.log2() - BINS.center(BINS.bin(light));
    let (of_dim, of_bright) = (wanted(0.25), wanted(16.0));
    for (mode, follow) in [
        ("Exponential", adapt_exponential as fn(f64, Aim, f64, f64, f64) -> f64),
        ("Linear", adapt_linear as fn(f64, Aim, f64, f64, f64) -> f64),
    ] {
        let first = follow(of_dim, Aim { before: of_dim, wanted: of_bright }, 0.25, 1.0, 3.0);
        let second = follow(first, Aim { before: of_bright, wanted: of_dim }, 0.5, 1.0, 3.0);
        let expected = [0.0, of_dim, first, first, first, first, first, second, of_dim, of_dim, of_bright, 0.0, of_dim];
        let graph = pipeline(&auto(&format!("adaptation: {mode}")));
        for (index, (value, wanted)) in sequence(&graph, &frames).iter().zip(expected).enumerate() {
            assert!((f64::from(value[0]) - wanted).abs() < 1e-4, "{mode} frame {index}: {value:?} {wanted}");
            assert_eq!(value[3] > 0.0, index != 0 && index != 11, "{mode} frame {index}: {value:?}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn adaptation_does_not_depend_on_the_frame_rate() {
    let (dim, bright) = (gray(0.25), gray(16.0));
    let graph = pipeline(&auto(""));
    let after = |rate: usize| {
        // The light goes out in no time: over a whole frame it would go out more slowly the fewer frames there are.
        let mut frames = vec![(&bright, 0.0, true), (&dim, 0.0, false)];
        frames.extend(std::iter::repeat_n((&dim, 1.0 / rate as f32, false), rate));
        f64::from(sequence(&graph, &frames).last().expect("frames")[0])
    };
    let [from, to] = [16.0, 0.25].map(|light| 0.18_f64.log2() - BINS.center(BINS.bin(light)));
    let wanted = from + (to - from) * (1.0 - (-1.0_f64).exp());
    for rate in [24, 60, 144] {
        assert!((after(rate) - wanted).abs() < 1e-3, "{rate}: {} {wanted}", after(rate));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_mean_is_the_top_of_a_pyramid_and_adapt_follows_it() {
    for (width, height) in SIZES {
        let scene = scene(width, height);
        let lights: Vec<f64> = sanitized(&scene).pixels.iter().map(|p| luminance(rgb(*p))).collect();
        let log = pyramid_mean(&lights, BINS.low);
        let linear = (lights.iter().sum::<f64>() / lights.len() as f64).max(BINS.low.exp2()).log2();
        for (mean, wanted) in [("Log", log), ("Linear", linear)] {
            let nodes = format!(
                "\"mean\": MeanLuminance(source: \"scene\", mean: {mean}), \"auto\": Adapt(mean: \"mean\"), \
                 \"result\": ShowValue(value: \"auto\")"
            );
            let value = shown(&nodes, &scene).at(0, 0);
            assert!((f64::from(value[1]) - wanted).abs() < 1e-4, "{width}x{height} {mean}: {value:?} {wanted}");
            let stops = auto_exposure_stops(limit_mean(wanted, LIMITS[0], LIMITS[1]), 0.18, 0.0);
            assert!((f64::from(value[0]) - stops).abs() < 1e-4, "{value:?} {stops}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn adapt_holds_in_the_dark_and_snaps_after_a_cut() {
    let (dim, bright, black) = (gray(0.25), gray(16.0), gray(0.0));
    let graph = pipeline(
        "\"mean\": MeanLuminance(source: \"scene\"), \"auto\": Adapt(mean: \"mean\"), \"result\": ShowValue(value: \"auto\")",
    );
    let frames =
        [(&black, 0.1, true), (&dim, 0.1, false), (&bright, 0.25, false), (&black, 9.0, false), (&dim, 0.1, true)];
    let (of_dim, of_bright) = (0.18_f64.log2() + 2.0, 0.18_f64.log2() - 4.0);
    let followed = adapt_exponential(of_dim, Aim { before: of_dim, wanted: of_bright }, 0.25, 1.0, 3.0);
    for (value, wanted) in sequence(&graph, &frames).iter().zip([0.0, of_dim, followed, followed, of_dim]) {
        assert!((f64::from(value[0]) - wanted).abs() < 1e-4, "{value:?} {wanted}");
    }
}

/// A mean that an exposure adapts to, which is shown.
const MEAN: &str = "\"mean\": MeanLuminance(source: \"scene\"), \"auto\": Adapt(mean: \"mean\"), \
                    \"result\": ShowValue(value: \"auto\")";

/// The stops of pictures, so many of 1000 pixels of which are as dark as each number, while the others have a luminance
/// of 1.
fn stops_beside(graph: &Graph, darks: &[f32], count: u32) -> Vec<f32> {
    let of = |dark: f32| {
        Picture::new(50, 20, |x, y| {
            let light = if x * 20 + y < count { dark } else { 1.0 };
            [light, light, light, 1.0]
        })
    };
    let pictures: Vec<Picture> = darks.iter().map(|dark| of(*dark)).collect();
    let frames: Vec<(&Picture, f32, bool)> = pictures.iter().map(|picture| (picture, 0.1, true)).collect();
    sequence(graph, &frames).iter().map(|value| value[0]).collect()
}

/// The judge is continuity: the exposure of black is the limit of those of ever darker pictures.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn black_is_metered_as_what_is_nearly_black() {
    let way: Vec<f32> = (0..=512_u16).map(|i| (f32::from(i) / 64.0 - 20.0).exp2()).collect();
    for text in [&auto(""), &auto("low: 0.0, high: 1.0"), MEAN] {
        let graph = pipeline(text);
        for count in [100, 900, 990] {
            let near = stops_beside(&graph, &[0.0, 1e-30, 1e-12, 1e-9, 1e-7], count);
            for stops in &near {
                let off = (stops - near[0]).abs();
                assert!(off < 0.02, "{text}: {count} of 1000 pixels: {near:?}");
            }
            for pair in stops_beside(&graph, &way, count).windows(2) {
                let off = (pair[1] - pair[0]).abs();
                assert!(off < 0.5, "{text}: {count} of 1000 pixels: {off} stops for a 64th of a stop of the dark ones");
            }
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_exposure_without_a_meter_is_manual() {
    let nodes = "\"h\": Histogram(source: \"scene\"), \"auto\": AutoExposure(histogram: \"h\", when: \"metered\"), \
                 \"exposed\": Exposure(source: \"scene\", meter: \"auto\", stops: 2.0), \
                 \"result\": Purkinje(source: \"exposed\", meter: \"auto\", illuminance: 50.0)";
    let text = format!(
        "Pipeline(inputs: {{ \"scene\": Color }}, facts: {{ \"metered\": \"whether the exposure is automatic\" }}, \
         nodes: {{ {nodes} }}, outputs: {{ \"out\": \"result\" }})"
    );
    let graph = checked(&text, &NoFiles);
    let mut run = Run::new(&graph).exact();
    run.facts.set("metered", false);
    assert_eq!(run.frame(&[("scene", &gray(0.25))])[0].at(3, 3), [1.0, 1.0, 1.0, 1.0]);
}
