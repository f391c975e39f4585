//! Colors outside of Rec.709 from the host's image to the display, and the negative numbers of each color state.

use afterimage_graph::check::{CheckOptions, Graph, check};
use afterimage_graph::document::parse;

use crate::reference::color::{P3_D65, REC709, REC2020, Space, conversion, luminance, to_xyz};
use crate::reference::image::rgb;
use crate::reference::math::{Rgb, dot, largest, transform};
use crate::reference::sanitize::{MAX_HALF, sanitize, sanitize_scene};
use crate::reference::transfer::{pq_encode, srgb_encode};
use crate::support::gpu::{Picture, Repository, Run, pipelines, registry, run_exact};
use crate::support::harness::Nodes;

/// The green of Rec.2020 in the basis of Rec.709.
fn rec2020_green() -> Rgb {
    transform(&conversion(&REC2020, &REC709), [0.0, 1.0, 0.0])
}

fn pixel(rgb: Rgb) -> Picture {
    let [r, g, b] = rgb.map(|x| x as f32);
    Picture::new(1, 1, |_, _| [r, g, b, 1.0])
}

/// The result of nodes on one exposed color, in 32 bits.
fn shown(nodes: &str, color: Rgb) -> Rgb {
    rgb(Nodes::new(nodes, &[("scene", "Exposed")]).exact(&[&pixel(color)]).at(0, 0).map(f64::from))
}

fn assert_near(what: &str, found: Rgb, wanted: Rgb, tolerance: f64) {
    let off = (0..3).map(|c| (found[c] - wanted[c]).abs()).fold(0.0, f64::max);
    assert!(off <= tolerance, "{what}: {found:?} instead of {wanted:?}");
}

/// Numbers of host images that are not plain.
const ODD: [[f32; 4]; 9] = [
    [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::NAN],
    [-1.0, -2.0, -3.0, -1.0],
    [-0.5, 1.0, -0.1, 1.0],
    [1.0, -7.0, 2.0, 1.0],
    [-4.32, -4.32, -4.32, 1.0],
    [65504.0, -65504.0, 65504.0, 1.0],
    [1e9, -1e9, 0.5, 2.0],
    [-0.0, 0.0, 1e-30, 0.5],
    [f32::MAX, f32::MIN, f32::MIN, f32::INFINITY],
];

fn limited(pixel: [f64; 4]) -> [f64; 4] {
    pixel.map(|x| if x.is_nan() { 0.0 } else { x.clamp(-MAX_HALF, MAX_HALF) })
}

/// A type of input, a node that changes nothing, and the value of a pixel after the first read.
type Sanitized = (&'static str, &'static str, fn([f64; 4]) -> [f64; 4]);

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_state_says_which_negative_numbers_stay() {
    let blur = r#""result": Gaussian(source: "scene", sigma: 0.2)"#;
    let table = r#""result": ColorLut(source: "scene")"#;
    let cases: [Sanitized; 7] = [
        ("Color", blur, sanitize_scene),
        ("Exposed", blur, sanitize_scene),
        ("LogLuminance", blur, limited),
        ("Data", blur, limited),
        ("Normals", blur, limited),
        ("DisplayLinear", blur, |pixel| pixel.map(|x| sanitize(x, MAX_HALF))),
        ("Encoded", table, |pixel| pixel.map(|x| sanitize(x, MAX_HALF))),
    ];
    for (state, node, wanted) in cases {
        for pixel in ODD {
            let picture = Picture::new(1, 1, |_, _| pixel);
            let found = Nodes::new(node, &[("scene", state)]).exact(&[&picture]).at(0, 0).map(f64::from);
            let wanted = wanted(pixel.map(f64::from));
            let close = (0..4).all(|c| (found[c] - wanted[c]).abs() <= 1e-6 * wanted[c].abs());
            assert!(close, "{state}: {pixel:?} becomes {found:?} and not {wanted:?}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn logarithms_of_the_host_keep_their_sign() {
    let nodes =
        r#""result": LocalToneMap(source: "scene", gaussian: "logs", contrast: 0.5, detail: 1.0, midpoint: -2.0)"#;
    let nodes = Nodes::new(nodes, &[("scene", "Exposed"), ("logs", "LogLuminance")]);
    for level in [0.05_f64, 0.18, 1.0, 8.0] {
        let found = nodes.exact(&[&pixel([level; 3]), &pixel([level.log2(); 3])]).at(0, 0);
        // The base is the level itself, so the result is 2^(midpoint + contrast * (base - midpoint)).
        let wanted = (-2.0 + 0.5 * (level.log2() + 2.0)).exp2();
        assert_near(&format!("{level}"), rgb(found.map(f64::from)), [wanted; 3], 1e-5 * wanted);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_green_of_rec2020_comes_through_to_its_display() {
    let nodes = |curve: &str, encode: &str| {
        format!(
            r#""mapped": ToneMap(source: "scene", curve: {curve}, space: Rec2020, gamut: Clip, keep_hue: 0.0, middle_gray: Native),
            "graded": LiftGammaGain(source: "mapped", gain: (1.0, 0.9, 1.0)),
            "result": Encode(source: "graded", transfer: Linear{encode})"#
        )
    };
    let green = rec2020_green();
    let wide = shown(&nodes("None", ", primaries: Rec2020"), green);
    assert_near("Rec2020", wide, [0.0, 0.9, 0.0], 2e-6);
    let narrow = shown(&nodes("None", ""), green);
    assert_near("Rec709", narrow, [0.0, 0.9, 0.0], 2e-6);
    let p3 = shown(&nodes("None", ", primaries: DisplayP3"), green);
    let clipped = transform(&conversion(&REC709, &P3_D65), green).map(|x| x.clamp(0.0, 1.0));
    assert_near("DisplayP3", p3, [clipped[0], 0.9 * clipped[1], clipped[2]], 2e-6);
    // The same numbers are different colors: the wide green has the luminance of Rec.2020's.
    let weights = |space: &Space| to_xyz(space)[1];
    assert!((dot(weights(&REC2020), wide) - 0.9 * 0.677998).abs() < 1e-5);
    let reinhard = shown(&nodes("Reinhard", ", primaries: Rec2020"), green.map(|x| 3.0 * x));
    assert_near("Reinhard", reinhard, [0.0, 0.9 * 0.75, 0.0], 2e-6);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_gamut_of_the_display_is_compressed_into_and_not_that_of_rec709() {
    let nodes = |encode: &str| {
        format!(
            r#""mapped": ToneMap(source: "scene", curve: None, space: Rec2020, gamut: Compress),
            "result": Encode(source: "mapped", transfer: Linear{encode})"#
        )
    };
    let green = rec2020_green().map(|x| 0.5 * x);
    let (wide, narrow) = (shown(&nodes(", primaries: Rec2020"), green), shown(&nodes(""), green));
    let in_rec709 = transform(&conversion(&REC2020, &REC709), wide);
    assert!(in_rec709[0] < -0.15, "the wide result is outside of Rec.709: {in_rec709:?}");
    assert!(narrow.iter().all(|x| (0.0..=1.0).contains(x)) && narrow[1] > 0.3, "{narrow:?}");
    // A color deep inside of Rec.709 is the same light for both displays.
    let gray = [0.3, 0.32, 0.28];
    let (wide, narrow) = (shown(&nodes(", primaries: Rec2020"), gray), shown(&nodes(""), gray));
    assert_near("inside", transform(&conversion(&REC2020, &REC709), wide), narrow, 2e-4);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn one_curve_for_two_displays_is_fitted_by_the_narrower_encoding() {
    let text = |gamut: &str| {
        format!(
            r#"Pipeline(inputs: {{ "scene": Exposed }}, outputs: {{ "narrow": "narrow", "wide": "wide" }}, nodes: {{
            "mapped": ToneMap(source: "scene", curve: None, space: Rec2020, gamut: Clip, keep_hue: 0.0, middle_gray: Native),
            "narrow": Encode(source: "mapped", transfer: Linear, gamut: {gamut}),
            "wide": Encode(source: "mapped", transfer: Linear, primaries: Rec2020) }})"#
        )
    };
    let green = rec2020_green().map(|x| 0.5 * x);
    for gamut in ["Clip", "Compress"] {
        let outputs = run_exact(&text(gamut), &[("scene", &pixel(green))]);
        let [narrow, wide] = [0, 1].map(|output| rgb(outputs[output].at(0, 0).map(f64::from)));
        assert_near("wide", wide, [0.0, 0.5, 0.0], 2e-6);
        let wanted = if gamut == "Clip" { green.map(|x| x.max(0.0)) } else { compressed(green) };
        assert_near(gamut, narrow, wanted, 5e-6);
    }
}

/// A color of Rec.709 toward the gray of its luminance until no channel is negative, with the knee of `Encode`, and then
/// darker until no channel is above 1.
fn compressed(color: Rgb) -> Rgb {
    let (gray, knee) = (luminance(color), 0.8);
    let reach = color.map(|x| (gray - x) / gray).into_iter().fold(0.0, f64::max);
    let over = (reach - knee).max(0.0);
    let share = if over > 0.0 { (knee + over * (1.0 - knee) / (1.0 - knee + over)) / reach } else { 1.0 };
    let inside = color.map(|x| gray + share * (x - gray));
    inside.map(|x| x / largest(inside).max(1.0))
}

/// A gradient of bright yellow has no step in the encoding for a narrower display.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn bright_yellow_has_no_contour_in_a_narrower_display() {
    let text = r#"Pipeline(inputs: { "scene": Exposed }, outputs: { "narrow": "narrow", "wide": "wide" }, nodes: {
        "mapped": ToneMap(source: "scene", curve: None, space: Rec2020, gamut: Clip, keep_hue: 0.0, middle_gray: Native),
        "narrow": Encode(source: "mapped"),
        "wide": Encode(source: "mapped", primaries: Rec2020) })"#;
    let to_rec709 = conversion(&REC2020, &REC709);
    let gradient = Picture::new(257, 1, |x, _| {
        let share = f64::from(x) / 256.0;
        let [r, g, b] = transform(&to_rec709, [0.9 + 0.1 * share, 0.98, 0.05 * share]).map(|x| x as f32);
        [r, g, b, 1.0]
    });
    let shown = &run_exact(text, &[("scene", &gradient)])[0];
    let codes: Vec<Rgb> = shown.pixels.iter().map(|pixel| rgb(pixel.map(|x| 255.0 * f64::from(x)))).collect();
    let step = |pair: &[Rgb]| (0..3).map(|c| (pair[0][c] - pair[1][c]).abs()).fold(0.0, f64::max);
    let most = codes.windows(2).map(step).fold(0.0, f64::max);
    assert!(most < 2.0, "a step of {most} codes");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn grades_after_the_curve_use_the_luminance_of_the_display() {
    for (name, space) in [("Rec709", REC709), ("DisplayP3", P3_D65), ("Rec2020", REC2020)] {
        let nodes = |grade: &str| {
            format!(
                r#""mapped": ToneMap(source: "scene", curve: None, gamut: Clip, keep_hue: 0.0, space: Rec2020),
                "graded": {grade},
                "result": Encode(source: "graded", transfer: Linear, primaries: {name})"#
            )
        };
        // A color inside of all three.
        let color = [0.7, 0.3, 0.2];
        let gray = [dot(to_xyz(&space)[1], transform(&conversion(&REC709, &space), color)); 3];
        let tolerance = if name == "Rec709" { 5e-5 } else { 1e-5 };
        assert_near(name, shown(&nodes(r#"Saturation(source: "mapped", amount: 0.0)"#), color), gray, tolerance);
        assert_near(name, shown(&nodes(r#"Cdl(source: "mapped", saturation: 0.0)"#), color), gray, tolerance);
        let lifted = shown(&nodes(r#"LiftGammaGain(source: "mapped", lift: (0.2, 0.2, 0.2))"#), color);
        let inside = transform(&conversion(&REC709, &space), color);
        assert_near(name, lifted, inside.map(|x| x + 0.2 * (1.0 - gray[0])), tolerance);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn nodes_before_the_curve_keep_colors_outside_of_rec709() {
    let green = rec2020_green().map(|x| 0.5 * x);
    let chain = r#""a": Gaussian(source: "scene", sigma: 2.0),
        "b": Saturation(source: "a", amount: 1.1),
        "c": WhiteBalance(source: "b", mode: Temperature, temperature: 6500.0),
        "mips": Downsample(source: "c", levels: 2, border: Edge),
        "bloom": Upsample(source: "mips", border: Edge),
        "result": Composite(base: "c", bloom: "bloom", strength: 0.5)"#;
    let y = luminance(green);
    let wanted = green.map(|x| 1.5 * (y + 1.1 * (x - y)));
    assert!(wanted[0] < -0.4, "{wanted:?}");
    let picture = Picture::new(16, 16, |_, _| [green[0] as f32, green[1] as f32, green[2] as f32, 1.0]);
    let found = Nodes::new(chain, &[("scene", "Exposed")]).exact(&[&picture]).at(8, 8);
    assert_near("chain", rgb(found.map(f64::from)), wanted, 1e-5);
    let night = r#""result": Purkinje(source: "scene", illuminance: 0.01)"#;
    let seen = shown(night, green);
    assert!(seen[0] < 0.0 && luminance(seen) > 0.0, "{seen:?}");
}

/// Large pictures are made several pixels at a time, as if no light became less than 0, and again where that was wrong;
/// small ones a pixel at a time. In every third pixel of the picture light is below 0, in others it becomes so by the
/// nodes, is too bright, or no number.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn light_that_is_tried_is_as_light_that_is_not() {
    let color = |x: u32, y: u32| {
        let share = ((7 * x + 13 * y) % 29) as f32 / 29.0;
        match (x / 3 + y / 40) % 6 {
            0 => [-0.2 * share, 0.7, 0.4, 1.0],
            1 => [8.0 * share, 0.02, 0.001, 1.0],
            2 if x.is_multiple_of(31) => [f32::NAN, 1.0, 0.5, 1.0],
            3 if x.is_multiple_of(17) => [1e6, 0.2, -1e6, 1.0],
            _ => [share, 0.5 * share, 0.9, 1.0],
        }
    };
    let [large, small] = [[1024, 1024], [256, 64]].map(|[width, height]| Picture::new(width, height, color));
    let nodes = r#""a": Exposure(source: "scene", stops: 1.0),
        "b": WhiteBalance(source: "a", mode: Temperature, temperature: 3200.0),
        "result": ToneMap(source: "b", curve: AgX, bake: 33)"#;
    let graph = Nodes::new(nodes, &[("scene", "Color")]).graph();
    let shown = [&large, &small].map(|picture| Run::new(&graph).shown(&[picture]).remove(0));
    // What is repaired by its neighbors has others at the border of the small picture.
    for (x, y) in (1..63).flat_map(|y| (1..255).map(move |x| (x, y))) {
        assert_eq!(shown[0].at(x, y), shown[1].at(x, y), "{x}, {y}: {:?}", color(x, y));
    }
}

/// `hdr.ron` with changes, so that its values are those of simple formulas.
fn hdr(sets: &[(&str, &str)]) -> Graph {
    let path = pipelines().join("hdr.ron");
    let text = std::fs::read_to_string(&path).expect("the pipeline is there");
    let document = parse(&path.to_string_lossy(), &text).unwrap_or_else(|errors| panic!("{errors:?}"));
    let sets = sets.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let options = CheckOptions { tier: None, sets, loader: &Repository };
    check(&document, &registry(), &options).unwrap_or_else(|errors| panic!("{errors}")).0
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn both_outputs_of_the_hdr_pipeline_are_their_reference() {
    let graph = hdr(&[
        ("meter", "Off"),
        ("lit", "Off"),
        ("sdr", "Off"),
        ("sdr-mapped", "Off"),
        ("sdr-encoded.gamut", "Clip"),
        ("hdr-mapped.keep_hue", "0.0"),
        ("hdr-mapped.curve", "None"),
        ("hdr-mapped.space", "Rec2020"),
        ("hdr-mapped.gamut", "Clip"),
    ]);
    let to_wide = conversion(&REC709, &REC2020);
    let colors =
        [[0.18; 3], [0.0; 3], [1.0; 3], [3.0, 2.0, 1.0], [0.9, 0.1, 0.05], [65504.0; 3], rec2020_green(), [-1.0; 3]];
    for color in colors {
        let outputs = Run::new(&graph).exact().frame(&[("scene", &pixel(color))]);
        let [sdr, hdr] = [0, 1].map(|output| rgb(outputs[output].at(0, 0).map(f64::from)));
        // A color has no negative luminance.
        let light = if luminance(color) < 0.0 { [0.0; 3] } else { color };
        let peak = 1000.0 / 203.0;
        let mapped = transform(&to_wide, light).map(|x| x.clamp(0.0, peak));
        assert_near("hdr", hdr, mapped.map(|x| pq_encode(203.0 * x)), 2e-5);
        let narrow = transform(&conversion(&REC2020, &REC709), mapped);
        assert_near("sdr", sdr, narrow.map(|x| srgb_encode(x.clamp(0.0, 1.0))), 1e-5);
    }
}

/// Gray and colored light of the HDR pipeline without its meter and its bloom: the codes of both displays.
fn displays(graph: &Graph, color: Rgb) -> [Rgb; 2] {
    let outputs = Run::new(graph).exact().frame(&[("scene", &pixel(color))]);
    [0, 1].map(|output| rgb(outputs[output].at(0, 0).map(f64::from)))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_sdr_image_keeps_what_the_hdr_image_keeps_and_white_is_at_203_nits() {
    let graph = hdr(&[("meter", "Off"), ("lit", "Off"), ("sdr", "Off")]);
    // ITU-R BT.2408 has white at 58 % of PQ. The pipeline says why its gray is not at 38 %.
    let [gray, white] = [0.18, 1.0].map(|light| displays(&graph, [light; 3]));
    assert_near("white", white[1], [0.581; 3], 2e-3);
    assert_near("gray", gray[1], [pq_encode(0.18 * 203.0); 3], 1e-3);
    assert_near("gray in SDR", gray[0], [srgb_encode(0.18); 3], 2e-3);
    // A third of a stop from one light to the next.
    for color in [[1.0; 3], [1.0, 0.8, 0.6], [0.7, 0.9, 1.0]] {
        let lights: Vec<[Rgb; 2]> =
            (-9..=12).map(|step| displays(&graph, color.map(|x| x * (f64::from(step) / 3.0).exp2()))).collect();
        for pair in lights.windows(2) {
            let rise = |display: usize| pair[1][display][1] - pair[0][display][1];
            // Up to 600 cd/m2, three times SDR white: what is brighter is within two codes of white.
            let is_kept = pair[1][1][1] < pq_encode(600.0);
            assert!(!is_kept || rise(0) > 1.0 / 255.0, "{color:?}: {pair:?}");
        }
    }
}
