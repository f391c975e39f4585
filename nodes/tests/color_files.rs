//! The nodes `Cdl` and `ColorLut` with files.

use std::sync::Arc;

use afterimage_graph::check::{CheckOptions, Graph, Loader, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::Registry;

struct Files;

impl Loader for Files {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        let bytes: &[u8] = match path {
            "shots.ccc" => include_bytes!("../../graph/color/tests/files/shots.ccc"),
            "warm.cc" => include_bytes!("../../graph/color/tests/files/warm.cc"),
            "display.clf" => include_bytes!("../../graph/color/tests/files/display.clf"),
            "broken.cube" => b"LUT_3D_SIZE 2\n0 0 0\nx\n",
            "strong.cc" => b"<ColorCorrection><SATNode><Saturation>9</Saturation></SATNode></ColorCorrection>",
            _ => return Err("no such file".into()),
        };
        Ok(bytes.into())
    }
}

fn checked(state: &str, node: &str) -> Result<Graph, String> {
    let text = format!(
        "Pipeline(inputs: {{ \"in\": {state} }}, nodes: {{ \"out\": {node} }}, outputs: {{ \"out\": \"out\" }})"
    );
    let document = parse("test.ron", &text).expect("a document");
    let kinds = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let options = CheckOptions { loader: &Files, ..CheckOptions::default() };
    check(&document, &kinds, &options).map(|(graph, _)| graph).map_err(|errors| errors.to_string())
}

#[test]
fn a_file_and_parameters_of_the_same_meaning_exclude_each_other() {
    let errors = [
        ("Cdl(source: \"in\", file: \"shots.ccc\")", "`shots.ccc`: the file has 2 corrections: set `id`"),
        ("Cdl(source: \"in\", id: \"a\")", "`id` needs a `file`"),
        (
            "Cdl(source: \"in\", file: \"warm.cc\", saturation: 0.5)",
            "`file` states slope, offset, power and saturation: remove these parameters",
        ),
        ("Cdl(source: \"in\", file: \"strong.cc\")", "`strong.cc`: `saturation` must be within 0 and 4"),
        ("Cdl(source: \"in\", file: \"shots.ccc\", id: 20)", "`id` of `Cdl` is a text in quotes"),
        ("ColorLut(source: \"in\", file: \"warm.cc\")", "the file is a color correction: use a node `Cdl`"),
        ("ColorLut(source: \"in\", file: \"display.clf\", shaper: Log2)", "remove `shaper`"),
        ("ColorLut(source: \"in\", file: \"broken.cube\")", "`broken.cube`: line 3: `x` is not a number"),
        ("ColorLut(source: \"in\", state: Encoded, to: Srgb)", "`state: Encoded` needs a `file`"),
        ("ColorLut(source: \"in\", file: \"display.clf\", state: Encoded)", "`state: Encoded` needs `to`"),
        (
            "ColorLut(source: \"in\", file: \"display.clf\", state: Encoded, to: AcesCct)",
            "`AcesCct` is no space of encoded images",
        ),
    ];
    for (node, expected) in errors {
        let error = checked("Exposed", node).expect_err(node);
        assert!(error.contains(expected), "{node}\n{error}");
    }
    for node in ["Cdl(source: \"in\", file: \"shots.ccc\", id: \"sh020\")", "Cdl(source: \"in\", file: \"warm.cc\")"] {
        checked("Exposed", node).unwrap_or_else(|error| panic!("{node}\n{error}"));
    }
}

#[test]
fn the_state_of_a_table_s_result_is_the_chosen_one() {
    use afterimage_graph::image::ColorState;
    let table = [
        ("", ColorState::Exposed),
        (", state: DisplayLinear", ColorState::DisplayLinear),
        (", state: Encoded", ColorState::Encoded),
    ];
    for (choice, expected) in table {
        let node = format!("ColorLut(source: \"in\", file: \"display.clf\", from: AcesCct, to: Srgb{choice})");
        let graph = checked("Exposed", &node).unwrap_or_else(|error| panic!("{node}\n{error}"));
        assert_eq!(graph.outputs[0].state, expected, "{node}");
    }
}
