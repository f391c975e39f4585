//! Color files: `ColorLut` with steps and conversions, and `Cdl` with a file, compared with the evaluation in double
//! precision, which `graph/color/tests/clf.rs` compares with known values.

use afterimage_color::lut::parse_correction;
use afterimage_color::parse_clf;
use afterimage_color::process::Process;
use afterimage_graph::check::NoFiles;

use super::lut::look;
use super::{OneFile, SIZES, Tolerance, compare_with, light, rgb, run, stored, tolerance, unit};
use crate::reference::lut::Cube;
use crate::reference::math::{Rgb, mix};
use crate::reference::transfer::srgb_encode;
use crate::support::harness::{Nodes, assert_close, image};

const STEPS: Tolerance = tolerance(4e-6, 2e-5, "powers and logarithms of several steps in f32");

fn list(nodes: &str) -> String {
    format!("<ProcessList id=\"test\" compCLFversion=\"3.0\">{nodes}</ProcessList>")
}

fn node(name: &str, attributes: &str, body: &str) -> String {
    format!("<{name} inBitDepth=\"32f\" outBitDepth=\"32f\" {attributes}>{body}</{name}>")
}

/// Compares a file of these process nodes with its evaluation in double precision.
fn assert_matches(nodes: &str, picture: fn([u32; 2]) -> crate::support::gpu::Picture, tolerance: Tolerance) {
    let text = list(nodes);
    let process = parse_clf(&text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let file = OneFile(text.into_bytes());
    compare_with("Exposed", "ColorLut(file: \"a.clf\")", &file, picture, tolerance, |rgb| stored(process.apply(rgb)));
}

/// The same for numbers from -1 to 1, which the first node makes of colors: images of light have no negative numbers.
fn assert_matches_signed(nodes: &str, tolerance: Tolerance) {
    let bounds =
        "<minInValue>0</minInValue><maxInValue>1</maxInValue><minOutValue>-1</minOutValue><maxOutValue>1</maxOutValue>";
    let signed = node("Range", "style=\"noClamp\"", bounds);
    assert_matches(&format!("{signed}{nodes}"), unit, tolerance);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn linear_steps_match() {
    let matrix = node("Matrix", "", "<Array dim=\"3 4\">1.2 -0.1 0.3 0.1  0 0.5 0 -0.1  0.25 0.25 2 0</Array>");
    assert_matches(&matrix, light, STEPS);
    let bounds = "<minInValue>0.1</minInValue><maxInValue>0.9</maxInValue>\
                  <minOutValue>-1</minOutValue><maxOutValue>3</maxOutValue>";
    assert_matches(&node("Range", "", bounds), unit, STEPS);
    assert_matches(&node("Range", "style=\"noClamp\"", bounds), light, STEPS);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn logarithms_match() {
    let camera = "<LogParams base=\"10\" logSideSlope=\"0.24719\" logSideOffset=\"0.385537\" linSideSlope=\"5.555556\" \
                  linSideOffset=\"0.052272\" linSideBreak=\"0.010591\"/>";
    for style in ["log10", "log2"] {
        assert_matches(&node("Log", &format!("style=\"{style}\""), ""), light, STEPS);
        assert_matches(
            &node("Log", &format!("style=\"anti{}{}\"", style[..1].to_uppercase(), &style[1..]), ""),
            unit,
            STEPS,
        );
    }
    assert_matches(&node("Log", "style=\"cameraLinToLog\"", camera), light, STEPS);
    assert_matches(&node("Log", "style=\"cameraLogToLin\"", camera), unit, STEPS);
    let plain = "<LogParams base=\"10\" logSideSlope=\"0.3\" logSideOffset=\"0.6\" linSideOffset=\"0.01\"/>";
    assert_matches(&node("Log", "style=\"linToLog\"", plain), light, STEPS);
    assert_matches(&node("Log", "style=\"logToLin\"", plain), unit, STEPS);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn exponents_match() {
    for (form, offset) in [
        ("basic", ""),
        ("basicMirror", ""),
        ("basicPassThru", ""),
        ("monCurve", "offset=\"0.055\""),
        ("monCurveMirror", "offset=\"0.055\""),
    ] {
        let channel = |name: &str, exponent: f64| {
            format!("<ExponentParams channel=\"{name}\" exponent=\"{exponent}\" {offset}/>")
        };
        let params = [channel("R", 2.4), channel("G", 1.0), channel("B", 3.0)].concat();
        for direction in ["Fwd", "Rev"] {
            assert_matches_signed(&node("Exponent", &format!("style=\"{form}{direction}\""), &params), STEPS);
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn color_decision_lists_match() {
    let sop = "<Slope>1.1 0.9 1.3</Slope><Offset>0.05 -0.1 0.02</Offset><Power>1.2 0.8 2.0</Power>";
    let body = format!("<SOPNode>{sop}</SOPNode><SatNode><Saturation>1.3</Saturation></SatNode>");
    for style in ["Fwd", "Rev", "FwdNoClamp", "RevNoClamp"] {
        assert_matches_signed(&node("ASC_CDL", &format!("style=\"{style}\""), &body), STEPS);
    }
    let text = include_str!("../../../graph/color/tests/files/warm.cc");
    let process = Process::from(parse_correction(text, "").expect("a correction"));
    let file = OneFile(text.as_bytes().to_vec());
    compare_with("Encoded", "Cdl(file: \"warm.cc\")", &file, unit, STEPS, |rgb| stored(process.apply(rgb)));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn tables_of_a_list_match() {
    let curve = |power: f64| (0..5000).map(move |i| (f64::from(i) / 4999.0).powf(power));
    let line = |(r, (g, b)): (f64, (f64, f64))| format!("{r:.9} {g:.9} {b:.9}\n");
    let rows: String = curve(0.5).zip(curve(1.0).zip(curve(2.0))).map(line).collect();
    let table = node("LUT1D", "", &format!("<Array dim=\"5000 3\">{rows}</Array>"));
    let steps = tolerance(2e-5, 2e-5, "the slope of a table near black, times the error of the steps before");
    // Two 1-D tables in one texture, then a 3-D table, with a step between.
    let entries = Cube::new(4, look).entries;
    let blue_fastest = (0..64).map(|i| entries[(i % 4 * 4 + i / 4 % 4) * 4 + i / 16]);
    let rows: String = blue_fastest.map(|[r, g, b]| format!("{r:.9} {g:.9} {b:.9}\n")).collect();
    for style in ["trilinear", "tetrahedral"] {
        let cube =
            node("LUT3D", &format!("interpolation=\"{style}\""), &format!("<Array dim=\"4 4 4 3\">{rows}</Array>"));
        let half = node("Matrix", "", "<Array dim=\"3 3\">0.5 0 0 0 0.5 0 0 0 0.5</Array>");
        assert_matches(&[&*table, &half, &table, &cube, &cube].concat(), unit, steps);
    }
    let half = |code: u32| f64::from(half::f16::from_bits(code as u16)).clamp(-65504.0, 65504.0);
    let roots = (0..65536).map(half).map(|x| if x.is_nan() { 0.0 } else { x.signum() * x.abs().sqrt() });
    let rows: String = roots.map(|x| format!("{x:e} ")).collect();
    let half = node("LUT1D", "halfDomain=\"true\"", &format!("<Array dim=\"65536 1\">{rows}</Array>"));
    assert_matches(&half, light, steps);
    assert_matches_signed(&half, steps);
}

/// sRGB to light.
fn srgb_decode(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_look_for_srgb_works_on_light_as_it_does_after_encoding() {
    let cube = Cube::new(7, look);
    let file = OneFile(cube.text().into_bytes());
    for strength in [1.0, 0.3] {
        let node = format!("ColorLut(file: \"look.cube\", from: Srgb, strength: {strength})");
        let detour = |rgb: Rgb| {
            let encoded = rgb.map(|x| srgb_encode(x.clamp(0.0, 1.0)));
            let looked = cube.tetrahedral(encoded);
            [0, 1, 2].map(|c| srgb_decode(mix(encoded[c], looked[c], strength).clamp(0.0, 1.0)))
        };
        let steps = tolerance(1e-5, 5e-5, "encoding, table and decoding in f32");
        compare_with("DisplayLinear", &node, &file, unit, steps, detour);
    }
}

/// Light above white, which the space of the table does not have, stays with the share that is not changed.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_weak_look_keeps_light_beyond_its_space() {
    let cube = Cube::new(7, look);
    let file = OneFile(cube.text().into_bytes());
    for strength in [0.5, 0.01] {
        let node = format!("ColorLut(file: \"look.cube\", from: Srgb, strength: {strength})");
        let mixed = |rgb: Rgb| {
            let inside = rgb.map(|x| x.clamp(0.0, 1.0));
            let encoded = inside.map(srgb_encode);
            let looked = cube.tetrahedral(encoded);
            [0, 1, 2].map(|c| {
                let graded = srgb_decode(mix(encoded[c], looked[c], strength).clamp(0.0, 1.0));
                (graded + (1.0 - strength) * (rgb[c] - inside[c])).max(0.0)
            })
        };
        let steps = tolerance(1e-5, 5e-5, "encoding, table and decoding in f32");
        compare_with("DisplayLinear", &node, &file, light, steps, mixed);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_display_transform_as_a_table_replaces_curve_and_encoding() {
    let text = include_str!("../../../graph/color/tests/files/display.clf");
    let file = OneFile(text.as_bytes().to_vec());
    let transform = parse_clf(text).expect("a process");
    let steps = tolerance(4e-5, 4e-5, "the steps of the file and the conversions in f32");
    let signal = |rgb: Rgb| transform.apply(acescct(rgb)).map(|x| x.clamp(0.0, 1.0));
    let node = |state: &str| format!("ColorLut(file: \"display.clf\", from: AcesCct, to: Srgb, state: {state})");
    compare_with("Exposed", &node("Encoded"), &file, light, steps, signal);
    compare_with("Exposed", &node("DisplayLinear"), &file, light, steps, |rgb| signal(rgb).map(srgb_decode));
}

/// Linear Rec.709 to ACEScct, by the matrix and the curve of the Academy.
fn acescct(rgb: Rgb) -> Rgb {
    const TO_AP1: [Rgb; 3] =
        [[0.6130974, 0.3395231, 0.0473795], [0.0701937, 0.9163539, 0.0134524], [0.0206156, 0.1095698, 0.8698147]];
    let ap1 = TO_AP1.map(|row| (0..3).map(|c| row[c] * rgb[c]).sum::<f64>());
    ap1.map(|x| if x <= 0.0078125 { 10.5402377416545 * x + 0.0729055341958355 } else { (x.log2() + 9.72) / 17.52 })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_space_leads_back_to_the_same_light() {
    // Linear and logarithmic spaces keep light of any range, those of displays light from 0 to 1.
    let identity = Cube::new(2, |rgb| rgb.map(|x| 40.0 * x - 20.0)).text();
    let wide = identity.replacen('\n', "\nDOMAIN_MIN -20 -20 -20\nDOMAIN_MAX 20 20 20\n", 1);
    let file = OneFile(wide.into_bytes());
    let steps = tolerance(2e-5, 2e-4, "a space and back in f32, through a table of -20 to 20");
    for space in ["LinearRec709", "LinearRec2020", "Aces", "AcesCg", "AcesCct", "LogC3"] {
        let node = format!("ColorLut(file: \"a.cube\", from: {space})");
        compare_with("Exposed", &node, &file, unit, steps, |rgb| rgb);
    }
    let steps = tolerance(3e-5, 2e-4, "a space and back in f32, through a table of -20 to 20");
    for space in ["Srgb", "DisplayP3", "Gamma22", "Gamma24", "Pq"] {
        let node = format!("ColorLut(file: \"a.cube\", from: {space})");
        compare_with("DisplayLinear", &node, &file, unit, steps, |rgb| rgb);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_node_without_a_file_changes_nothing_whatever_its_space() {
    let input = unit(SIZES[1]);
    let output = run("DisplayLinear", "ColorLut(from: Srgb)", &NoFiles, &input);
    assert!(input.pixels.iter().zip(&output.pixels).all(|(a, b)| rgb(*a) == rgb(*b)));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_encoded_image_is_decoded_by_its_own_colorimetry() {
    let half = node("Matrix", "", "<Array dim=\"3 3\">0.5 0 0 0 0.5 0 0 0 0.5</Array>");
    let file = OneFile(list(&half).into_bytes());
    let input = unit(SIZES[2]);
    let mut darker = input.clone();
    darker.pixels.iter_mut().for_each(|[r, g, b, _]| [r, g, b].into_iter().for_each(|x| *x *= 0.5));
    let steps = tolerance(2e-4, 1e-4, "the conversion to light and back in f32, where PQ is steep");
    for transfer in ["Srgb", "Gamma", "Linear", "Pq", "Hlg"] {
        let encode = format!("Encode(source: \"in\", transfer: {transfer}, primaries: Rec2020)");
        let run = |nodes: &str, picture| Nodes::new(nodes, &[("in", "DisplayLinear")]).files(&file).exact(&[picture]);
        let expected = run(&format!("\"result\": {encode}"), &darker);
        let looked = "ColorLut(source: \"encoded\", file: \"a.clf\", from: LinearRec709)";
        let found = run(&format!("\"encoded\": {encode}, \"result\": {looked}"), &input);
        assert_close(transfer, &found, &image(&expected), &steps);
    }
}
