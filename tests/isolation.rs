//! Kinds whose shaders have clashing names: fused into one module, one after the other, and with names of their own.
#![allow(clippy::print_stdout, reason = "the longest time of many pairs")]

#[path = "../graph/wgsl/tests/hostile/mod.rs"]
#[allow(dead_code, reason = "the bombs are for other tests")]
mod hostile;

use std::ops::Range;
use std::time::{Duration, Instant};

use afterimage_graph::check::{CheckOptions, Graph, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::{NodeKind, Registry, folder_kind_of};

use crate::support::gpu::{Picture, Run};
use crate::support::sweep;
use hostile::{Kernel, pair};

fn kind(name: &str, kernel: &Kernel) -> NodeKind {
    let Kernel { text, function, argument, shared } = kernel;
    let declaration = format!(
        r#"Kind(
            name: "{name}", doc: "Computes something.",
            inputs: {{ "{argument}": Image(doc: "A picture.") }},
            outputs: {{ "result": Image(doc: "Another.", state: Same("{argument}"), function: "{function}") }},
        )"#
    );
    let file = format!("{}.wgsl", name.to_lowercase());
    let files = [(file.as_str(), text.as_str()), ("shared.wgsl", shared.as_str())];
    folder_kind_of(("node.ron", &declaration), &files).unwrap_or_else(|errors| panic!("{errors}\n{text}"))
}

fn graph(kernels: &[Kernel; 2]) -> Graph {
    let kinds = [kind("One", &kernels[0]), kind("Two", &kernels[1])];
    let registry = Registry::new(&[&kinds]).expect("the kinds have two names");
    let text = format!(
        r#"Pipeline(
            inputs: {{ "in": Color }},
            nodes: {{ "one": One({0}: "in"), "two": Two({1}: "one"), "again": One({0}: "two") }},
            outputs: {{ "out": "again" }},
        )"#,
        kernels[0].argument, kernels[1].argument
    );
    let document = parse("test.ron", &text).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
    check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors:?}")).0
}

fn pixels(graph: &Graph, is_fused: bool, scene: &Picture) -> Vec<[u32; 4]> {
    let mut run = Run::new(graph).exact();
    run.options.fuse = is_fused;
    let shown = run.frame(&[("in", scene)]).remove(0);
    shown.pixels.into_iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

/// Pairs that the test runs: 40 in a whole sweep. `AFTERIMAGE_HOSTILE_PAIRS=10000 cargo test -p afterimage-tests isolation` runs more, and
/// `5000..10000` the second half of these.
fn pairs() -> Range<u64> {
    let Ok(asked) = std::env::var("AFTERIMAGE_HOSTILE_PAIRS") else { return 0..sweep::cases(40) };
    let (first, end) = asked.split_once("..").unwrap_or(("0", &asked));
    let number = |text: &str| text.parse().unwrap_or_else(|error| panic!("AFTERIMAGE_HOSTILE_PAIRS={asked}: {error}"));
    number(first)..number(end)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn kinds_with_clashing_names_compute_the_same_together_as_alone() {
    let scene = Picture::new(16, 16, |x, y| [x as f32 * 0.11, y as f32 * 0.3, (x * y) as f32 * 0.01, 1.0]);
    let mut longest = Duration::ZERO;
    for seed in pairs() {
        let begin = Instant::now();
        let pair = pair(seed);
        let (hostile, tame) = (graph(&pair.hostile), graph(&pair.tame));
        let fused = pixels(&hostile, true, &scene);
        assert_eq!(fused, pixels(&hostile, false, &scene), "pair {seed}, each in a pass of its own");
        assert_eq!(fused, pixels(&tame, true, &scene), "pair {seed}, with names of their own");
        assert!(fused.iter().any(|pixel| *pixel != fused[0]), "pair {seed} has one color");
        longest = longest.max(begin.elapsed());
    }
    println!("the slowest pair takes {} ms in its three ways", longest.as_millis());
}

/// A kind whose kernel makes numbers that are not finite at three pixels, or 0 there, or what they are limited to.
fn poison(bits: [u32; 3]) -> NodeKind {
    let [a, b, c] = bits;
    let text = format!(
        "fn poison(source: vec4f, at: Point) -> vec4f {{
    let index = at.pixel.x + 32 * at.pixel.y;
    let bits = select(select({a}u, {b}u, index == 400), {c}u, index == 700);
    let poisoned = vec4f(vec3f(bitcast<f32>(bits + u32(min(at.pixel.x, 0)))), 1.0);
    return select(source, poisoned, index == 100 || index == 400 || index == 700);
}}"
    );
    let declaration = r#"Kind(
        name: "Poison", doc: "Spoils some pixels.",
        inputs: { "source": Image(doc: "A picture.") },
        outputs: { "result": Image(doc: "The same, spoilt.", state: Same("source")) },
    )"#;
    folder_kind_of(("node.ron", declaration), &[("poison.wgsl", &text)]).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Four frames of a bloom, a meter with adaptation and a history behind the kind.
fn spoilt_frames(kind: NodeKind, is_fused: bool) -> Vec<Vec<Picture>> {
    let registry = Registry::new(&[afterimage_nodes::ALL, &[kind]]).expect("no other kind has this name");
    let text = r#"Pipeline(
        inputs: { "scene": Color },
        nodes: {
            "poison": Poison(source: "scene"),
            "mean": MeanLuminance(source: "poison"),
            "meter": Adapt(mean: "mean"),
            "exposed": Exposure(source: "poison", meter: "meter"),
            "bright": Extract(source: "exposed", before: "bright.peaks@previous", fireflies: Limit, threshold: 0.2),
            "mips": Downsample(source: "bright", levels: 3),
            "bloom": Upsample(source: "mips"),
            "lit": Composite(base: "exposed", bloom: "bloom", blend: Add, strength: 0.5),
        },
        outputs: { "lit": "lit" },
    )"#;
    let document = parse("test.ron", text).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
    let graph = check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors:?}")).0;
    let mut run = Run::new(&graph);
    run.options.fuse = is_fused;
    let scene = Picture::new(32, 24, |x, y| [0.02 * x as f32, 0.03 * y as f32, 0.2, 1.0]);
    run.frames(&[("scene", &scene)], &[(0.1, false); 4])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn numbers_of_a_strangers_kernel_that_are_not_finite_act_as_finite_ones() {
    // NaN, infinity and negative infinity, and what they are limited to.
    let limited = [0, 65504.0_f32.to_bits(), 0];
    for is_fused in [true, false] {
        let spoilt = spoilt_frames(poison([0x7fc0_0000, 0x7f80_0000, 0xff80_0000]), is_fused);
        assert_eq!(spoilt, spoilt_frames(poison(limited), is_fused), "fused: {is_fused}");
        let clean = spoilt_frames(poison([0x3dcc_cccd; 3]), is_fused);
        assert_ne!(spoilt[3][0].at(0, 0), clean[3][0].at(0, 0), "the limit is light that the meter sees");
    }
}
