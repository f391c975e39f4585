//! What images mean along the wires: displays against them, colorimetry along them, and mixes and displays that do not
//! fit; and what else a graph tells of itself.

use afterimage_graph::check::{CheckOptions, FactKind, Graph, ParameterId, Source, check};
use afterimage_graph::color::{Chromaticities, Colorimetry, Decimal, Transfer, Xy};
use afterimage_graph::diagnostic::{Diagnostic, Diagnostics, Severity};
use afterimage_graph::document::parse;
use afterimage_graph::node::{CAMERA, HostBlock, Registry};
use afterimage_graph::prelude::*;

choices! {
    /// What a node does to colors.
    pub enum Deed {
        /// Nothing.
        Keep,
        /// Light for the display after it.
        Show,
        /// Light for Display P3.
        ShowP3,
        /// sRGB.
        Srgb,
        /// sRGB in Display P3.
        P3,
        /// PQ in Rec.2020.
        Pq,
        /// HLG with a white of its own.
        Hlg,
        /// Fits a brighter display.
        Refit,
        /// Adapts to a white.
        Adapt,
    }
}

node_kind! {
    /// Does one thing to colors.
    pub struct Turn {
        /// What it does.
        pub deed: Deed = Deed::Keep;
        /// Whether it can show SDR alone.
        pub dim: bool = false;
    }

    const INPUTS: &'static [Input] = &[SOURCE];
    const OUTPUTS: &'static [Output] = &[Output::image("result", OutputState::same("source"), "The picture.")];
}

node_kind! {
    /// Makes exposed light, by a mask.
    pub struct Made {}

    const INPUTS: &'static [Input] = &[Input::image("mask", "Where."), SOURCE];
    const OUTPUTS: &'static [Output] = &[
        Output::image("result", OutputState::Always(ColorState::Exposed), "The picture."),
        Output::image("where", OutputState::same("mask"), "Where."),
        Output::new("amount", PortType::Value, OutputState::Nothing, "How much."),
    ];
}

node_kind! {
    /// Adds two images of one state.
    pub struct Mix {}

    const INPUTS: &'static [Input] = &[
        Input::image("one", "A picture.").accepts(&[ColorState::Scene, ColorState::Exposed]),
        Input::image("two", "Another.").accepts(&[ColorState::Scene, ColorState::Exposed]),
        Input::image("free", "Whatever.").optional(),
    ];
    const OUTPUTS: &'static [Output] = &[Output::image("result", OutputState::same("one"), "The sum.")];
}

node_kind! {
    /// Reads a camera.
    pub struct Seen {}

    const INPUTS: &'static [Input] = &[SOURCE, Input::block("eye", &CAMERA, "The camera.")];
    const OUTPUTS: &'static [Output] = &[Output::image("result", OutputState::same("source"), "The picture.")];
}

node_kind! {
    /// Reads another block, and a volume of fog.
    pub struct Foggy {}

    const INPUTS: &'static [Input] = &[
        SOURCE,
        Input::block("fog", &FOG, "The fog."),
        Input::new("volume", PortType::Volume, "Light.").content("scattering").optional(),
    ];
    const OUTPUTS: &'static [Output] = &[Output::image("result", OutputState::same("source"), "The picture.")];
}

static FOG: HostBlock = HostBlock { name: "Fog", doc: "Fog.", fields: CAMERA.fields };
const WHITE: Xy = Xy::new(0.34, 0.35);
const OWN: Xy = Xy::new(0.30, 0.31);
const SOURCE: Input = Input::image("source", "The picture.");
const PQ: Colorimetry = Colorimetry::new(Chromaticities::REC2020, Transfer::Pq);
const P3: Colorimetry = Colorimetry::new(Chromaticities::DISPLAY_P3, Transfer::Srgb);

fn hlg() -> Colorimetry {
    Colorimetry { adopted_white: Some(OWN), ..Colorimetry::new(Chromaticities::REC2020, Transfer::Hlg) }
}

impl Node for Turn {
    fn color(&self) -> ColorChange {
        match self.deed {
            Deed::Keep => ColorChange::Keep,
            Deed::Show => ColorChange::ToDisplay,
            Deed::ShowP3 => ColorChange::Display(Chromaticities::DISPLAY_P3),
            Deed::Srgb => ColorChange::Encode(Colorimetry::SRGB),
            Deed::P3 => ColorChange::Encode(P3),
            Deed::Pq => ColorChange::Encode(PQ.nits(203.0, 1000.0)),
            Deed::Hlg => ColorChange::Encode(hlg()),
            Deed::Refit => ColorChange::Refit { white_nits: Decimal::new(100.0), peak_nits: Decimal::new(4000.0) },
            Deed::Adapt => ColorChange::Adapt(WHITE),
        }
    }

    fn verify_display(&self, display: &Colorimetry) -> Result<(), String> {
        if self.dim && display.is_hdr() { Err("it is too bright".into()) } else { Ok(()) }
    }

    fn record(&self, _: &mut Recorder<'_>) {}
}

impl Node for Made {
    fn record(&self, _: &mut Recorder<'_>) {}
}

impl Node for Mix {
    fn record(&self, _: &mut Recorder<'_>) {}
}

impl Node for Seen {
    fn record(&self, _: &mut Recorder<'_>) {}
}

impl Node for Foggy {
    fn record(&self, _: &mut Recorder<'_>) {}
}

const KINDS: &[NodeKind] = &[
    NodeKind::of::<Turn>(),
    NodeKind::of::<Made>(),
    NodeKind::of::<Mix>(),
    NodeKind::of::<Seen>(),
    NodeKind::of::<Foggy>(),
];

fn checked(text: &str) -> Result<Graph, Diagnostics> {
    let registry = Registry::new(&[KINDS]).expect("the kinds have different names");
    Ok(check(&parse("colors.ron", text)?, &registry, &CheckOptions::default())?.0)
}

/// A pipeline of these nodes from an image, whose outputs are the nodes that are named.
fn text(nodes: &str, outputs: &[&str]) -> String {
    let outputs: String = outputs.iter().map(|name| format!("\"{name}\": \"{name}\", ")).collect();
    format!(r#"Pipeline(inputs: {{ "in": Color, "mask": Mask }}, nodes: {{ {nodes} }}, outputs: {{ {outputs} }})"#)
}

fn graph(nodes: &str, outputs: &[&str]) -> Graph {
    checked(&text(nodes, outputs)).unwrap_or_else(|errors| panic!("{errors}"))
}

fn at(graph: &Graph, node: &str) -> usize {
    graph.node(node).expect("it exists").0
}

fn of(graph: &Graph, node: &str) -> Colorimetry {
    graph.colors().of_node(at(graph, node))[0].expect("it is a picture").colorimetry
}

#[test]
fn a_node_that_shows_takes_the_primaries_of_the_encoding_after_it() {
    let linear = Colorimetry::linear;
    let shown = r#""shown": Turn(source: "in", deed: Show), "kept": Turn(source: "shown"), "#;
    let table: [(&str, &[&str], Chromaticities); 6] = [
        ("", &["shown"], Chromaticities::REC709),
        (r#""a": Turn(source: "kept", deed: P3)"#, &["a"], Chromaticities::DISPLAY_P3),
        (
            r#""a": Turn(source: "kept", deed: P3), "b": Turn(source: "kept", deed: Pq)"#,
            &["a", "b"],
            Chromaticities::REC2020,
        ),
        (
            r#""a": Turn(source: "kept", deed: Pq), "b": Turn(source: "kept", deed: Srgb)"#,
            &["a", "b"],
            Chromaticities::REC2020,
        ),
        (
            r#""a": Turn(source: "kept", deed: ShowP3), "b": Turn(source: "a", deed: Pq)"#,
            &["b"],
            Chromaticities::REC709,
        ),
        (
            r#""a": Turn(source: "kept", deed: Adapt), "b": Turn(source: "a", deed: Pq)"#,
            &["b"],
            Chromaticities::REC2020,
        ),
    ];
    for (more, outputs, primaries) in table {
        let graph = graph(&format!("{shown}{more}"), outputs);
        assert_eq!(of(&graph, "shown"), linear(primaries), "{more}");
        if outputs != ["shown"] {
            assert_eq!(of(&graph, "kept"), linear(primaries), "{more}");
        }
    }
    let graph = graph(
        &format!(r#"{shown} "a": Turn(source: "kept", deed: P3), "idle": Turn(source: "kept", deed: Pq)"#),
        &["a"],
    );
    assert_eq!(of(&graph, "shown").primaries, Chromaticities::DISPLAY_P3, "what nobody needs does not count");
    assert_eq!(graph.colors().of_node(at(&graph, "idle")), [None]);
    assert_eq!(graph.colors().displays_after(at(&graph, "kept")).iter().collect::<Vec<_>>(), [&P3]);
    assert!(graph.colors().displays_after(at(&graph, "a")).is_empty());
}

#[test]
fn what_is_fitted_to_a_display_was_made_for_another() {
    let nodes = r#""shown": Turn(source: "in", deed: Show), "fit": Turn(source: "shown", deed: Refit),
        "out": Turn(source: "fit", deed: Pq)"#;
    let graph = graph(nodes, &["out"]);
    let colors = graph.colors();
    let after = |node: &str| colors.displays_after(at(&graph, node)).iter().copied().collect::<Vec<_>>();
    assert_eq!(after("fit"), [PQ.nits(203.0, 1000.0)]);
    assert_eq!(after("shown"), [PQ.nits(100.0, 4000.0)]);
    assert_eq!(of(&graph, "fit"), Colorimetry::linear(Chromaticities::REC2020));
    assert_eq!(of(&graph, "out"), PQ.nits(203.0, 1000.0));
}

#[test]
fn an_adopted_white_is_kept_unless_the_encoding_states_one() {
    let nodes = |deed: &str| {
        format!(
            r#""white": Turn(source: "in", deed: Adapt), "out": Turn(source: "white", deed: {deed}),
               "k": Turn(source: "out")"#
        )
    };
    for (deed, white) in [("Srgb", WHITE), ("Hlg", OWN), ("Show", WHITE), ("ShowP3", WHITE), ("Keep", WHITE)] {
        let graph = graph(&nodes(deed), &["k"]);
        assert_eq!(of(&graph, "k").adopted_white, Some(white), "{deed}");
    }
    assert_eq!(of(&graph(&nodes("ShowP3"), &["k"]), "k").primaries, Chromaticities::DISPLAY_P3);
}

/// A node whose state is always one keeps the colors of the first picture that it gets, and data has none.
#[test]
fn data_gives_no_colors() {
    let nodes = r#""p3": Turn(source: "in", deed: ShowP3), "made": Made(mask: "mask", source: "p3"),
        "where": Turn(source: "made.where", deed: ShowP3)"#;
    let graph = graph(nodes, &["made", "where"]);
    let [Some(made), Some(mask), None] = graph.colors().of_node(at(&graph, "made"))[..] else { panic!("{graph:?}") };
    assert_eq!((made.state, made.colorimetry), (ColorState::Exposed, Colorimetry::linear(Chromaticities::DISPLAY_P3)));
    assert_eq!(mask.state, ColorState::Data);
    let data = graph.colors().of_node(at(&graph, "where"))[0].expect("it is an image");
    assert_eq!(data, ImageColor::of(ColorState::Data), "nothing is done to data");
    let input = graph.colors().at(Source::Input(1)).expect("it is an image");
    assert_eq!(input.state, ColorState::Data);
    let output = Source::Node { node: at(&graph, "made"), output: 2, previous: 0 };
    assert_eq!((graph.colors().at(output), graph.port_type(output)), (None, PortType::Value));
}

#[test]
fn colors_follow_wires_of_earlier_frames_and_replaced_ones() {
    let nodes = r#""p3": Turn(source: "in", deed: ShowP3), "trail": Mix(one: "p3", two: "trail@previous"),
        "late": Turn(source: "trail@previous:2")"#;
    let graph = graph(nodes, &["trail", "late"]);
    for node in ["trail", "late"] {
        assert_eq!(of(&graph, node).primaries, Chromaticities::DISPLAY_P3, "{node}");
    }
    // Where a node is off, its source takes its place.
    let replaced = |source| match source {
        Source::Node { node: 0, .. } => Some(Source::Input(0)),
        other => Some(other),
    };
    let colors = graph.colors_along(&replaced);
    assert_eq!(colors.of_node(0), [None]);
    let late = colors.of_node(at(&graph, "late"))[0].expect("it is a picture");
    assert_eq!(late.colorimetry.primaries, Chromaticities::REC709);
    let black = graph.colors_along(&|_| None);
    assert!(black.of_node(at(&graph, "late")).iter().all(Option::is_none));
}

fn told(text: &str) -> Vec<(&'static str, String, Vec<String>, String)> {
    let errors = checked(text).expect_err("it is wrong");
    let labels = |one: &Diagnostic| one.labels.iter().map(|label| label.text.clone()).collect();
    let wrong = errors.iter().filter(|one| one.severity == Severity::Error);
    wrong.map(|one| (one.code, one.message.clone(), labels(one), one.help.clone().unwrap_or_default())).collect()
}

#[test]
fn images_that_differ_in_color_are_not_mixed() {
    let mixed = |one: &str, two: &str| {
        let more = r#""p3": Turn(source: "in", deed: ShowP3), "e": Made(mask: "mask", source: "in"),
            "pq": Turn(source: "in", deed: Pq), "#;
        text(&format!(r#"{more}"m": Mix(one: "{one}", two: "{two}", free: "pq")"#), &["m"])
    };
    for (one, two) in [("in", "in"), ("p3", "p3"), ("e", "e"), ("pq", "pq")] {
        assert!(checked(&mixed(one, two)).is_ok(), "{one} {two}");
    }
    let help = "mix the images where both have the same color state, for one display";
    for (one, two, first, second) in [
        ("in", "p3", "`one` is `Scene` in Rec709", "`two` is `Scene` in DisplayP3"),
        ("in", "e", "`one` is `Scene` in Rec709", "`two` is `Exposed` in Rec709"),
        ("p3", "pq", "`one` is `Scene` in DisplayP3", "`two` is `Scene` by Pq in Rec2020"),
    ] {
        let found = told(&mixed(one, two));
        let message = "`m` mixes `one` and `two`, which differ in color".to_owned();
        let labels = vec![second.to_owned(), first.to_owned()];
        assert_eq!(found, [("color-conflict", message, labels, help.to_owned())], "{one} {two}");
    }
}

#[test]
fn a_node_that_does_not_suit_the_display_after_it_is_named() {
    let nodes = |deed: &str| {
        format!(
            r#""dim": Turn(source: "in", deed: Show, dim: true), "k": Turn(source: "dim"),
               "out": Turn(source: "k", deed: {deed})"#
        )
    };
    assert!(checked(&text(&nodes("P3"), &["out"])).is_ok());
    let found = told(&text(&nodes("Pq"), &["out"]));
    let message = "`dim` does not suit the display after it: it is too bright".to_owned();
    let help = "make this node and the encoding after it for one display".to_owned();
    assert_eq!(found, [("display-conflict", message, vec![String::new()], help)]);
}

#[test]
fn blocks_and_volumes_fit_ports_of_their_type_alone() {
    let pipeline = |inputs: &str, node: &str| {
        format!(r#"Pipeline(inputs: {{ "in": Color, {inputs} }}, nodes: {{ "a": {node} }}, outputs: {{ "a": "a" }})"#)
    };
    assert!(checked(&pipeline(r#""eye": Camera"#, r#"Seen(source: "in", eye: "eye")"#)).is_ok());
    let (code, message, labels, help) = told(&pipeline(r#""eye": Fog"#, r#"Seen(source: "in", eye: "eye")"#)).remove(0);
    assert_eq!(
        (code, message.as_str()),
        ("content-conflict", "`eye` of `Seen` accepts a Camera, but the input `eye` is a Fog")
    );
    assert_eq!(labels, ["this accepts a Camera", "this gives a Fog"]);
    assert_eq!(help, "declare an input of the type `Camera`");
    let (code, message, ..) = told(&pipeline(r#""eye": Color"#, r#"Seen(source: "in", eye: "eye")"#)).remove(0);
    assert_eq!(
        (code, message.contains("accepts a Block, but the input `eye` is an Image")),
        ("type-conflict", true),
        "{message}"
    );
    let foggy = r#"Foggy(source: "in", fog: "fog", volume: "light")"#;
    let (code, message, labels, help) = told(&pipeline(r#""fog": Fog, "light": Data(volume: true)"#, foggy)).remove(0);
    assert_eq!(code, "content-conflict");
    assert_eq!(message, "`volume` of `Foggy` accepts `scattering`, but the input `light` is a volume of the host");
    assert_eq!(labels, ["this accepts `scattering`", "this gives a volume"]);
    assert_eq!(help, "wire it to a node that gives `scattering`");
    for (ty, help) in [("Fogg", "did you mean `Fog`?"), ("Zyx", "`Fog` and `Camera`")] {
        let (code, message, _, found) = told(&pipeline(&format!(r#""fog": {ty}"#), foggy)).remove(0);
        assert_eq!((code, message), ("unknown-input-type", format!("no input type is called `{ty}`")));
        assert!(found.ends_with(help), "{found}");
    }
}

#[test]
fn inputs_have_the_type_and_the_channels_that_the_file_declares() {
    let text = r#"Pipeline(inputs: { "in": Color, "n": Normals(optional: true), "m": Motion(optional: true),
        "s": Color(optional: true, multisampled: true), "v": Data(optional: true, volume: true), "eye": Camera },
        nodes: { "a": Seen(source: "in", eye: "eye") }, outputs: { "a": "a" })"#;
    let graph = checked(text).unwrap_or_else(|errors| panic!("{errors}"));
    use PortType::{Block, Image, Multisampled, Volume};
    let types: Vec<PortType> = graph.inputs.iter().map(|input| input.port_type()).collect();
    assert_eq!(types, [Image, Image, Image, Multisampled, Volume, Block]);
    assert_eq!(graph.inputs.iter().map(|input| input.min_channels).collect::<Vec<_>>(), [1, 3, 2, 1, 1, 1]);
    assert_eq!(graph.inputs[5].block.map(|block| block.name), Some("Camera"));
    assert!((0..6).all(|input| graph.port_type(Source::Input(input)) == types[input]));
}

#[test]
fn a_graph_lists_its_parameters_and_facts() {
    let graph = graph(
        r#""a": Turn(source: "in", deed: P3, when: "dark and lux < 3"), "m": Mix(one: "a", two: "a", when: "dark"),
           "b": Turn(source: "m", dim: true)"#,
        &["b"],
    );
    let names: Vec<String> = graph.parameters().map(|parameter| graph.parameter_name(parameter)).collect();
    assert_eq!(names, ["a.deed", "a.dim", "b.deed", "b.dim"]);
    assert_eq!(graph.parameter("b.dim"), Ok(ParameterId { node: 2, index: 1 }));
    let values: Vec<String> = graph.parameters().map(|parameter| graph.value(parameter).to_string()).collect();
    assert_eq!(values, ["P3", "false", "Keep", "true"]);
    assert!(
        graph
            .parameters()
            .all(|parameter| graph.parameter_name(parameter).ends_with(&*graph.declaration(parameter).name))
    );
    assert_eq!(graph.facts(), [("dark".to_owned(), FactKind::Flag), ("lux".to_owned(), FactKind::Number)]);
    assert_eq!(graph.parameter("c.dim").unwrap_err(), "no node is called `c`: did you mean `a`?");
    assert_eq!(graph.parameter("b.dimm").unwrap_err(), "`b` has no parameter `dimm`: did you mean `dim`?");
    // Names of other things are told as such.
    assert_eq!(graph.parameter("b").unwrap_err(), "`b` is a node; it has `b.deed` and `b.dim`");
    assert_eq!(graph.parameter("in.dim").unwrap_err(), "no node is called `in`: that is an image input");
    assert_eq!(graph.parameter("lux").unwrap_err(), "no node is called `lux`: that is a fact");
}

/// All that a host must know of a graph but the values of parameters is its structure.
#[test]
fn another_wire_name_condition_format_or_label_is_another_structure() {
    let base = r#"Pipeline(inputs: { "in": Color, "mask": Mask }, outputs: { "out": "b" },
        nodes: { "a": Turn(source: "in"), "b": Mix(one: "a", two: "in") })"#;
    let of = |text: &str| checked(text).unwrap_or_else(|errors| panic!("{errors}\n{text}"));
    let same = |text: &str| {
        let (one, other) = (of(base), of(text));
        assert_eq!(one.has_structure_of(&other), other.has_structure_of(&one), "{text}");
        one.has_structure_of(&other)
    };
    assert!(same(base) && same(&base.replace("Turn(source: \"in\")", "Turn(source: \"in\", dim: true)")));
    for (from, to) in [
        ("\"a\": Turn(source: \"in\")", "\"a\": Turn(source: \"in\", when: \"dark\")"),
        ("\"a\": Turn(source: \"in\")", "\"a\": Turn(source: \"in\", format: R16Float)"),
        ("\"a\": Turn(source: \"in\")", "\"a\": Turn(source: \"in\", bake: 33)"),
        ("\"a\": Turn(source: \"in\")", "\"a\": Turn(source: \"in\", label: \"first\")"),
        ("two: \"in\"", "two: \"a\""),
        ("two: \"in\"", "two: \"a@previous\""),
        ("\"mask\": Mask", "\"mask\": Mask(optional: true)"),
        ("\"mask\": Mask", "\"mask\": Depth, \"more\": Mask"),
        ("\"in\": Color", "\"in\": Color(scale: 2.0)"),
        ("{ \"out\": \"b\" }", "{ \"out\": \"a\" }"),
        ("{ \"out\": \"b\" }", "{ \"shown\": \"b\" }"),
        ("{ \"out\": \"b\" }", "{ \"out\": \"b\" }, set: { \"a\": Off }"),
        ("\"b\": Mix(one: \"a\", two: \"in\")", "\"b\": Mix(one: \"a\", two: \"in\"), \"c\": Turn(source: \"b\")"),
    ] {
        let text = base.replace(from, to);
        assert!(text != base && !same(&text), "{to}");
    }
}
