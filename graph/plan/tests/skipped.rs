//! Nodes that a plan skips: disabled ones, identities at their values, and all that only feeds those.

use std::sync::Arc;

use afterimage_graph::check::{Facts, Loader, NoFiles};
use afterimage_graph::image::Format;
use afterimage_plan::{Options, Plan, When};

use super::support::{all_formats, built_in, checked, checked_with, plan_images};

fn planned(graph: &afterimage_graph::check::Graph, facts: &[(&str, bool)]) -> Plan {
    let mut given = Facts::default();
    facts.iter().for_each(|(name, holds)| given.set(*name, *holds));
    let options = Options { row_downsample: When::Never, ..Options::default() };
    plan_images(graph, Format::Rgba32Float, given, all_formats(), options)
}

/// The nodes of all passes.
fn running(plan: &Plan) -> Vec<&str> {
    plan.work().flat_map(|pass| &pass.nodes).map(String::as_str).collect()
}

const GLOW: [&str; 5] = ["glowing", "mips", "soft", "bloom", "lit"];

#[test]
fn caracal_without_emissive_surfaces_has_no_pass_for_its_glow() {
    let graph = built_in("caracal.ron");
    let lit = planned(&graph, &[("emissive", true)]);
    assert!(GLOW.iter().all(|node| running(&lit).contains(node)), "{:?}", running(&lit));
    let dark = planned(&graph, &[("emissive", false)]);
    assert!(!running(&dark).iter().any(|node| GLOW.contains(node)), "{:?}", running(&dark));
    let passes = (0..dark.passes.len()).filter(|pass| !dark.runs_on_change(*pass)).count();
    assert_eq!(passes, 1, "exposure, curve and encoding are one pass: {:?}", running(&dark));
    let glowing =
        dark.savings.skipped.iter().find(|skipped| skipped.node == "glowing").expect("the plan lists the node");
    assert!(glowing.why.contains("emissive"), "{}", glowing.why);
    assert!(dark.memory.placed < lit.memory.placed / 10, "{} of {} bytes", dark.memory.placed, lit.memory.placed);
}

#[test]
fn night_vision_runs_at_night_and_not_at_noon() {
    assert!(!running(&planned(&built_in("tsushima.ron"), &[])).contains(&"seen"));
    assert!(running(&planned(&built_in("tsushima-night.ron"), &[])).contains(&"seen"));
}

#[test]
fn neutral_grading_of_a_pipeline_is_skipped_and_listed() {
    let plan = planned(&built_in("tsushima.ron"), &[]);
    for node in ["seen", "white", "graded", "look", "grain"] {
        assert!(plan.savings.skipped.iter().any(|skipped| skipped.node == node), "`{node}` is at its neutral values");
        assert!(!running(&plan).contains(&node));
    }
}

/// The skipped nodes of a pipeline from `scene` to `result`, and its number of passes.
fn skipped(nodes: &str) -> (Vec<String>, usize) {
    let text =
        format!(r#"Pipeline(inputs: {{ "scene": Color }}, nodes: {{ {nodes} }}, outputs: {{ "out": "result" }})"#);
    let plan = planned(&checked(&text), &[]);
    assert!(plan.work().all(|pass| pass.kind.is_drawable()));
    (plan.savings.skipped.iter().map(|skipped| skipped.node.clone()).collect(), plan.passes.len())
}

#[test]
fn an_identity_is_skipped_with_all_that_only_feeds_it() {
    let chain = |strength: &str| {
        format!(
            r#""bright": Extract(source: "scene"),
            "mips": Downsample(source: "bright", levels: 3),
            "bloom": Upsample(source: "mips"),
            "lit": Composite(base: "scene", bloom: "bloom", strength: {strength}),
            "result": Vignette(source: "lit")"#
        )
    };
    let (mut nodes, passes) = skipped(&chain("0.0"));
    nodes.sort();
    assert_eq!((nodes, passes), (["bloom", "bright", "lit", "mips"].map(String::from).to_vec(), 1));
    assert_eq!(skipped(&chain("0.5")), (Vec::new(), 7));
    let blur = r#""blur": Gaussian(source: "scene", sigma: 0.2), "result": Vignette(source: "blur")"#;
    assert_eq!(skipped(blur), (vec!["blur".into()], 1));
}

#[test]
fn a_pyramid_of_one_level_needs_no_pass_to_join_it() {
    let nodes = |levels: u32, spread: f32| {
        format!(
            r#""mips": Downsample(source: "scene", levels: {levels}),
            "bloom": Upsample(source: "mips", spread: {spread}),
            "result": Vignette(source: "bloom")"#
        )
    };
    // The vignette reads a pixel of the last pass before it and becomes a part of it.
    // Before it is the sanitized copy that a filtered read of a host image needs.
    assert_eq!(skipped(&nodes(1, 0.7)).1, 2);
    assert_eq!(skipped(&nodes(4, 0.7)).1, 1 + 4 + 3);
    assert!(skipped(&nodes(4, 0.0)).1 < 1 + 4 + 3, "the finest level alone is not joined with any");
}

/// Whether the plan skips one node between an image of the state and a node that always runs.
fn is_skipped(state: &str, node: &str, loader: &dyn Loader) -> bool {
    let node = node.replacen('(', "(source: \"in\", ", 1);
    let is_display = state == "DisplayLinear" || state == "Encoded";
    let next = if is_display { "Brightness" } else { "Vignette" };
    let text = format!(
        r#"Pipeline(
            inputs: {{ "in": {state} }},
            nodes: {{ "mid": {node}, "out": {next}(source: "mid", amount: 0.5) }},
            outputs: {{ "out": "out" }},
        )"#
    );
    let plan = planned(&checked_with("test.ron", &text, loader), &[]);
    assert!(running(&plan).contains(&"out"));
    !running(&plan).contains(&"mid")
}

#[test]
fn nodes_with_neutral_parameters_are_skipped_and_others_are_not() {
    let neutral = [
        ("Color", "Exposure(stops: 0.0)"),
        ("Exposed", "WhiteBalance()"),
        ("Exposed", "WhiteBalance(target: (0.7, 0.7, 0.7))"),
        ("Exposed", "WhiteBalance(target: (0.0, 0.00001, 0.0))"),
        ("Exposed", "WhiteBalance(mode: Temperature)"),
        ("DisplayLinear", "LiftGammaGain()"),
        ("DisplayLinear", "Cdl()"),
        ("DisplayLinear", "Saturation()"),
        ("DisplayLinear", "Contrast()"),
        ("DisplayLinear", "Brightness()"),
        ("DisplayLinear", "ColorBalance()"),
        ("DisplayLinear", "FilmGrain(amount: 0.0)"),
        ("DisplayLinear", "ColorLut(strength: 0.0)"),
        ("DisplayLinear", "ColorLut()"),
        ("Exposed", "HueCurves()"),
        ("DisplayLinear", "ChannelMixer(red: (1.0, 0.0, 0.0))"),
        ("DisplayLinear", "SplitToning(shadow_amount: 0.0, highlight_amount: 0.0)"),
        ("DisplayLinear", "Letterbox(amount: 0.0, color: (1.0, 0.0, 0.0))"),
        ("Exposed", "Transform()"),
    ];
    for (state, node) in neutral {
        assert!(is_skipped(state, node, &NoFiles), "{node}");
    }
    let active = [
        ("Color", "Exposure(stops: 0.001)"),
        ("Exposed", "WhiteBalance(target: (0.7, 0.7, 0.7), keep_luminance: false)"),
        ("Exposed", "WhiteBalance(mode: Temperature, temperature: 6504.0)"),
        ("Exposed", "WhiteBalance(mode: Temperature, tint: 0.001)"),
        ("DisplayLinear", "LiftGammaGain(gamma: (1.0, 1.0, 1.01))"),
        ("DisplayLinear", "Cdl(saturation: 0.99)"),
        ("DisplayLinear", "Saturation(amount: 0.0)"),
        ("DisplayLinear", "Contrast(amount: 1.01)"),
        ("DisplayLinear", "ColorBalance(midtones: (0.0, 0.0, 0.01))"),
        ("Exposed", "HueCurves(lightness_blue: 0.01)"),
        ("DisplayLinear", "SplitToning(shadow_amount: 0.0)"),
        ("Exposed", "Transform(crop: (0.0, 0.0, 0.0, 0.1))"),
        ("DisplayLinear", "Letterbox()"),
    ];
    for (state, node) in active {
        assert!(!is_skipped(state, node, &NoFiles), "{node}");
    }
}

/// One file in memory, whatever its name.
struct OneFile(&'static str);

impl Loader for OneFile {
    fn load(&self, _: &str) -> Result<Arc<[u8]>, String> {
        Ok(self.0.as_bytes().into())
    }
}

/// It limits colors to its domain.
#[test]
fn a_table_that_changes_nothing_within_its_domain_is_not_skipped() {
    for table in [
        "LUT_1D_SIZE 2\nDOMAIN_MIN -1 -1 -1\n-1 -1 -1\n1 1 1\n",
        "LUT_1D_SIZE 3\n0 0 0\n0.50001 0.5 0.5\n1 1 1\n",
        "LUT_1D_SIZE 2\n0 0 0\n1 1 1\n",
    ] {
        assert!(!is_skipped("Encoded", "ColorLut(file: \"a.cube\")", &OneFile(table)), "{table}");
    }
}

/// A pass for the next frame runs only where the values of its reader make use of it.
#[test]
fn what_no_pass_reads_of_the_frame_before_is_not_made() {
    let plan = |fireflies: &str| {
        let text = format!(
            r#"Pipeline(
                inputs: {{ "scene": Color }},
                nodes: {{
                    "result": Extract(source: "scene", before: "result.peaks@previous", fireflies: {fireflies}),
                }},
                outputs: {{ "out": "result" }},
            )"#
        );
        planned(&checked(&text), &[])
    };
    let has_peaks = |plan: &Plan| plan.work().any(|pass| pass.label.contains("extract_peaks"));
    let (limit, keep) = (plan("Limit"), plan("Keep"));
    assert!(has_peaks(&limit) && limit.savings.skipped.is_empty(), "{:?}", limit.savings.skipped);
    assert!(!has_peaks(&keep) && keep.passes.len() == 1, "{}", keep.to_text());
    let skipped: Vec<&str> = keep.savings.skipped.iter().map(|skipped| skipped.node.as_str()).collect();
    assert_eq!(skipped, ["result.peaks@previous"], "{}", keep.to_text());
    assert!(keep.memory.kept < limit.memory.kept, "{} and {} bytes", keep.memory.kept, limit.memory.kept);
}

/// A node whose reader reads it only at other values has no pass, and a chain of memories is dropped as a whole.
#[test]
fn what_only_feeds_an_unread_input_is_skipped() {
    let plan = |fireflies: &str| {
        let text = format!(
            r#"Pipeline(
                inputs: {{ "scene": Color }},
                nodes: {{
                    "soft": Gaussian(source: "scene", sigma: 2.0),
                    "older": Gaussian(source: "soft@previous", sigma: 2.0),
                    "result": Extract(source: "scene", before: "older", fireflies: {fireflies}),
                }},
                outputs: {{ "out": "result" }},
            )"#
        );
        planned(&checked(&text), &[])
    };
    assert_eq!(running(&plan("Keep")), ["result"]);
    let (skipped, read) = (plan("Keep").savings.skipped, plan("Limit"));
    let names: Vec<&str> = skipped.iter().map(|skipped| skipped.node.as_str()).collect();
    assert_eq!(names, ["older", "soft", "soft.result@previous"]);
    assert!(["older", "soft", "result"].iter().all(|node| running(&read).contains(node)), "{}", read.to_text());
}
