//! Kinds without Rust: those of `nodes/folders` and, with several passes, of `tests/folders`, compared with CPU references
//! and by what they are defined to do.

/// Blurs along lines, around a point, and of a width that differs.
mod blurs;
mod grading;
mod indirect;
mod lens;
/// Masks, and what is limited to them.
mod masks;
/// Strokes of paint and dots of ink.
mod painting;
mod reflections;
mod scale;
/// Kinds that read other pixels.
mod space;

use std::path::Path;

use afterimage_graph::check::{CheckOptions, Graph, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::Size;
use afterimage_graph::node::{NodeKind, Registry, folder_kind_of, folder_kind_sharing};

use crate::reference::gaussian;
use crate::reference::image::Image;
use crate::support::gpu::{Picture, Run};
use crate::support::probes;

/// The kinds of `nodes/folders` that tests here hold.
pub const TESTED: [&str; 35] = [
    "ChannelMixer",
    "ColorKey",
    "Crt",
    "Curves",
    "Denoise",
    "DirectionalBlur",
    "Fsr1",
    "Glitch",
    "GodRays",
    "GradientMap",
    "GradientMask",
    "HueCurves",
    "Kuwahara",
    "LensProfile",
    "Letterbox",
    "LogWheels",
    "LumaKey",
    "Mix",
    "Newsprint",
    "OrderedDither",
    "Over",
    "Palette",
    "Pixelate",
    "PolygonMask",
    "Premultiply",
    "RadialBlur",
    "Rcas",
    "SaturationCurves",
    "ShapeMask",
    "SplitToning",
    "Ssgi",
    "Ssr",
    "Transform",
    "Unpremultiply",
    "VariableBlur",
];

fn kind(name: &str) -> NodeKind {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("folders");
    let text = |path: &str| {
        let path = folder.join(path);
        std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    };
    let file = format!("{name}/{name}.wgsl");
    let (declaration, shader, gauss) = (text(&format!("{name}/node.ron")), text(&file), text("lib/gauss.wgsl"));
    folder_kind_sharing(("node.ron", &declaration), &[(&file, &shader)], &[("lib/gauss.wgsl", &gauss)])
        .unwrap_or_else(|errors| panic!("{errors}"))
}

fn kinds() -> [NodeKind; 2] {
    ["soft_blur", "haze"].map(kind)
}

fn graph(nodes: &str, outputs: &str) -> Graph {
    let registry = Registry::new(&[afterimage_nodes::ALL, &kinds()]).expect("no two kinds share a name");
    graph_of(&registry, nodes, outputs)
}

fn graph_of(registry: &Registry, nodes: &str, outputs: &str) -> Graph {
    let text = format!("Pipeline(inputs: {{ \"in\": Color }}, nodes: {{ {nodes} }}, outputs: {{ {outputs} }})");
    let document = parse("test.ron", &text).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
    check(&document, registry, &options).unwrap_or_else(|errors| panic!("{errors:?}")).0
}

fn scene(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let spark = if (x * 7 + y * 3) % 23 == 0 { 40.0 } else { 0.0 };
        [x as f32 * 0.11 + spark, (y as f32 * 0.7).sin().abs(), (x * y) as f32 * 0.01, 1.0]
    })
}

fn image(picture: &Picture) -> Image {
    Image::new(picture.width as usize, picture.height as usize, |x, y| picture.at(x as u32, y as u32).map(f64::from))
}

/// The largest difference of a channel, in parts of the largest number of the reference.
fn error(picture: &Picture, wanted: &Image) -> f64 {
    assert_eq!((picture.width as usize, picture.height as usize), (wanted.width, wanted.height));
    let largest = wanted.pixels.iter().flatten().fold(0.0_f64, |most, number| most.max(number.abs()));
    let pairs = picture.pixels.iter().flatten().zip(wanted.pixels.iter().flatten());
    pairs.fold(0.0_f64, |most, (got, wanted)| most.max((f64::from(*got) - wanted).abs())) / largest
}

const SIZES: [(u32, u32); 4] = [(33, 17), (64, 36), (5, 70), (1, 1)];

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_separable_blur_without_rust_is_a_gaussian() {
    let both = r#""soft": SoftBlur(source: "in", sigma: 2.5), "gauss": Gaussian(source: "in", sigma: 2.5)"#;
    let graph = graph(both, r#""soft": "soft", "gauss": "gauss""#);
    for (width, height) in SIZES {
        let scene = scene(width, height);
        let [soft, gauss] = &Run::new(&graph).exact().frame(&[("in", &scene)])[..] else { panic!("two outputs") };
        let wanted = gaussian::blur(&image(&scene), 2.5);
        assert!(error(soft, &wanted) < 1e-6, "{width}x{height}: {}", error(soft, &wanted));
        assert!(error(soft, &image(gauss)) < 1e-6, "{width}x{height}: {}", error(soft, &image(gauss)));
    }
}

/// The haze, and what it makes of the image.
fn hazed(source: &Image, amount: f64, width: f64) -> Image {
    let full = Size::new(source.width as u32, source.height as u32);
    let (mut levels, mut size) = (Vec::<Image>::new(), full);
    for _ in 0..full.levels().clamp(1, 6) {
        size = size.half();
        let above = levels.last().unwrap_or(source);
        levels.push(Image::from_uv(size.width as usize, size.height as usize, |uv| above.tap(uv)));
    }
    let half = gaussian::taps(1.0, 3);
    let soft = |level: &Image| gaussian::blur_axis(&gaussian::blur_axis(level, &half, [1, 0]), &half, [0, 1]);
    let mix = |a: [f64; 4], b: [f64; 4], share: f64| std::array::from_fn(|i| a[i] + (b[i] - a[i]) * share);
    let coarsest = soft(levels.last().expect("there is a level"));
    let wide = levels.iter().rev().skip(1).fold(coarsest, |coarser, level| {
        let soft = soft(level);
        Image::from_uv(level.width, level.height, |uv| mix(soft.tap(uv), coarser.tap(uv), width))
    });
    Image::from_uv(source.width, source.height, |uv| {
        let (own, spread): ([f64; 4], [f64; 4]) = (source.tap(uv), wide.tap(uv));
        let [r, g, b, _] = mix(own, spread, amount);
        [r, g, b, own[3]]
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pyramid_without_rust_goes_down_and_up() {
    let graph = graph(r#""haze": Haze(source: "in", amount: 0.4, width: 0.7)"#, r#""out": "haze""#);
    for (width, height) in SIZES {
        let scene = scene(width, height);
        let out = Run::new(&graph).exact().frame(&[("in", &scene)]).remove(0);
        let wanted = hazed(&image(&scene), f64::from(0.4_f32), f64::from(0.7_f32));
        assert!(error(&out, &wanted) < 2e-5, "{width}x{height}: {}", error(&out, &wanted));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_glow_of_a_node_that_is_off_is_black_and_its_result_the_source() {
    let outputs = r#""out": "haze", "glow": "haze.glow""#;
    let scene = scene(20, 10);
    let on = Run::new(&graph(r#""haze": Haze(source: "in")"#, outputs)).exact().frame(&[("in", &scene)]);
    assert!(on[1].pixels.iter().any(|pixel| pixel[0] > 0.1), "there is no glow");
    let off = format!(r#"{outputs} }}, set: {{ "haze": Off"#);
    let off = Run::new(&graph(r#""haze": Haze(source: "in")"#, &off)).exact().frame(&[("in", &scene)]);
    assert_eq!(off[0].pixels, scene.pixels);
    assert!(off[1].pixels.iter().all(|pixel| pixel[..3] == [0.0; 3]), "{:?}", off[1].pixels[0]);
}

const COUNTS: &str = r#"Kind(
    name: "Counts",
    doc: "Shows the words of a histogram: four numbers, then counts.",
    inputs: { "histogram": Table(doc: "The histogram.", content: "histogram") },
    outputs: { "result": Image(doc: "A pixel for each word.", state: Data, size: Fixed(388, 1)) },
)"#;

/// As the probe of tables shows them.
const COUNTS_SHADER: &str = "import afterimage::table::{table_number, table_word};
fn counts(histogram: texture_2d<f32>, at: Point) -> vec4f {
    let index = u32(at.pixel.x);
    if index < 4u { return vec4f(table_number(histogram, index), 0.0, 0.0, 0.0); }
    let word = table_word(histogram, index);
    return vec4f(f32(word & 0xffffu), f32(word >> 16u), 0.0, 0.0);
}";

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_kind_without_rust_reads_each_word_of_a_table() {
    let kind = folder_kind_of(("node.ron", COUNTS), &[("counts.wgsl", COUNTS_SHADER)]);
    let kind = kind.unwrap_or_else(|errors| panic!("{errors}"));
    afterimage_plan::contract(std::slice::from_ref(&kind)).unwrap_or_else(|errors| panic!("{}", errors.join("\n")));
    let registry = Registry::new(&[afterimage_nodes::ALL, &[kind], probes::ALL]).expect("no two kinds share a name");
    let nodes = r#""all": Histogram(source: "in"), "own": Counts(histogram: "all"), "probe": ProbeTable(table: "all")"#;
    let graph = graph_of(&registry, nodes, r#""own": "own", "probe": "probe""#);
    let shown = Run::new(&graph).exact().frame(&[("in", &scene(64, 36))]);
    assert!(shown[0] == shown[1], "the words differ from those of the probe");
    let counted: f32 = shown[0].pixels[4..].iter().map(|pixel| pixel[0]).sum();
    assert!(counted > 100.0 && shown[0].pixels[..4].iter().any(|pixel| pixel[0] < 0.0), "{:?}", &shown[0].pixels[..8]);
}

/// The result of a kind for a picture after the tone curve, at the start of the first frame.
fn shown(node: &str, scene: &Picture) -> Picture {
    let registry = Registry::new(&[afterimage_nodes::ALL, &kinds()]).expect("no two kinds share a name");
    let text = format!(
        "Pipeline(inputs: {{ \"in\": DisplayLinear }}, nodes: {{ \"it\": {node} }}, outputs: {{ \"out\": \"it\" }})"
    );
    let document = parse("test.ron", &text).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
    let graph = check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors:?}")).0;
    Run::new(&graph).exact().frame(&[("in", scene)]).remove(0)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_large_pixel_is_the_mean_of_the_light_under_it() {
    for (width, height) in SIZES {
        let scene = scene(width, height);
        let source = image(&scene);
        let wanted = Image::new(source.width, source.height, |x, y| {
            let side = |at: usize, end: usize| {
                let first = (at / 4 * 4) as f64;
                [first, (first + 4.0).min(end as f64)]
            };
            let ([left, right], [top, bottom]) = (side(x, source.width), side(y, source.height));
            let mut sum = [0.0; 4];
            for (i, j) in (0..64).map(|k| (f64::from(k % 8) + 0.5, f64::from(k / 8) + 0.5)) {
                let place = [left + (right - left) * i / 8.0, top + (bottom - top) * j / 8.0];
                let read = source.tap([place[0] / source.width as f64, place[1] / source.height as f64]);
                sum = std::array::from_fn(|c| sum[c] + read[c] / 64.0);
            }
            sum
        });
        let found = shown("Pixelate(source: \"in\", side: 4.0)", &scene);
        assert!(error(&found, &wanted) < 1e-5, "{width}x{height}: {}", error(&found, &wanted));
        assert!(width < 9 || found.at(4, 4) == found.at(7, 4.min(height - 1)));
    }
}

/// The tube with its default values but for the curvature, by the formulas of its file.
fn tube(source: &Image, curvature: f64) -> Image {
    let (width, height) = (source.width as f64, source.height as f64);
    let spread = 0.5 / 24.0 * height / width;
    let weights = [(-2.0, 0.0625), (-1.0, 0.25), (0.0, 0.375), (1.0, 0.25), (2.0, 0.0625)];
    let soft = Image::from_uv(source.width, source.height, |[u, v]| {
        let reads = weights.map(|(at, weight)| source.tap([u + at * spread, v]).map(|x| weight * x));
        reads.iter().fold([0.0; 4], |sum, read| std::array::from_fn(|c| sum[c] + read[c]))
    });
    Image::new(source.width, source.height, |x, y| {
        let [p, q] = [2.0 * (x as f64 + 0.5) / width - 1.0, 2.0 * (y as f64 + 0.5) / height - 1.0];
        let [u, v] = [p * (1.0 + 0.5 * curvature * q * q), q * (1.0 + 0.5 * curvature * p * p)].map(|t| 0.5 + 0.5 * t);
        let edge = ((u.min(1.0 - u) * width).min(v.min(1.0 - v) * height) + 0.5).clamp(0.0, 1.0);
        let line = 1.0 - 0.6 * (2.0 * std::f64::consts::PI * v * 24.0).cos();
        let color = soft.tap([u, v]);
        let light = |c: usize| color[c] * line * edge * if x % 3 == c { 2.0 } else { 0.5 };
        [light(0), light(1), light(2), color[3]]
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_tube_has_lines_stripes_and_a_curved_glass() {
    for (width, height) in SIZES {
        let scene = scene(width, height);
        let found = shown("Crt(source: \"in\", lines: 24.0, curvature: 0.2)", &scene);
        let wanted = tube(&image(&scene), f64::from(0.2_f32));
        assert!(error(&found, &wanted) < 1e-4, "{width}x{height}: {}", error(&found, &wanted));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_faulty_signal_moves_whole_blocks_of_lines() {
    let hash = |v: u32| {
        let state = v.wrapping_mul(747796405).wrapping_add(2891336453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277803737);
        (word >> 22) ^ word
    };
    let cell = |x: u32, y: u32| f64::from(hash(x ^ hash(y)) >> 8) / 16777216.0;
    let scene = scene(64, 36);
    let source = image(&scene);
    let wanted = Image::from_uv(64, 36, |[u, v]| {
        let block = (v * 9.0).floor() as u32;
        let jump = if cell(block, 0) < 0.5 { 0.2 * (2.0 * cell(block, 1) - 1.0) } else { 0.0 };
        let read = |apart: f64| source.tap([u + jump * (1.0 + 0.3 * apart), v]);
        [read(1.0)[0], read(0.0)[1], read(-1.0)[2], read(0.0)[3]]
    });
    let found = shown("Glitch(source: \"in\", amount: 0.2, share: 0.5, blocks: 9.0)", &scene);
    assert!(error(&found, &wanted) < 1e-4, "{}", error(&found, &wanted));
    let still = (0..9).filter(|block| (0..64).all(|x| found.at(x, 4 * block) == scene.at(x, 4 * block))).count();
    assert!((2..=7).contains(&still), "{still} of 9 blocks are as they were");
}

#[test]
fn the_kinds_of_folders_keep_the_contract() {
    afterimage_plan::contract(&kinds()).unwrap_or_else(|complaints| panic!("{}", complaints.join("\n")));
}
