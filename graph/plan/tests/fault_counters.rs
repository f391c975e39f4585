//! Fault counters of functions of kinds in folders.

use afterimage_graph::check::{CheckOptions, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::{Registry, folder_kind};
use afterimage_plan::{Options, verify};

use super::support::{FRAME, plan_at};

const NODE: &str = r#"Kind(
    name: "Halves",
    doc: "Makes levels, and a picture of them.",
    inputs: { "source": Image(doc: "The image.") },
    images: { "levels": Pyramid(down: "source", levels: 2) },
    outputs: { "result": Image(doc: "The result.", state: Same("source"), reads: { "low": Level("levels", 1) }) },
)"#;
const SHADER: &str = "fn halves_levels(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    return tap(source, source_sampler, at.uv);
}
fn halves(source: vec4f, low: texture_2d<f32>, low_sampler: sampler, at: Point) -> vec4f {
    var sum = source;
    while sum.x < 1.0 { sum += source; }
    return sum / tap(low, low_sampler, at.uv);
}
";

#[test]
fn each_call_of_an_untrusted_function_is_counted_on_request_and_only_then() {
    let kind = folder_kind(("halves/node.ron", NODE), ("halves/halves.wgsl", SHADER)).unwrap_or_else(|e| panic!("{e}"));
    let registry = Registry::new(&[&[kind], afterimage_nodes::ALL]).unwrap();
    let text = r#"Pipeline(
        inputs: { "picture": Color },
        nodes: {
            "halves": Halves(source: "picture"),
            "dark": Exposure(source: "halves", stops: -1.0),
        },
        outputs: { "out": "dark" },
    )"#;
    let (graph, _) = check(&parse("test.ron", text).unwrap(), &registry, &CheckOptions::default()).unwrap();
    for fuse in [true, false] {
        let plan = |count_faults| plan_at(&graph, FRAME, Options { count_faults, fuse, ..Options::default() }).unwrap();
        let (counting, mut asking) = (plan(true), 0);
        assert_eq!(verify(&counting), Ok(()));
        let mut counted: Vec<(&str, String)> =
            counting.fault_counters().map(|counter| (counter.output, counter.kernel.function.to_string())).collect();
        counted.sort_unstable();
        let expected = [
            ("halves.levels.0.faults", "halves_levels".to_owned()),
            ("halves.levels.1.faults", "halves_levels".to_owned()),
            ("halves.result.faults", "halves".to_owned()),
        ];
        assert_eq!(counted, expected, "fused: {fuse}");
        assert!(
            counting.fault_counters().all(|counter| counter.kernel.limited.is_none()),
            "limits would hide what is counted"
        );
        for pass in 0..counting.passes.len() {
            let composed = counting.compose(pass, Default::default()).unwrap_or_else(|error| panic!("{error}"));
            composed.validate().unwrap_or_else(|error| panic!("{error}"));
            let is_counter = counting.passes[pass].pass.kernels.iter().any(|kernel| kernel.arg("faults").is_some());
            // Only the last function has a loop.
            let asks = composed.source.contains("were_steps_cut()") && composed.source.contains("fn halves(");
            assert!(!asks || is_counter, "{}", composed.source);
            asking += usize::from(asks);
        }
        assert!(asking > 0, "a counter asks whether loops were ended");
        assert_eq!(plan(false).fault_counters().count(), 0);
        assert_eq!(plan(false).outputs.len(), 1);
    }
}
