//! What changes a value, and which change has the last word; and what is known of colors along the wires.

use std::sync::Arc;

use afterimage_graph::check::{CheckOptions, Facts, Graph, Loader, Source, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_graph::prelude::*;
use afterimage_graph::value::Value;

const INNER: &str = r#"Pipeline(
    inputs: { "source": Color },
    nodes: { "gain": Exposure(source: "source", stops: 1.0) },
    set: { "gain.stops": 2.0 },
    outputs: { "result": "gain" },
)"#;

const MIDDLE: &str = r#"Pipeline(
    inputs: { "source": Color },
    nodes: { "b": Pipeline(file: "inner.ron", source: "source") },
    outputs: { "result": "b" },
)"#;

const FACTS: &str = r#"Pipeline(
    facts: { "dark": "there is little light" },
    inputs: { "in": Color },
    nodes: { "gain": Exposure(source: "in", when: "dark") },
    outputs: { "out": "gain" },
)"#;

/// Files of this test: one is an inner pipeline, and two extend each other.
struct Files;

impl Loader for Files {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        match path {
            "inner.ron" => Ok(INNER.as_bytes().into()),
            "one.ron" => Ok(br#"Pipeline(extends: "two.ron")"#.as_slice().into()),
            "two.ron" => Ok(br#"Pipeline(extends: "one.ron")"#.as_slice().into()),
            "middle.ron" => Ok(MIDDLE.as_bytes().into()),
            "facts.ron" => Ok(FACTS.as_bytes().into()),
            "binary.ron" => Ok([0xff, 0xfe].as_slice().into()),
            _ => Err(format!("{path} is no file of this test")),
        }
    }
}

fn graph(text: &str, sets: &[(&str, &str)]) -> Graph {
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
    let sets = sets.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let options = CheckOptions { sets, loader: &Files, ..CheckOptions::default() };
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

const REWIRED: &str = r#"Pipeline(
    inputs: { "in": Color },
    nodes: {
        "small": Downsample(source: "in", levels: 1, filter: Box),
        "counted": Histogram(source: "in"),
        "meter": AutoExposure(histogram: "counted"),
        "glow": Pipeline(file: "inner.ron", source: "in"),
        "shown": Exposure(source: "in", meter: "meter"),
    },
    outputs: { "out": "shown", "glow": "glow" },
    tiers: { "low": { "counted.source": "small.coarsest" } },
)"#;

/// The name of what the histogram reads, and the warnings.
fn counted_image(text: &str, tier: Option<&str>, sets: &[(&str, &str)]) -> Result<(String, String), String> {
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
    let sets = sets.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let options = CheckOptions { tier: tier.map(str::to_owned), sets, loader: &Files };
    let document = parse("outer.ron", text).expect("it can be parsed");
    let (graph, warnings) = check(&document, &registry, &options).map_err(|errors| errors.to_string())?;
    let (_, counted) = graph.node("counted").expect("it exists");
    let name = match counted.wires[0].expect("it is wired") {
        Source::Input(input) => graph.inputs[input].name.clone(),
        Source::Node { node, .. } => graph.nodes[node].name.clone(),
    };
    Ok((name, warnings.to_string()))
}

#[test]
fn a_tier_can_change_a_wire_and_nodes_for_it_alone_are_not_unneeded() {
    assert_eq!(counted_image(REWIRED, None, &[]), Ok(("in".into(), String::new())), "as written");
    assert_eq!(counted_image(REWIRED, Some("low"), &[]), Ok(("small".into(), String::new())));
    let back = counted_image(REWIRED, Some("low"), &[("counted.source", "\"in\"")]);
    assert_eq!(back, Ok(("in".into(), String::new())), "the command line has the last word");
}

#[test]
fn a_wrong_wire_of_a_tier_is_an_error_whatever_tier_is_asked_for() {
    let refused = |wire: &str, tier: Option<&str>| {
        let text = REWIRED.replace("small.coarsest", wire);
        counted_image(&text, tier, &[]).expect_err(wire)
    };
    for tier in [None, Some("low")] {
        let missing = refused("smal", tier);
        assert!(missing.contains("no input or node is called `smal`") && missing.contains("`small`"), "{missing}");
        assert_eq!(missing.matches("error[").count(), 1, "it is said once: {missing}");
        assert!(refused("small.finest", tier).contains("has no output `finest`"));
    }
    let cycle = refused("shown", Some("low"));
    assert!(cycle.contains("error[cycle]"), "{cycle}");
    let inner = counted_image(REWIRED, None, &[("glow/gain.source", "\"source\"")]).expect_err("it is inside");
    assert!(inner.contains("whose wires cannot be set"), "{inner}");
}

#[test]
fn a_condition_holds_for_all_that_is_nested_in_its_node() {
    let text = r#"Pipeline(inputs: { "in": Color }, outputs: { "out": "a" },
        nodes: { "a": Pipeline(file: "middle.ron", source: "in", when: "dark") })"#;
    let graph = graph(text, &[]);
    let (_, gain) = graph.node("a/b/gain").expect("the path of a node names all around it");
    let when = gain.when.as_ref().expect("it has the condition of the node around it");
    let holds = |dark: bool| when.holds(&[("dark", dark.into())].into_iter().collect::<Facts>());
    assert_eq!([holds(true), holds(false)], [true, false]);
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

/// What is said of a pipeline that extends a file.
fn refused(base: &str) -> String {
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
    let options = CheckOptions { loader: &Files, ..CheckOptions::default() };
    let text = format!("Pipeline(extends: \"{base}\")");
    let document = parse("outer.ron", &text).unwrap_or_else(|errors| panic!("{errors}"));
    check(&document, &registry, &options).expect_err(base).to_string()
}

#[test]
fn a_cycle_of_files_is_told_without_those_that_lead_to_it() {
    let errors = refused("one.ron");
    assert!(errors.contains("a file extends itself: one.ron -> two.ron -> one.ron"), "{errors}");
}

#[test]
fn the_facts_of_a_base_are_known_beside_those_of_a_file() {
    let graph = graph(
        r#"Pipeline(extends: "facts.ron", facts: { "wet": "it rains" }, set: { "gain.when": "wet or dark" })"#,
        &[],
    );
    assert_eq!(graph.facts().iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["dark", "wet"]);
}

#[test]
fn bytes_that_are_no_text_are_no_pipeline() {
    let errors = refused("binary.ron");
    assert!(errors.contains("`binary.ron` is not a text file"), "{errors}");
}

#[test]
fn a_state_is_the_chosen_one_and_without_a_choice_that_of_the_first_input() {
    let text = r#"Pipeline(inputs: { "in": Encoded, "mask": Mask }, outputs: { "out": "graded" },
        nodes: { "graded": Chosen(source: "in", mask: "mask") })"#;
    let registry = Registry::new(&[&[NodeKind::of::<Chosen>()]]).expect("it is one kind");
    let document = parse("chosen.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
    let (graph, _) = check(&document, &registry, &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(graph.nodes[0].states, [Some(ColorState::Encoded)]);
    let chosen = text.replace("mask: \"mask\"", "mask: \"mask\", state: Scene");
    let document = parse("chosen.ron", &chosen).unwrap_or_else(|errors| panic!("{errors}"));
    let (graph, _) = check(&document, &registry, &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(graph.nodes[0].states, [Some(ColorState::Scene)]);
}

node_kind! {
    /// A kind whose color state a parameter chooses.
    pub struct Chosen {
        /// The state of the result, or that of the source.
        pub state: Kept = Kept::Same;
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "An image."), Input::image("mask", "Another one.")];
    const OUTPUTS: &'static [Output] = &[Output::image("result", OutputState::chosen("state"), "An image.")];
}

choices! {
    /// What the result holds.
    pub enum Kept {
        /// What the source holds.
        Same,
        /// Scene light.
        Scene,
    }
}

impl Node for Chosen {
    fn record(&self, _: &mut Recorder<'_>) {}
}

fn checked(text: &str) -> Graph {
    let registry = Registry::new(&[afterimage_nodes::ALL]).unwrap();
    check(&parse("test.ron", text).unwrap(), &registry, &CheckOptions::default()).unwrap().0
}

#[test]
fn a_node_that_is_switched_off_is_another_structure_and_another_value_is_none() {
    let text = |set: &str| {
        format!(
            r#"Pipeline(
                inputs: {{ "in": Color }},
                nodes: {{ "gain": Exposure(source: "in", stops: 1.0) }},
                set: {{ {set} }},
                outputs: {{ "out": "gain" }},
            )"#
        )
    };
    let [plain, louder, off] = ["", r#""gain.stops": 2.0"#, r#""gain": Off"#].map(|set| checked(&text(set)));
    assert!(plain.has_structure_of(&louder));
    assert!(!plain.has_structure_of(&off) && !off.has_structure_of(&plain));
}

#[test]
fn an_input_tells_whether_its_alpha_is_needed_and_an_output_its_color_state() {
    let text = |options: &str| {
        format!(
            r#"Pipeline(
                inputs: {{ "in": Color{options} }},
                nodes: {{ "gain": Exposure(source: "in") }},
                outputs: {{ "out": "gain" }},
            )"#
        )
    };
    assert!(checked(&text("(needs_alpha: true)")).inputs[0].needs_alpha);
    assert!(!checked(&text("")).inputs[0].needs_alpha);
    assert_eq!(checked(&text("")).outputs[0].state, ColorState::Exposed);
}

/// The codes of the errors of a pipeline.
fn codes(text: &str) -> Vec<&'static str> {
    let registry = Registry::new(&[afterimage_nodes::ALL]).unwrap();
    let checked = parse("test.ron", text).and_then(|document| check(&document, &registry, &CheckOptions::default()));
    checked.err().iter().flat_map(|errors| errors.iter().map(|error| error.code)).collect()
}

#[test]
fn a_name_has_at_most_256_bytes() {
    let named = |bytes: usize| {
        let name = "n".repeat(bytes);
        codes(&format!(
            r#"Pipeline(
                inputs: {{ "in": Color }},
                nodes: {{ "{name}": Exposure(source: "in") }},
                outputs: {{ "out": "{name}" }},
            )"#
        ))
    };
    assert_eq!(named(256), [""; 0]);
    assert!(named(257).contains(&"long-name"), "{:?}", named(257));
}

#[test]
fn images_of_two_color_states_are_not_mixed() {
    let mixed = |bloom: &str| {
        codes(&format!(
            r#"Pipeline(
                inputs: {{ "in": Color }},
                nodes: {{
                    "gain": Exposure(source: "in"),
                    "lit": Composite(base: "gain", bloom: "{bloom}"),
                }},
                outputs: {{ "out": "lit" }},
            )"#
        ))
    };
    assert_eq!(mixed("gain"), [""; 0]);
    assert_eq!(mixed("in"), ["color-conflict"]);
}

#[test]
fn the_name_of_a_parameter_ends_with_what_follows_its_last_dot() {
    let graph = checked(
        r#"Pipeline(
            inputs: { "in": Color },
            nodes: { "gain": Exposure(source: "in") },
            outputs: { "out": "gain" },
        )"#,
    );
    let found = graph.parameter("gain.stops").unwrap();
    assert_eq!(graph.parameter_name(found), "gain.stops");
    let refused = |name: &str| graph.parameter(name).unwrap_err();
    assert!(refused("gain.x.stops").starts_with("no node is called `gain.x`"), "{}", refused("gain.x.stops"));
    assert!(refused("gain.stop").starts_with("`gain` has no parameter `stop`"), "{}", refused("gain.stop"));
}

#[test]
fn only_a_finite_number_in_quotes_is_told_to_lose_them() {
    let told = |value: &str| {
        let text = format!(
            r#"Pipeline(
                inputs: {{ "in": Color }},
                nodes: {{ "gain": Exposure(source: "in", stops: {value}) }},
                outputs: {{ "out": "gain" }},
            )"#
        );
        let registry = Registry::new(&[afterimage_nodes::ALL]).unwrap();
        check(&parse("test.ron", &text).unwrap(), &registry, &CheckOptions::default()).unwrap_err().to_string()
    };
    assert!(told(r#""1.5""#).contains("without quotes"));
    assert!(!told(r#""1e999""#).contains("without quotes") && !told(r#""inf""#).contains("without quotes"));
}
