//! The middle gray, the hues, the path to white and the gamut step of ToneMap.

use super::{Numbers, light, rgb, run, tolerance};
use crate::reference::color::{
    AP1, CAT16, D65, REC709, REC2020, Space, adaptation, conversion, from_xyz, luminance, xyz,
};
use crate::reference::curves::*;
use crate::reference::math::{Rgb, largest, transform};
use crate::reference::oklab::{chroma, fitted, hue, hue_of_light, oklab, with_hue};
use crate::reference::transfer::srgb_encode;
use crate::support::gpu::Picture;
use crate::support::harness::{Tolerance, assert_close, image};
use afterimage_graph::check::NoFiles;
use afterimage_nodes::Curve;

/// Cube roots, their cubes, and a share of the chroma that is found by halvings.
const OKLAB: Tolerance = tolerance(1e-4, 1e-4, "the border of the gamut is found to 6e-5 of the chroma");

/// The default curve per channel in ACEScg, matched to middle gray, of light that `enter` has brought into the range of
/// the curve.
fn default_curve(rgb: Rgb, enter: fn(Rgb) -> Rgb) -> Rgb {
    let curve = |x: f64| aces2_tone_scale(x, 100.0);
    let scale = matched_scale(curve);
    let light = transform(&conversion(&REC709, &AP1), rgb).map(|x| scale * x);
    transform(&conversion(&AP1, &REC709), enter(light).map(curve))
}

fn in_sdr(light: Rgb) -> Rgb {
    whitened(light, 1.0)
}

fn positive(light: Rgb) -> Rgb {
    light.map(|x| x.max(0.0))
}

/// Light whose hue and border are well conditioned: up to 2^6, in every saturation that Rec.709 has.
fn moderate([width, height]: [u32; 2]) -> Picture {
    let mut numbers = Numbers(0x51f1_3c7b_9e02_d4a5);
    super::picture([width, height], move |_| {
        let bright = (11.0 * numbers.next() - 5.0).exp2();
        [0, 1, 2].map(|_| bright * (0.02 + 0.98 * numbers.next()))
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_default_matches_its_reference() {
    super::compare("Exposed", "ToneMap()", moderate, OKLAB, |rgb| {
        fitted(with_hue(default_curve(rgb, in_sdr), rgb), 1.0, f64::from(0.8_f32))
    });
    super::compare("Exposed", "ToneMap(gamut: Clip)", moderate, OKLAB, |rgb| {
        display(with_hue(default_curve(rgb, positive), rgb))
    });
    super::compare("Exposed", "ToneMap(keep_hue: 0.0)", moderate, OKLAB, |rgb| {
        fitted(default_curve(rgb, in_sdr), 1.0, f64::from(0.8_f32))
    });
}

/// Display-linear values of exposed grays.
fn grays(node: &str, lights: &[f32]) -> Vec<f64> {
    let ramp =
        Picture::new(lights.len() as u32, 1, |x, _| [lights[x as usize], lights[x as usize], lights[x as usize], 1.0]);
    run("Exposed", node, &NoFiles, &ramp).pixels.iter().map(|pixel| f64::from(pixel[1])).collect()
}

/// The curves, and what they make of middle gray as published.
const NATIVE: [(&str, f64); 13] = [
    ("None", 0.18),
    ("Reinhard", 0.1525),
    ("ReinhardExtended", 0.1543),
    ("ReinhardLuminance", 0.1543),
    ("Exponential", 0.1647),
    ("Aces2ToneScale", 0.1000),
    ("AcesNarkowicz", 0.2669),
    ("AcesHill", 0.1056),
    ("Hable", 0.1283),
    ("Uchimura", 0.1790),
    ("KhronosNeutral", 0.1400),
    ("AgX", 0.2176),
    ("Gt7", 0.0580),
];

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_curve_shows_middle_gray_as_middle_gray() {
    assert_eq!(
        NATIVE.map(|(name, _)| name).as_slice(),
        Curve::ALL.iter().map(|curve| curve.name()).collect::<Vec<_>>()
    );
    for (curve, native) in NATIVE {
        for rest in ["", ", peak: 4.926", ", gamut: Clip, keep_hue: 0.0"] {
            let [gray] = grays(&format!("ToneMap(curve: {curve}{rest})"), &[0.18])[..] else { panic!("one pixel") };
            // The published matrices of AgX tint gray by 1e-4, and the hue of so little is a matter of rounding.
            let tolerance = if curve == "AgX" { 5e-5 } else { 2e-5 };
            assert!((gray - 0.18).abs() < tolerance, "{curve}{rest}: {gray}");
        }
        let [gray] = grays(&format!("ToneMap(curve: {curve}, middle_gray: Native)"), &[0.18])[..] else { panic!() };
        assert!((gray - native).abs() < 6e-5, "{curve}: {gray}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn parameters_of_a_curve_do_not_change_the_exposure() {
    let cases = [
        "ReinhardExtended, white_level: 1.0",
        "ReinhardLuminance, white_level: 16.0",
        "Exponential, exposure: 3.0",
        "Uchimura, contrast: 1.5, toe: 3.0",
        "Uchimura, linear_start: 0.05, pedestal: 0.02",
        "AgX, sigmoid: Polynomial",
    ];
    for case in cases {
        let [gray] = grays(&format!("ToneMap(curve: {case})"), &[0.18])[..] else { panic!("one pixel") };
        let allowed = if case.contains("Polynomial") { 3e-3 } else { 2e-5 };
        assert!((gray - 0.18).abs() < allowed, "{case}: {gray}");
    }
    let [white] = grays("ToneMap(curve: ReinhardExtended, white_level: 8.0)", &[8.0])[..] else { panic!("one pixel") };
    assert!((white - 1.0).abs() < 1e-5, "`white_level` is exposed light: {white}");
}

/// Lights that curves per channel turn.
const LIGHTS: [(&str, Rgb); 6] = [
    ("red", [1.0, 0.0, 0.0]),
    ("green", [0.0, 1.0, 0.0]),
    ("blue", [0.0, 0.0, 1.0]),
    ("orange", [1.0, 0.376, 0.0]),
    ("magenta", [1.0, 0.0, 1.0]),
    ("fire", [1.0, 0.25, 0.04]),
];

/// The results of a node for light from `low` stops up, in steps of an eighth.
fn exposures(node: &str, light: Rgb, low: f64, count: u32) -> Vec<Rgb> {
    let ramp = Picture::new(count, 1, |x, _| {
        let [r, g, b] = light.map(|channel| (channel * (0.125 * f64::from(x) + low).exp2()) as f32);
        [r, g, b, 1.0]
    });
    run("Exposed", node, &NoFiles, &ramp).pixels.iter().map(|pixel| rgb(*pixel)).collect()
}

/// The angle between two hues in degrees, 0 to 180.
fn angle(a: f64, b: f64) -> f64 {
    let turn = (a - b).rem_euclid(360.0);
    turn.min(360.0 - turn)
}

/// The largest turn of each light in degrees, from -2 to +6 stops, where the display's chroma is at least 0.08.
fn turns(node: &str, of_light: fn(Rgb) -> f64) -> [f64; 6] {
    LIGHTS.map(|(_, light)| {
        let shown = exposures(node, light, -2.0, 65).into_iter().filter(|shown| chroma(*shown) >= 0.08);
        shown.map(|shown| angle(hue(shown), of_light(light))).fold(0.0, f64::max)
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_defaults_keep_hues() {
    for curve in Curve::ALL {
        let found = turns(&format!("ToneMap(curve: {})", curve.name()), hue_of_light);
        assert!(found.iter().all(|turn| *turn <= 0.4), "{}: {found:?}", curve.name());
    }
    let found = turns("ToneMap(curve: Uchimura, space: Tsushima)", hue_of_light);
    assert!(found.iter().all(|turn| *turn <= 0.4), "Tsushima: {found:?}");
    let from_oklab = LIGHTS.map(|(_, light)| angle(hue(light), hue_of_light(light)));
    assert!(from_oklab.iter().all(|turn| *turn <= 6.8), "{from_oklab:?}");
}

/// Red, yellow, green, cyan, blue and magenta of a space, in linear Rec.709.
fn corners(space: &Space) -> [Rgb; 6] {
    let corners =
        [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    corners.map(|corner| transform(&conversion(space, &REC709), corner))
}

/// Over 18 stops, brighter light is no darker, loses chroma from some brightness on, and becomes white.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_light_becomes_white() {
    for curve in Curve::ALL.iter().map(|curve| curve.name()) {
        for peak in [1.0, 4.926] {
            // Curves without a `peak` end at 1.
            let node = format!("ToneMap(curve: {curve}, peak: {peak:?})");
            let top = exposures(&node, [1.0; 3], 12.0, 1)[0][1];
            for light in [REC709, REC2020, AP1].iter().flat_map(corners) {
                let shown = exposures(&node, light, -6.0, 145);
                let darker = shown.windows(2).map(|pair| luminance(pair[0]) - luminance(pair[1])).fold(0.0, f64::max);
                assert!(darker < 2e-5 * top, "{node} of {light:?}: darker by {darker}");
                let colorful = shown.iter().map(|shown| chroma(*shown)).fold(0.0, f64::max);
                let from = shown.iter().position(|shown| chroma(*shown) == colorful).expect("a largest chroma");
                let gained = shown[from..].windows(2).map(|pair| chroma(pair[1]) - chroma(pair[0])).fold(0.0, f64::max);
                assert!(gained < 2e-4, "{node} of {light:?}: chroma grows by {gained}");
                let white = shown.last().expect("colors");
                let least = white[0].min(white[1]).min(white[2]);
                assert!(least > 0.95 * top, "{node} of {light:?}: {white:?} of {top}");
            }
        }
    }
}

/// From the blue of Rec.709 to that of AP1, colors change without a step, although the gamut of Rec.709 has a dent there.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn deep_blue_has_no_contour() {
    let [.., deep, _] = corners(&AP1);
    let ramp = Picture::new(201, 1, |x, _| {
        let share = f64::from(x) / 200.0;
        let [r, g, b] = [0, 1, 2].map(|c| ((1.0 - share) * [0.0, 0.0, 1.0][c] + share * deep[c]) as f32);
        [r, g, b, 1.0]
    });
    let shown = run("Exposed", "ToneMap()", &NoFiles, &ramp);
    let colors: Vec<Rgb> = shown.pixels.iter().map(|pixel| oklab(rgb(*pixel))).collect();
    let step = |pair: &[Rgb]| largest([0, 1, 2].map(|c| (pair[0][c] - pair[1][c]).abs()));
    let most = colors.windows(2).map(step).fold(0.0, f64::max);
    assert!(most < 1e-3, "a step of {most}");
}

/// Near the blue of a display, where its gamut has a dent, a small change of light is a small change of codes: a step
/// here is a sixth of a cell of a table with 64 levels.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn blues_have_no_contour() {
    for node in ["ToneMap()", "ToneMap(curve: AcesNarkowicz)", "ToneMap(curve: KhronosNeutral)"] {
        for light in [0.05, 0.12, 0.25, 0.5] {
            let plane = Picture::new(160, 240, |x, y| {
                let [red, green] = [x, y].map(|at| light * (at as f32 / 480.0).powi(2));
                [red, green, light, 1.0]
            });
            let shown = run("Exposed", node, &NoFiles, &plane);
            let codes: Vec<Rgb> =
                shown.pixels.iter().map(|pixel| rgb(*pixel).map(|x| 255.0 * srgb_encode(x))).collect();
            let step = |from: Rgb, to: Rgb| largest([0, 1, 2].map(|c| (from[c] - to[c]).abs()));
            let across = codes.chunks(160).flat_map(|row| row.windows(2)).map(|pair| step(pair[0], pair[1]));
            let down = codes.iter().zip(&codes[160..]).map(|(from, to)| step(*from, *to));
            let most = across.chain(down).fold(0.0, f64::max);
            assert!(most < 2.0, "{node} at {light}: {most} codes");
        }
    }
}

/// Light of wide gamuts a thousandth apart is at most as many codes apart as sRGB makes of a thousandth near black.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn neighbors_in_light_are_neighbors_in_codes() {
    const STEP: f64 = 1e-3;
    let most = 255.0 * srgb_encode(STEP) + 0.05;
    for space in [&REC2020, &AP1] {
        let to_rec709 = conversion(space, &REC709);
        for node in ["ToneMap()", "ToneMap(curve: None)", "ToneMap(curve: Uchimura)"] {
            // From cyan to magenta, across the dent of Rec.709's gamut.
            let ring = |row: u32, turn: f64| {
                let bright = f64::from(row).mul_add(0.5, -4.0).exp2();
                transform(&to_rec709, [(turn - 1.0).max(0.0), (1.0 - turn).max(0.0), 1.0].map(|x| bright * x))
            };
            // Three rows for each brightness: light, a neighbor in hue and one toward gray.
            let colors = Picture::new(1601, 30, |x, y| {
                let turn = 0.5 + f64::from(x) / 1600.0;
                let light = ring(y / 3, turn);
                let way = match y % 3 {
                    0 => [0.0; 3],
                    1 => std::array::from_fn(|c| ring(y / 3, turn + 1e-5)[c] - light[c]),
                    _ => light.map(|x| largest(light) - x),
                };
                let step = STEP * largest(light) / largest(way.map(f64::abs)).max(1e-30);
                let [r, g, b] = [0, 1, 2].map(|c| (light[c] + step * way[c]) as f32);
                [r, g, b, 1.0]
            });
            let shown = run("Exposed", node, &NoFiles, &colors);
            let codes: Vec<Rgb> =
                shown.pixels.iter().map(|pixel| rgb(*pixel).map(|x| 255.0 * srgb_encode(x))).collect();
            let rows: Vec<&[Rgb]> = codes.chunks(1601).collect();
            for (number, rows) in rows.chunks(3).enumerate() {
                for (x, light) in rows[0].iter().enumerate() {
                    let off = |beside: Rgb| largest([0, 1, 2].map(|c| (beside[c] - light[c]).abs()));
                    let off = off(rows[1][x]).max(off(rows[2][x]));
                    assert!(off <= most, "{node}: {off} codes at {x} of brightness {number}");
                }
            }
        }
    }
}

/// Colors of constant hue for observers, in linear Rec.709: at a quarter, a half, three quarters and all of the chroma.
fn measured_hues() -> Vec<(&'static str, Vec<Rgb>)> {
    let adapt = adaptation(&CAT16, xyz([0.3101, 0.3163]), xyz(D65));
    let rgb_from_xyz = from_xyz(&REC709);
    let lines = include_str!("../../vectors/hung_berns.txt").lines().filter(|line| !line.starts_with('#'));
    lines
        .map(|line| {
            let (name, numbers) = line.split_once(' ').expect("a name");
            let numbers: Vec<f64> = numbers.split_whitespace().map(|number| number.parse().unwrap()).collect();
            let color = |v: &[f64]| transform(&rgb_from_xyz, transform(&adapt, [v[0], v[1], v[2]].map(|x| x / 100.0)));
            (name, numbers.chunks(3).map(color).collect())
        })
        .collect()
}

/// On their way to white, the saturated colors of the experiment pass the colors that observers found of equal hue.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn hues_follow_those_that_observers_found() {
    let mut errors = Vec::new();
    for (name, colors) in measured_hues() {
        let [colors @ .., light] = &colors[..] else { panic!("{name}") };
        let way = exposures("ToneMap()", *light, -2.0, 97);
        let nearest = |color: &Rgb| {
            let off = |shown: &Rgb| (chroma(*shown) - chroma(*color)).abs();
            *way.iter().min_by(|a, b| off(a).total_cmp(&off(b))).expect("colors")
        };
        errors.extend(colors.iter().map(|color| (angle(hue(nearest(color)), hue(*color)), name)));
    }
    let mean = errors.iter().map(|(error, _)| error).sum::<f64>() / errors.len() as f64;
    let worst = errors.iter().max_by(|a, b| a.0.total_cmp(&b.0)).expect("colors");
    assert_eq!(errors.len(), 36);
    assert!(mean < 2.9 && worst.0 < 14.5, "mean {mean}, largest {worst:?}");
}

/// What the switches of the published operators do: the reason for the defaults.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn published_curves_turn_hues() {
    let published = "middle_gray: Native, keep_hue: 0.0, gamut: Clip";
    let [.., orange, _, fire] = turns(&format!("ToneMap(curve: AcesNarkowicz, space: Rec709, {published})"), hue);
    assert!(orange > 25.0 && fire > 45.0, "orange turns by {orange}, fire by {fire}");
    let [_, _, blue, ..] = turns(&format!("ToneMap(curve: Uchimura, space: Tsushima, {published})"), hue);
    assert!(blue > 40.0, "blue turns by {blue}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn compression_keeps_inner_colors_and_the_hue_of_outer_ones() {
    let size = [61, 37];
    // Colors around the middle of the range, up to twice as far from gray as the gamut goes.
    let mut numbers = Numbers(77);
    let input = Picture::new(size[0], size[1], |_, _| {
        let gray = 0.1 + 0.7 * numbers.next();
        let [r, g, b] = [0, 1, 2].map(|_| (gray * (0.3 + 1.6 * numbers.next())) as f32);
        [r, g, b, 1.0]
    });
    let output = run("Exposed", "ToneMap(curve: None, gamut_knee: 0.6)", &NoFiles, &input);
    let (mut inner, mut outer) = (0, 0);
    for (&from, &to) in input.pixels.iter().zip(&output.pixels) {
        let (from, to) = (rgb(from), rgb(to));
        if oklab(from)[0] > 0.99 {
            continue;
        }
        let moved = largest([0, 1, 2].map(|channel| (to[channel] - from[channel]).abs()));
        if moved < 1e-5 {
            inner += 1;
        } else {
            outer += 1;
            assert!(chroma(to) < chroma(from), "{from:?} became {to:?}");
            assert!(oklab(to)[0] > oklab(from)[0] - 1e-4, "{from:?} became {to:?}");
            assert!(chroma(to) < 0.02 || angle(hue(to), hue_of_light(from)) < 0.4, "{from:?} became {to:?}");
        }
    }
    assert!(inner > 200 && outer > 500, "{inner} inner and {outer} outer colors");
    let expected = image(&input).map_rgb(|rgb| fitted(with_hue(rgb, rgb), 1.0, f64::from(0.6_f32)));
    assert_close("None, compressed", &output, &expected, &OKLAB);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn light_of_any_kind_stays_in_range() {
    let lights = light([61, 37]);
    for rest in ["", "peak: 4.926", "gamut: Clip", "keep_hue: 0.5", "gamut_knee: 0.0", "gamut_knee: 1.0"] {
        let output = run("Exposed", &format!("ToneMap({rest})"), &NoFiles, &lights);
        let most = if rest.starts_with("peak") { 4.926 } else { 1.0 };
        assert!(output.pixels.iter().flat_map(|p| &p[..3]).all(|x| (0.0..=most).contains(x)), "{rest}");
        assert_eq!(rgb(output.at(1, 0)), [0.0; 3], "{rest}: black");
        assert!(largest(rgb(output.at(3, 0))) > 0.99 * f64::from(most), "{rest}: {:?}", output.at(3, 0));
    }
}
