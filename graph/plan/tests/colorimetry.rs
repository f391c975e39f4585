//! The color states and colorimetry of images, from the host's images to the outputs.

use afterimage_graph::check::{CheckOptions, Facts, Graph, check};
use afterimage_graph::color::{Chromaticities, Colorimetry, Transfer, Xy};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::parse;
use afterimage_graph::image::{ColorState, Format, Signedness};
use afterimage_graph::node::{ColorChange, ImageColor, NodeKind, OutputState, PortType, Registry};
use afterimage_plan::{Options, Plan};
use afterimage_wgsl::SampleMode;

use super::support::{all_formats, built_in, checked, plan_images};

const REC709: Colorimetry = Colorimetry::linear(Chromaticities::REC709);

fn text(input: &str, nodes: &str, outputs: &str) -> String {
    format!(r#"Pipeline(inputs: {{ "in": {input} }}, nodes: {{ {nodes} }}, outputs: {{ {outputs} }})"#)
}

fn planned(graph: &Graph, facts: &[(&str, bool)]) -> Plan {
    let mut given = Facts::default();
    facts.iter().for_each(|(name, holds)| given.set(*name, *holds));
    plan_images(graph, Format::Rgba32Float, given, all_formats(), Options::default())
}

/// The colorimetry of the node `result` of a pipeline.
fn result_of(input: &str, nodes: &str) -> Colorimetry {
    planned(&checked(&text(input, nodes, r#""out": "result""#)), &[]).outputs[0].colorimetry
}

/// A pipeline with a light that is mapped, passes these nodes, and is encoded.
fn display(nodes: &str, encode: &str) -> String {
    format!(r#""mapped": ToneMap(source: "in"), {nodes} "result": Encode({encode})"#)
}

/// The primaries that the result of a node is in.
fn primaries_of(graph: &Graph, node: &str) -> Chromaticities {
    let (index, _) = graph.node(node).expect("the node exists");
    let color = graph.colors().of_node(index)[0].expect("an output needs the node, and it makes an image");
    color.colorimetry.primaries
}

/// The name of a state as the type of an input.
fn input_type(state: ColorState) -> &'static str {
    if state == ColorState::Scene { "Color" } else { state.name() }
}

/// What a kind makes of an image, wired alone.
fn alone(kind: &NodeKind, state: ColorState) -> Option<ImageColor> {
    let port = kind.inputs().iter().find(|port| port.ty == PortType::Image)?;
    if kind.outputs()[0].ty != PortType::Image || kind.inputs().iter().any(|p| !p.optional && p.name != port.name) {
        return None;
    }
    let nodes = format!(r#""result": {}({}: "in")"#, kind.name(), port.name);
    let graph = checked(&text(input_type(state), &nodes, r#""out": "result""#));
    graph.colors().at(graph.outputs[0].source)
}

#[test]
fn every_kind_keeps_the_colorimetry_or_says_what_it_is() {
    let mut tried = 0;
    for kind in afterimage_nodes::ALL {
        let Some(port) = kind.inputs().iter().find(|port| port.ty == PortType::Image) else { continue };
        for state in port.states.iter().copied() {
            let Some(found) = alone(kind, state) else { continue };
            let wanted = match (kind.name(), &kind.outputs()[0].state) {
                ("ToneMap" | "Aces2Output", _) => ImageColor::of(ColorState::DisplayLinear),
                ("Encode", _) => ImageColor { state: ColorState::Encoded, colorimetry: Colorimetry::SRGB },
                ("Exposure", _) => ImageColor::of(ColorState::Exposed),
                ("LogGaussian", _) => ImageColor::of(ColorState::LogLuminance),
                ("ColorKey" | "LumaKey", _) => ImageColor::of(ColorState::Data),
                (_, OutputState::Same(_) | OutputState::Chosen(_)) => ImageColor::of(state),
                (name, other) => panic!("{name} is {other:?} and has no row in this test"),
            };
            assert_eq!(found, wanted, "{} of {}", kind.name(), state.name());
            tried += 1;
        }
    }
    assert!(tried >= 40, "only {tried} pairs of a kind and a state");
}

/// The kinds that change colorimetry with their defaults, or the range of light.
const CHANGING: [&str; 4] = ["Aces2Output", "Eetf", "Encode", "ToneMap"];

#[test]
fn only_a_tone_curve_an_encoding_and_an_adaptation_change_colorimetry() {
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
    for kind in registry.iter() {
        let defaults: Vec<_> = kind.params().iter().map(|param| param.default.clone()).collect();
        let keeps = kind.instantiate(&defaults).color() == ColorChange::Keep;
        assert_eq!(keeps, !CHANGING.contains(&kind.name()), "{}", kind.name());
    }
}

#[test]
fn encode_states_its_transfer_function_and_its_primaries() {
    let of = |parameters: &str| result_of("DisplayLinear", &format!(r#""result": Encode(source: "in", {parameters})"#));
    let spaces = [
        ("Rec709", Chromaticities::REC709),
        ("DisplayP3", Chromaticities::DISPLAY_P3),
        ("Rec2020", Chromaticities::REC2020),
    ];
    for (name, primaries) in spaces {
        let with = |transfer: &str| of(&format!("primaries: {name}, {transfer}"));
        let new = |transfer| Colorimetry::new(primaries, transfer);
        assert_eq!(with("transfer: Srgb"), new(Transfer::Srgb));
        assert_eq!(with("transfer: Linear"), new(Transfer::Linear));
        assert_eq!(with("transfer: Gamma, gamma: 2.4"), new(Transfer::Gamma(2.4.into())));
        assert_eq!(with("transfer: Pq"), new(Transfer::Pq).nits(203.0, 1000.0));
        assert_eq!(with("transfer: Hlg, white_nits: 100.0, peak_nits: 600.0"), new(Transfer::Hlg).nits(100.0, 600.0));
    }
}

#[test]
fn the_colorimetry_passes_the_nodes_after_the_encoding() {
    let nodes = r#"
        "pq": Encode(source: "in", transfer: Pq, primaries: Rec2020),
        "cdl": Cdl(source: "pq", slope: (1.1, 1.0, 1.0)),
        "grain": FilmGrain(source: "cdl", amount: 0.1),
        "result": Dither(source: "grain", bits: 10)"#;
    let wanted = Colorimetry::new(Chromaticities::REC2020, Transfer::Pq).nits(203.0, 1000.0);
    assert_eq!(result_of("DisplayLinear", nodes), wanted);
    assert_eq!(result_of("Encoded", r#""result": Dither(source: "in")"#), Colorimetry::SRGB);
}

#[test]
fn an_adaptation_states_its_white_up_to_the_file() {
    let node = |mode: &str| format!(r#""result": WhiteBalance(source: "in", {mode})"#);
    let adapted = Colorimetry { adopted_white: Some(Xy::D65), ..REC709 };
    assert_eq!(result_of("Color", &node("mode: Temperature, temperature: 3200.0")), adapted);
    assert_eq!(result_of("Color", &node("target: (1.0, 0.9, 0.8)")), REC709);
    // At its neutral temperature the node is skipped and adapts nothing.
    assert_eq!(result_of("Color", &node("mode: Temperature")), REC709);
    let whole = r#""white": WhiteBalance(source: "in", mode: Temperature, temperature: 3200.0),
        "mapped": ToneMap(source: "white"), "result": Encode(source: "mapped")"#;
    assert_eq!(result_of("Exposed", whole).adopted_white, Some(Xy::D65));
}

#[test]
fn a_tone_curve_ends_in_the_primaries_of_the_display() {
    let graded = r#""graded": LiftGammaGain(source: "mapped", gain: (1.1, 1.0, 1.0)),
        "corners": Vignette(source: "graded"),"#;
    for (name, primaries) in [("Rec709", Chromaticities::REC709), ("Rec2020", Chromaticities::REC2020)] {
        let nodes = display(graded, &format!(r#"source: "corners", primaries: {name}"#));
        let graph = checked(&text("Exposed", &nodes, r#""out": "result""#));
        for node in ["mapped", "graded", "corners"] {
            assert_eq!(primaries_of(&graph, node), primaries, "{node}");
        }
    }
    assert_eq!(result_of("Exposed", r#""result": ToneMap(source: "in")"#), REC709);
}

#[test]
fn the_widest_of_several_displays_counts_in_any_order() {
    let encodes = [
        r#""a": Encode(source: "mapped"), "b": Encode(source: "mapped", primaries: Rec2020)"#,
        r#""a": Encode(source: "mapped", primaries: Rec2020), "b": Encode(source: "mapped", primaries: DisplayP3)"#,
    ];
    for encodes in encodes {
        let nodes = format!(r#""mapped": ToneMap(source: "in"), {encodes}"#);
        let graph = checked(&text("Exposed", &nodes, r#""a": "a", "b": "b""#));
        assert_eq!(primaries_of(&graph, "mapped"), Chromaticities::REC2020, "{encodes}");
    }
    // An encoding that no output needs is no display.
    let nodes = r#""mapped": ToneMap(source: "in"), "a": Encode(source: "mapped"),
        "b": Encode(source: "mapped", primaries: Rec2020)"#;
    let graph = checked(&text("Exposed", nodes, r#""a": "a""#));
    assert_eq!(primaries_of(&graph, "mapped"), Chromaticities::REC709);
}

#[test]
fn a_history_carries_the_colorimetry_too() {
    let nodes = r#""mapped": ToneMap(source: "in"),
        "trail": Composite(base: "mapped", bloom: "trail@previous", blend: Mix, strength: 0.5),
        "result": Encode(source: "trail", primaries: DisplayP3)"#;
    let graph = checked(&text("Exposed", nodes, r#""out": "result", "before": "trail@previous""#));
    assert_eq!(primaries_of(&graph, "trail"), Chromaticities::DISPLAY_P3);
    let outputs = planned(&graph, &[]).outputs;
    assert_eq!(outputs[1].colorimetry, Colorimetry::linear(Chromaticities::DISPLAY_P3));
}

#[test]
fn a_skipped_node_changes_no_colorimetry() {
    let nodes = |encode: &str| {
        format!(
            r#""mapped": ToneMap(source: "in"),
            "encoded": Encode(source: "mapped", transfer: Pq, primaries: Rec2020, {encode}),
            "result": Dither(source: "encoded")"#
        )
    };
    let outputs = r#""out": "result""#;
    let graph = checked(&text("Exposed", &nodes(r#"when: "hdr""#), outputs));
    let pq = Colorimetry::new(Chromaticities::REC2020, Transfer::Pq).nits(203.0, 1000.0);
    assert_eq!(planned(&graph, &[("hdr", true)]).outputs[0].colorimetry, pq);
    // Without the encoding the output is light, and no display asks for wide primaries.
    assert_eq!(planned(&graph, &[("hdr", false)]).outputs[0].colorimetry, REC709);
    let mut off = checked(&text("Exposed", &nodes(""), outputs));
    let index = |graph: &Graph, name: &str| graph.node(name).expect("it exists").0;
    for (node, wanted) in [("result", pq), ("mapped", pq), ("encoded", REC709)] {
        let at = index(&off, node);
        off.nodes[at].off = true;
        assert_eq!(planned(&off, &[]).outputs[0].colorimetry, wanted, "without `{node}`");
        off.nodes[at].off = false;
    }
}

#[test]
fn a_black_output_has_the_colorimetry_of_its_state() {
    let mut graph = checked(&text("Color", r#""result": Extract(source: "in")"#, r#""out": "result""#));
    graph.nodes[0].off = true;
    assert_eq!(planned(&graph, &[]).outputs[0].colorimetry, REC709);
}

#[test]
fn both_displays_of_the_hdr_pipeline_are_labeled() {
    let graph = built_in("hdr.ron");
    let plan = planned(&graph, &[]);
    let of = |name: &str| plan.output(Some(name)).expect("the pipeline has the output").colorimetry;
    assert_eq!(of("sdr"), Colorimetry::SRGB);
    assert_eq!(of("hdr"), Colorimetry::new(Chromaticities::REC2020, Transfer::Pq).nits(203.0, 1000.0));
    assert_eq!(primaries_of(&graph, "hdr-mapped"), Chromaticities::REC2020);
    assert_eq!(primaries_of(&graph, "sdr-mapped"), Chromaticities::REC2020, "it is made of the result for HDR");
    // The nodes before the curve run as often as for one output alone.
    let alone = Graph { outputs: graph.outputs[..1].to_vec(), ..graph };
    let calls = |plan: &Plan, node: &str| {
        plan.work().flat_map(|pass| &pass.kernels).filter(|kernel| kernel.node == node).count()
    };
    for shared in ["bins", "meter", "exposed", "bright", "mips", "bloom", "lit"] {
        let (once, both) = (calls(&planned(&alone, &[]), shared), calls(&plan, shared));
        assert!(once >= 1 && once == both, "{shared}: {both} calls for both outputs, {once} for one");
    }
}

#[test]
fn plans_print_the_colorimetry_of_their_outputs() {
    let plan = planned(&built_in("hdr.ron"), &[]);
    let text = plan.to_text();
    let lines = ["  sdr  Encoded: Srgb, Rec709", "  hdr  Encoded: Pq, Rec2020, white at 203 cd/m2, peak at 1000 cd/m2"];
    lines.iter().for_each(|line| assert!(text.lines().any(|found| found == *line), "{line}\n{text}"));
    let json: serde_json::Value = serde_json::from_str(&plan.to_json()).expect("JSON can be read");
    let hdr = &json["outputs"][1]["colorimetry"];
    assert_eq!(hdr["transfer"], "Pq");
    assert_eq!((hdr["white_nits"].as_f64(), hdr["peak_nits"].as_f64()), (Some(203.0), Some(1000.0)));
    assert_eq!(hdr["primaries"]["green"], serde_json::json!({ "x": 0.17, "y": 0.797 }));
    assert_eq!(json["outputs"][0]["colorimetry"]["white_nits"], serde_json::Value::Null);
}

fn errors_of(nodes: &str, outputs: &str) -> Diagnostics {
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
    let document = parse("mix.ron", &text("Color", nodes, outputs)).expect("the text is a pipeline");
    check(&document, &registry, &CheckOptions::default()).expect_err("the mix is an error")
}

#[test]
fn images_of_different_meaning_are_not_mixed() {
    let lines = r#""exposed": Exposure(source: "in", stops: 1.0), "mapped": ToneMap(source: "exposed"),"#;
    let mixes = [
        (r#"base: "exposed", bloom: "in""#, "`base` is `Exposed` in Rec709", "`bloom` is `Scene` in Rec709"),
        (
            r#"base: "mapped", bloom: "exposed""#,
            "`base` is `DisplayLinear` in Rec709",
            "`bloom` is `Exposed` in Rec709",
        ),
    ];
    for (ports, first, second) in mixes {
        let nodes = format!(r#"{lines} "result": Composite({ports})"#);
        let errors = errors_of(&nodes, r#""out": "result", "also": "mapped""#);
        assert!(errors.iter().any(|error| error.code == "color-conflict"), "{errors}");
        let text = errors.to_string();
        assert!(text.contains(first) && text.contains(second), "{text}");
    }
}

#[test]
fn aces_works_for_the_display_after_it() {
    let checked_as = |gamut: &str, encode: &str| {
        let nodes =
            format!(r#""mapped": Aces2Output(source: "in"{gamut}), "result": Encode(source: "mapped"{encode})"#);
        primaries_of(&checked(&text("Exposed", &nodes, r#""out": "result", "light": "mapped""#)), "mapped")
    };
    assert_eq!(checked_as("", ""), Chromaticities::REC709);
    assert_eq!(checked_as("", ", primaries: Rec2020"), Chromaticities::REC2020);
    assert_eq!(checked_as(", gamut: P3", ", primaries: Rec2020"), Chromaticities::DISPLAY_P3);
    assert_eq!(checked_as(", gamut: Rec2020", ""), Chromaticities::REC2020);
}

/// The node before `Encode` where there is no `Eetf` between.
const MAPPED: &str = "mapped";

#[test]
fn light_that_the_display_cannot_show_is_an_error() {
    let errors_of = |nodes: &str| {
        let document = parse("test.ron", &text("Exposed", nodes, r#""out": "result""#)).expect("it is RON");
        let registry = Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
        check(&document, &registry, &CheckOptions::default()).err().map(|errors| errors.to_string())
    };
    let cases = [
        ("peak: 4.926", MAPPED, "transfer: Srgb", Some("where an SDR signal ends")),
        ("peak: 4.926", MAPPED, "transfer: Pq, peak_nits: 500.0", Some("above its peak of 500 cd/m2")),
        (
            "peak: 4.926",
            MAPPED,
            "transfer: Hlg, white_nits: 100.0",
            Some("SDR white is 203 cd/m2 here and 100 cd/m2 there"),
        ),
        ("peak: 4.926", MAPPED, "transfer: Pq", None),
        ("peak: 1.0", MAPPED, "transfer: Pq, white_nits: 100.0", None),
        // A display between the two.
        ("peak: 4.926", "peak_nits: 500.0", "transfer: Pq, peak_nits: 500.0", None),
        ("peak: 4.926", "peak_nits: 600.0", "transfer: Pq, peak_nits: 500.0", Some("`fitted`")),
        ("peak: 9.85", "peak_nits: 500.0", "transfer: Pq, peak_nits: 500.0", Some("`mapped`")),
    ];
    for (aces, eetf, encode, expected) in cases {
        let last = if eetf == MAPPED { MAPPED } else { "fitted" };
        let fitted =
            if eetf == MAPPED { String::new() } else { format!(r#""fitted": Eetf(source: "mapped", {eetf}),"#) };
        let aces = format!(r#""mapped": Aces2Output(source: "in", {aces}),"#);
        let nodes = format!(r#"{aces} {fitted} "result": Encode(source: "{last}", {encode})"#);
        match (errors_of(&nodes), expected) {
            (found, None) => assert_eq!(found, None, "{nodes}"),
            (Some(found), Some(part)) => {
                assert!(found.contains("display-conflict") && found.contains(part), "{nodes}: {found}");
            }
            (None, Some(part)) => panic!("{nodes}: nothing about {part}"),
        }
    }
}

#[test]
fn images_for_two_displays_are_not_mixed() {
    let nodes = r#""exposed": Exposure(source: "in", stops: 1.0),
        "a": ToneMap(source: "exposed"), "b": ToneMap(source: "exposed"),
        "wide": Encode(source: "b", primaries: Rec2020),
        "both": Composite(base: "b", bloom: "a"),
        "result": Encode(source: "a")"#;
    // The mix itself is not encoded, so each of its images is for the display of its own curve.
    let text = errors_of(nodes, r#""a": "result", "b": "wide", "c": "both""#).to_string();
    assert!(text.contains("`base` is `DisplayLinear` in Rec2020"), "{text}");
    assert!(text.contains("`bloom` is `DisplayLinear` in Rec709"), "{text}");
}

#[test]
fn negative_numbers_follow_from_the_state() {
    let wanted = [
        ("Color", Signedness::Extended, SampleMode::SanitizedLight),
        ("Exposed", Signedness::Extended, SampleMode::SanitizedLight),
        ("LogLuminance", Signedness::Signed, SampleMode::SanitizedSigned),
        ("DisplayLinear", Signedness::Unsigned, SampleMode::Sanitized),
        ("Data", Signedness::Signed, SampleMode::SanitizedSigned),
        ("Depth", Signedness::Signed, SampleMode::SanitizedSigned),
        ("Normals", Signedness::Signed, SampleMode::SanitizedSigned),
    ];
    for (input, signedness, mode) in wanted {
        let plan = planned(&checked(&text(input, r#""result": Gaussian(source: "in")"#, r#""out": "result""#)), &[]);
        let image = plan.image(plan.inputs[0].1);
        assert_eq!((image.signedness, image.sample_mode), (signedness, mode), "{input}");
    }
}
