//! What is accepted, and what it comes to.

use afterimage_graph::check::{CheckOptions, Facts, Graph, Source, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{ColorState, Format};
use afterimage_graph::node::Registry;
use afterimage_graph::value::Value;

use super::{CaseFiles, checked, kinds};

pub(super) const LYNX: &str = r#"// Threshold bloom and a filmic curve.
Pipeline(
    inputs: { "scene": Color, "mask": Mask(optional: true) },
    nodes: {
        "exposed": Exposure(source: "scene", stops: -2),
        "bright":  Extract(source: "exposed", threshold: 1.0, knee: 0.1, when: "emissive and illuminance < 10"),
        "mips":    Downsample(source: "bright", levels: 5, format: Rg11b10Ufloat),
        "bloom":   Upsample(source: "mips", radius: 0.85, label: "glow"),
        "lit":     Composite(base: "exposed", bloom: "bloom", strength: 0.5), // a comment
        "tinted":  Tint(source: "lit", color: (1, 0.5, 2.5e-1) /* another */, keep: false),
        "trail":   Composite(base: "tinted", bloom: "trail@previous:2"),
        "mapped":  ToneMap(source: "trail", curve: Reinhard),
        "display": Encode(source: "mapped"),
    },
    outputs: { "display": "display", "light": "bloom" },
    tiers: { "low": { "mips.levels": 3, "bloom": Off }, "film": "files/film.ron" },
)
"#;

fn graph_of(text: &str, tier: Option<&str>, sets: &[(&str, &str)]) -> Graph {
    let registry = Registry::new(&[kinds::ALL]).expect("the kinds have different names");
    let sets = sets.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let options = CheckOptions { tier: tier.map(str::to_owned), sets, loader: &CaseFiles };
    let checked = parse("lynx.ron", text).and_then(|document| check(&document, &registry, &options));
    checked.unwrap_or_else(|told| panic!("{told}")).0
}

fn value(graph: &Graph, node: &str, param: &str) -> Value {
    let (_, node) = graph.node(node).expect("the node exists");
    node.instance.value(param).expect("the parameter exists").clone()
}

#[test]
fn the_spelling_of_values_does_not_matter() {
    let graph = graph_of(LYNX, None, &[]);
    assert_eq!(value(&graph, "exposed", "stops"), Value::Float(-2.0));
    assert_eq!(value(&graph, "tinted", "color"), Value::Vector([1.0, 0.5, 0.25, 0.0], 3));
    assert_eq!(value(&graph, "tinted", "keep"), Value::Bool(false));
    assert_eq!(value(&graph, "mapped", "curve"), Value::Choice("Reinhard"));
    assert_eq!(value(&graph, "mips", "levels"), Value::Int(5));
}

#[test]
fn wires_states_and_order_come_out() {
    let graph = graph_of(LYNX, None, &[]);
    let names: Vec<&str> = graph.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["exposed", "bright", "mips", "bloom", "lit", "tinted", "trail", "mapped", "display"]);
    let (trail, node) = graph.node("trail").expect("it exists");
    assert_eq!(node.wires[1], Some(Source::Node { node: trail, output: 0, previous: 2 }));
    assert_eq!(graph.node("bloom").expect("it exists").1.states, [Some(ColorState::Exposed)]);
    assert_eq!(graph.node("mips").expect("it exists").1.format, Some(Format::Rg11b10Ufloat));
    assert_eq!(graph.node("bloom").expect("it exists").1.label.as_deref(), Some("glow"));
    assert_eq!(graph.outputs.iter().map(|o| o.state).collect::<Vec<_>>(), [ColorState::Encoded, ColorState::Exposed]);
    assert_eq!((graph.inputs[1].optional, graph.inputs[0].optional), (true, false));
    assert_eq!(graph.wires.edge_count(), 9);
    assert_eq!(graph.facts().iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["emissive", "illuminance"]);
}

#[test]
fn a_tier_changes_values_and_switches_off() {
    let graph = graph_of(LYNX, Some("low"), &[]);
    assert_eq!(value(&graph, "mips", "levels"), Value::Int(3));
    assert!(graph.node("bloom").expect("it exists").1.off);
    assert!(!graph_of(LYNX, None, &[]).node("bloom").expect("it exists").1.off);
}

#[test]
fn the_command_line_has_the_last_word() {
    let graph = graph_of(
        LYNX,
        Some("low"),
        &[("mips.levels", "7"), ("bloom", "On"), ("bloom.when", "\"dark\""), ("lit.format", "Rgba32Float")],
    );
    assert_eq!(value(&graph, "mips", "levels"), Value::Int(7));
    let (_, bloom) = graph.node("bloom").expect("it exists");
    let facts: Facts = [("dark", false.into())].into_iter().collect();
    assert!(!bloom.off && !bloom.when.as_ref().expect("it was set").holds(&facts));
    assert_eq!(graph.node("lit").expect("it exists").1.format, Some(Format::Rgba32Float));
}

#[test]
fn a_tier_may_be_another_file_that_extends_a_third() {
    let graph = graph_of(LYNX, Some("film"), &[]);
    assert_eq!(value(&graph, "exposed", "stops"), Value::Float(3.0));
    assert_eq!(value(&graph, "mapped", "curve"), Value::Choice("Aces"));
    assert!(graph.node("tinted").is_some() && graph.node("bloom").is_none());
}

#[test]
fn a_pipeline_is_a_node() {
    let text = r#"Pipeline(
        inputs: { "scene": Color },
        nodes: {
            "exposed": Exposure(source: "scene"),
            "glow": Pipeline(file: "files/bloom.ron", source: "exposed", when: "night", label: "Glow",
                             set: { "mips.levels": 2, "up.when": "bright" }),
            "more": Composite(base: "glow", bloom: "glow.light@previous"),
        },
        outputs: { "lit": "more" },
        set: { "glow/bright.knee": 0.7, "glow/lit": Off },
    )"#;
    let (graph, warnings) = checked("outer.ron", text).unwrap_or_else(|told| panic!("{told}"));
    assert!(warnings.is_empty(), "{warnings}");
    let names: Vec<&str> = graph.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["exposed", "glow/bright", "glow/mips", "glow/up", "glow/lit", "more"]);
    assert_eq!(
        (value(&graph, "glow/mips", "levels"), value(&graph, "glow/bright", "knee")),
        (Value::Int(2), Value::Float(0.7))
    );
    assert_eq!(graph.nodes[1].wires[0], Some(Source::Node { node: 0, output: 0, previous: 0 }));
    assert_eq!(
        graph.nodes[5].wires,
        [4, 3].map(|node| Some(Source::Node { node, output: 0, previous: u32::from(node == 3) }))
    );
    assert_eq!(graph.nodes[3].when.as_ref().map(ToString::to_string).as_deref(), Some("bright and night"));
    assert_eq!(graph.nodes[2].label.as_deref(), Some("Glow/mips"));
    assert_eq!(graph.nodes.iter().map(|node| node.off).collect::<Vec<_>>(), [false, false, false, false, true, false]);
}

#[test]
fn a_file_may_end_without_a_line_and_begin_with_extensions() {
    let text = "#![enable(implicit_some)]\n\
                Pipeline(inputs: { \"a\": Encoded }, nodes: {}, outputs: { \"b\": \"a\" }) // the end";
    let (graph, _) = checked("end.ron", text).unwrap_or_else(|told| panic!("{told}"));
    assert_eq!((graph.outputs[0].source, graph.outputs[0].state), (Source::Input(0), ColorState::Encoded));
}

#[test]
fn a_scale_is_any_factor_that_a_number_of_32_bits_holds() {
    for (written, scale) in [("0.25", 0.25), ("4", 4.0), ("1e-30", 1e-30), ("1e30", 1e30)] {
        let text = LYNX.replace("\"scene\": Color,", &format!("\"scene\": Color(scale: {written}),"));
        let graph = graph_of(&text, None, &[]);
        assert_eq!([graph.inputs[0].scale, graph.inputs[1].scale], [scale, 1.0], "{written}");
    }
}
