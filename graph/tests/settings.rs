//! What changes a value, and which change has the last word; and what is known of colors along the wires.

use std::sync::Arc;

use afterimage_graph::check::{CheckOptions, Graph, Loader, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::Registry;
use afterimage_graph::value::Value;

const INNER: &str = r#"Pipeline(
    inputs: { "source": Color },
    nodes: { "gain": Exposure(source: "source", stops: 1.0) },
    set: { "gain.stops": 2.0 },
    outputs: { "result": "gain" },
)"#;

struct Inner;

impl Loader for Inner {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        (path == "inner.ron").then(|| INNER.as_bytes().into()).ok_or_else(|| format!("{path} is no file of this test"))
    }
}

fn graph(text: &str, sets: &[(&str, &str)]) -> Graph {
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
    let sets = sets.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let options = CheckOptions { sets, loader: &Inner, ..CheckOptions::default() };
    let checked = parse("outer.ron", text).and_then(|document| check(&document, &registry, &options));
    checked.unwrap_or_else(|errors| panic!("{errors}")).0
}

#[test]
fn changes_from_outside_win_over_those_from_inside() {
    let stops = |of_node: &str, of_file: &str, sets: &[(&str, &str)]| {
        let text = format!(
            r#"Pipeline(inputs: {{ "in": Color }}, outputs: {{ "out": "a" }}, set: {{ {of_file} }},
            nodes: {{ "a": Pipeline(file: "inner.ron", source: "in", set: {{ {of_node} }}) }})"#
        );
        let graph = graph(&text, sets);
        let (_, gain) = graph.node("a/gain").expect("the inner node has the path of both");
        gain.instance.value("stops").expect("the kind has it").clone()
    };
    let (of_node, of_file) = (r#""gain.stops": 3.0"#, r#""a/gain.stops": 4.0"#);
    assert_eq!(stops("", "", &[]), Value::Float(2.0), "the section `set` of the inner pipeline");
    assert_eq!(stops(of_node, "", &[]), Value::Float(3.0), "the field `set` of the node");
    assert_eq!(stops(of_node, of_file, &[]), Value::Float(4.0), "the section `set` of the outer pipeline");
    assert_eq!(stops(of_node, of_file, &[("a/gain.stops", "5.0")]), Value::Float(5.0), "the command line");
}

#[test]
fn an_adopted_white_passes_the_encoding() {
    let text = |white: &str| {
        format!(
            r#"Pipeline(inputs: {{ "in": Color }}, outputs: {{ "out": "display" }}, nodes: {{
            "white": WhiteBalance(source: "in"{white}), "exposed": Exposure(source: "white"),
            "mapped": ToneMap(source: "exposed"), "display": Encode(source: "mapped") }})"#
        )
    };
    let adopted = |white: &str| {
        let graph = graph(&text(white), &[]);
        let (at, _) = graph.node("display").expect("it exists");
        graph.colors().of_node(at)[0].expect("it is an image").colorimetry.adopted_white
    };
    assert!(adopted(", mode: Temperature, temperature: 3200.0").is_some());
    assert_eq!(adopted(", target: (1.0, 0.9, 0.8)"), None, "no white is known");
}
