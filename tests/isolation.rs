//! Kinds whose shaders have clashing names: fused into one module, one after the other, and with names of their own.

#[path = "../graph/wgsl/tests/hostile/mod.rs"]
#[allow(dead_code, reason = "the bombs are for other tests")]
mod hostile;

use afterimage_graph::check::{CheckOptions, Graph, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::{NodeKind, Registry, folder_kind_of};

use crate::support::gpu::{Picture, Run};
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

/// Pairs that the test runs. `AFTERIMAGE_HOSTILE_PAIRS=10000 cargo test -p afterimage-tests isolation` runs more.
fn pairs() -> u64 {
    let more = std::env::var("AFTERIMAGE_HOSTILE_PAIRS").ok().and_then(|count| count.parse().ok());
    more.unwrap_or(40)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn kinds_with_clashing_names_compute_the_same_together_as_alone() {
    let scene = Picture::new(16, 16, |x, y| [x as f32 * 0.11, y as f32 * 0.3, (x * y) as f32 * 0.01, 1.0]);
    for seed in 0..pairs() {
        let pair = pair(seed);
        let (hostile, tame) = (graph(&pair.hostile), graph(&pair.tame));
        let fused = pixels(&hostile, true, &scene);
        assert_eq!(fused, pixels(&hostile, false, &scene), "pair {seed}, each in a pass of its own");
        assert_eq!(fused, pixels(&tame, true, &scene), "pair {seed}, with names of their own");
        assert!(fused.iter().any(|pixel| *pixel != fused[0]), "pair {seed} has one color");
    }
}
