//! Kinds without Rust whose functions share memory of a workgroup, compared with CPU references.

use std::path::Path;

use afterimage_graph::check::{CheckOptions, Graph, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::{NodeKind, PassKind, Registry, folder_kind};
use afterimage_wgsl::limits;

use crate::support::gpu::{Picture, Run, gpu};

const SIZES: [(u32, u32); 5] = [(33, 17), (64, 36), (5, 70), (16, 16), (1, 1)];

fn kind(declaration: &str, shader: (&str, &str)) -> NodeKind {
    let kind = folder_kind(("node.ron", declaration), shader).unwrap_or_else(|errors| panic!("{errors}"));
    afterimage_plan::contract(std::slice::from_ref(&kind)).unwrap_or_else(|errors| panic!("{}", errors.join("\n")));
    kind
}

fn despeckle() -> NodeKind {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("folders/despeckle");
    let text = |name: &str| {
        let path = folder.join(name);
        std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    };
    kind(&text("node.ron"), ("despeckle.wgsl", &text("despeckle.wgsl")))
}

/// A kind `Shares` of one image with a workgroup of 8x4 around that shader.
fn shares(shader: &str) -> NodeKind {
    let declaration = r#"Kind(
        name: "Shares", doc: "Shares memory.",
        inputs: { "source": Image(doc: "A picture.") },
        outputs: { "result": Image(doc: "Another.", state: Same("source"), workgroup: (8, 4)) },
    )"#;
    kind(declaration, ("shares.wgsl", shader))
}

fn graph(kind: NodeKind, nodes: &str) -> Graph {
    let registry = Registry::new(&[afterimage_nodes::ALL, &[kind]]).expect("no two kinds share a name");
    let text = format!("Pipeline(inputs: {{ \"in\": Color }}, nodes: {{ {nodes} }}, outputs: {{ \"out\": \"it\" }})");
    let document = parse("test.ron", &text).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
    check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors:?}")).0
}

/// A picture without two equal neighbors, and with specks.
fn scene(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let spark = if (x * 7 + y * 3) % 11 == 0 { 40.0 } else { 0.0 };
        [
            0.25 + x as f32 * 0.125 + spark,
            (x * 5 + y * 3) as f32 % 7.0,
            (x * y) as f32 * 0.03125,
            1.0 - y as f32 / 128.0,
        ]
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_median_by_tiles_is_the_median_of_nine() {
    let graph = graph(despeckle(), r#""it": Despeckle(source: "in", strength: 0.75)"#);
    for (width, height) in SIZES {
        let scene = scene(width, height);
        let found = Run::new(&graph).exact().frame(&[("in", &scene)]).remove(0);
        let mut changed = 0;
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let own = scene.at(x, y);
            let near = |at: u32, by: u32, end: u32| (at + by).saturating_sub(1).min(end - 1);
            let around = (0..9).map(|i| scene.at(near(x, i % 3, width), near(y, i / 3, height)));
            for channel in 0..4 {
                let mut sorted: Vec<f64> = around.clone().map(|pixel| f64::from(pixel[channel])).collect();
                sorted.sort_by(f64::total_cmp);
                let own = f64::from(own[channel]);
                let wanted = if channel == 3 { own } else { own + (sorted[4] - own) * 0.75 };
                let difference = (f64::from(found.at(x, y)[channel]) - wanted).abs();
                assert!(difference <= 1e-5, "{width}x{height} at {x}, {y}: {:?}, not {wanted}", found.at(x, y));
                changed += u32::from((wanted - own).abs() > 1.0);
            }
        }
        assert!(changed > width * height / 16 || width < 5, "{width}x{height}: only {changed} numbers change");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn sums_and_counts_of_a_workgroup_are_those_of_its_pixels() {
    // Beyond the border a pixel is the nearest one, and takes part as that.
    let shader = "import afterimage::workgroup::Invocation;
var<workgroup> bright: atomic<u32>;
fn shares(source: vec4f, invocation: Invocation) -> vec4f {
    if source.x > 3.0 { atomicAdd(&bright, 1u); }
    workgroupBarrier();
    let count = atomicLoad(&bright);
    var reds = array<f32, 1>();
    reds[0] = source.x;
    let sum = workgroup_total(invocation, reds[0]);
    return vec4f(f32(count), sum, source.z, f32(invocation.index) / 32.0);
}
var<workgroup> numbers: array<f32, 32>;
// The invocations add in a fixed order, in a loop whose steps are counted.
fn workgroup_total(invocation: Invocation, value: f32) -> f32 {
    numbers[invocation.index] = value;
    workgroupBarrier();
    var sum = 0.0;
    for (var other = 0u; other < 32u; other++) { sum += numbers[other]; }
    return sum;
}";
    let graph = graph(shares(shader), r#""it": Shares(source: "in")"#);
    for (width, height) in SIZES {
        let scene = scene(width, height);
        let found = Run::new(&graph).exact().frame(&[("in", &scene)]).remove(0);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let (left, top) = (x / 8 * 8, y / 4 * 4);
            let reds = (0..32).map(|i| scene.at((left + i % 8).min(width - 1), (top + i / 8).min(height - 1))[0]);
            let count = reds.clone().filter(|red| *red > 3.0).count();
            let sum: f64 = reds.map(f64::from).sum();
            let index = (x - left) + 8 * (y - top);
            let pixel = found.at(x, y).map(f64::from);
            let place = format!("{width}x{height} at {x}, {y}");
            assert_eq!((pixel[0], pixel[3] * 32.0), (count as f64, f64::from(index)), "{place}");
            assert!((pixel[1] - sum).abs() < 1e-3, "{place}: {} is not {sum}", pixel[1]);
        }
    }
}

/// An index beyond an array of a workgroup takes its last number, and never that of the array behind it.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn an_index_stays_in_its_array_of_a_workgroup() {
    let shader = "import afterimage::workgroup::Invocation;
var<workgroup> first: array<f32, 32>;
var<workgroup> second: array<f32, 32>;
fn shares(source: vec4f, invocation: Invocation) -> vec4f {
    first[invocation.index] = 1.0 + f32(invocation.index);
    second[invocation.index] = 100.0 + f32(invocation.index);
    workgroupBarrier();
    let beyond = invocation.index + 20u * u32(source.x);
    return vec4f(first[beyond], second[beyond], f32(invocation.index), 1.0);
}";
    let graph = graph(shares(shader), r#""it": Shares(source: "in")"#);
    let scene = Picture::new(16, 8, |x, y| [1.0 + (x / 8 + y / 4) as f32, 0.0, 0.0, 1.0]);
    let found = Run::new(&graph).exact().frame(&[("in", &scene)]).remove(0);
    for (pixel, given) in found.pixels.iter().zip(&scene.pixels) {
        let beyond = (pixel[2] + 20.0 * given[0]).min(31.0);
        assert_eq!(pixel[..2], [1.0 + beyond, 100.0 + beyond], "invocation {}", pixel[2]);
    }
    assert_eq!(found.at(15, 7)[2], 31.0);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pass_with_a_workgroup_is_dispatched_alone_also_where_others_are_drawn() {
    let nodes = r#""before": Brightness(source: "encoded", amount: 0.25),
        "encoded": Encode(source: "shown"), "shown": ToneMap(source: "lit"), "lit": Exposure(source: "in"),
        "it": Despeckle(source: "shown")"#;
    let graph = graph(despeckle(), nodes);
    let scene = scene(33, 17);
    let mut shown = Vec::new();
    for prefer_fragment in [false, true] {
        let mut run = Run::new(&graph).exact();
        run.prefer_fragment = prefer_fragment;
        let plan = run.plan(&gpu(), &[("in", &scene)]);
        let alone = plan.work().filter(|pass| pass.kind == PassKind::Workgroup([16, 16])).count();
        assert_eq!(alone, 1, "{}", plan.to_text());
        shown.push(run.frame(&[("in", &scene)]).remove(0));
    }
    let differs = |[a, b]: [&[f32; 4]; 2]| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-6);
    assert!(!shown[0].pixels.iter().zip(&shown[1].pixels).any(|(a, b)| differs([a, b])));
    assert!(differs([&shown[0].at(0, 0), &shown[0].at(20, 10)]), "the picture has one color");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn memory_of_a_workgroup_begins_with_zeros_and_numbers_in_it_are_limited_where_they_leave() {
    let shader = "import afterimage::workgroup::Invocation;
var<workgroup> words: array<u32, 32>;
fn shares(source: vec4f, invocation: Invocation) -> vec4f {
    let old = words[31u - invocation.index];
    workgroupBarrier();
    words[invocation.index] = 0x7fc00000u + u32(source.w * 0.0);
    workgroupBarrier();
    let spoilt = bitcast<f32>(words[(invocation.index + 7u) % 32u]);
    return vec4f(f32(old), spoilt, source.z, 1e30 * source.w);
}";
    let graph = graph(shares(shader), r#""it": Shares(source: "in")"#);
    let scene = scene(33, 17);
    for _ in 0..2 {
        let found = Run::new(&graph).exact().frame(&[("in", &scene)]).remove(0);
        for (pixel, source) in found.pixels.iter().zip(&scene.pixels) {
            assert_eq!(*pixel, [0.0, 0.0, source[2], 65504.0]);
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_loop_without_end_ends_at_the_limit_which_is_lower_in_a_workgroup() {
    let shader = "fn shares(source: vec4f) -> vec4f {
    var count = 0u;
    loop { count += 1u; if count == 0xffffffffu { break; } }
    var second = 0u;
    loop { second += 1u; if second == 0xffffffffu { break; } }
    return vec4f(f32(count), f32(second), source.z, 0.25);
}";
    let scene = scene(9, 5);
    let pixel = r#"Kind(
        name: "Shares", doc: "Shares nothing.",
        inputs: { "source": Image(doc: "A picture.") },
        outputs: { "result": Image(doc: "Another.", state: Same("source"), function: "shares") },
    )"#;
    let alone = if gpu().is_processor() { limits::PROCESSOR_LOOP_STEPS } else { limits::LOOP_STEPS };
    let kinds = [(shares(shader), limits::WORKGROUP_LOOP_STEPS), (kind(pixel, ("shares.wgsl", shader)), alone)];
    for (kind, most) in kinds {
        let graph = graph(kind, r#""it": Shares(source: "in")"#);
        let found = Run::new(&graph).exact().frame(&[("in", &scene)]).remove(0);
        for (x, y) in (0..5).flat_map(|y| (0..9).map(move |x| (x, y))) {
            let [count, second, blue, alpha] = found.at(x, y);
            assert_eq!([count, second], [most.max as f32, 0.0], "at {x}, {y}");
            // The function goes on.
            assert_eq!([blue, alpha], [scene.at(x, y)[2], 0.25], "{x}, {y}");
        }
    }
}
