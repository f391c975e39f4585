//! Kinds of folders that are part of a program.

use std::panic::catch_unwind;

use afterimage_graph::check::{CheckOptions, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::{EmbeddedKind, NodeKind, Registry};

const DECLARATION: &str = r#"Kind(
    name: "Invert",
    doc: "Inverts colors.",
    inputs: { "source": Image(doc: "The picture.", accepts: [DisplayLinear]) },
    outputs: { "result": Image(doc: "The negative.", state: Same("source")) },
)"#;
const SHADER: &str = "fn invert(source: vec4f) -> vec4f { return vec4f(1.0 - source.rgb, source.a); }";
const BROKEN: &str = "Camera Kind(";

static INVERT: EmbeddedKind = EmbeddedKind::new("Invert", ("node.ron", DECLARATION), &[("invert.wgsl", SHADER)], &[]);
static OTHER: EmbeddedKind = EmbeddedKind::new("Other", ("node.ron", DECLARATION), &[("invert.wgsl", SHADER)], &[]);
static WRONG: EmbeddedKind = EmbeddedKind::new("Wrong", ("node.ron", BROKEN), &[("wrong.wgsl", SHADER)], &[]);

const KINDS: &[NodeKind] = &[NodeKind::embedded(&INVERT), NodeKind::embedded(&OTHER), NodeKind::embedded(&WRONG)];

/// Whether a pipeline with a node of that kind, and with a camera, is right.
fn is_right(kind: &str) -> bool {
    let registry = Registry::new(&[afterimage_nodes::ALL, KINDS]).expect("the kinds have different names");
    let text = format!(
        r#"Pipeline(inputs: {{ "in": DisplayLinear, "depth": Depth, "camera": Camera }},
            nodes: {{ "it": {kind}(source: "in"), "linear": LinearDepth(depth: "depth", camera: "camera") }},
            outputs: {{ "out": "it", "distances": "linear" }})"#
    );
    let document = parse("test.ron", &text).expect("it is a pipeline");
    check(&document, &registry, &CheckOptions::default()).is_ok()
}

#[test]
fn a_folder_of_the_program_is_read_when_a_pipeline_names_its_kind() {
    assert!(is_right("Saturation"), "a folder was read that no node names");
    assert!(is_right("Invert"));
    for kind in ["Wrong", "Other"] {
        catch_unwind(|| is_right(kind)).expect_err("its folder is wrong");
    }
}
