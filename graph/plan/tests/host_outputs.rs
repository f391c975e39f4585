//! What the host gets: outputs that hold linear light, their states where nodes are skipped, plans that differ in
//! numbers alone, and what reports say of the placement.

use afterimage_generators::Recipe;
use afterimage_graph::check::{Facts, Graph};
use afterimage_graph::image::{ColorState, Format, ImageDesc};
use afterimage_plan::{HostImageDesc, HostInputs, Options, Plan, PlanRequest, Requirement, verify};

use super::golden::assert_golden;
use super::support::{FRAME, all_formats, checked, plan_at};

fn request(graph: &Graph, linear: &[&str]) -> PlanRequest<'static> {
    let image = HostImageDesc { desc: ImageDesc::new(FRAME).format(Format::Rgba16Float), finite: true };
    let linear = linear.iter().map(|name| (*name).to_owned()).collect();
    PlanRequest {
        given: HostInputs { linear, ..HostInputs::all(FRAME, &graph.inputs, image) },
        facts: Facts::default(),
        caps: all_formats(),
        options: Options::default(),
        dynamic: Default::default(),
        requirement: &Requirement::typical,
    }
}

fn planned(text: &str, linear: &[&str]) -> Plan {
    let graph = checked(text);
    let plan = afterimage_plan::plan(&graph, &request(&graph, linear)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(verify(&plan), Ok(()));
    plan
}

const ENCODED: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "exposed": Exposure(source: "scene", stops: 1.0),
        "mapped": ToneMap(source: "exposed"),
        "srgb": Encode(source: "mapped"),
        "power": Encode(source: "mapped", transfer: Gamma, gamma: 2.4),
        "pq": Encode(source: "mapped", transfer: Pq),
    },
    outputs: { "srgb": "srgb", "power": "power", "pq": "pq", "light": "mapped" },
)"#;

#[test]
fn outputs_that_hold_linear_light_are_decoded_if_they_are_encoded_for_an_sdr_display() {
    let names = ["srgb", "power", "pq", "light"];
    for held in names {
        let plan = planned(ENCODED, &[held]);
        for output in &plan.outputs {
            let decoded = output.name == held && ["srgb", "power"].contains(&held);
            let encoded = output.name != "light";
            let state = if encoded && !decoded { ColorState::Encoded } else { ColorState::DisplayLinear };
            assert_eq!(output.state, state, "`{}` where `{held}` is linear", output.name);
            let label = plan.image(output.image).label.clone();
            assert_eq!(label.ends_with(".decoded"), decoded, "{label}");
        }
        let functions: Vec<&str> = plan.work().flat_map(|pass| &pass.kernels).map(|kernel| &*kernel.function).collect();
        let decodes =
            ["decode_srgb", "decode_gamma"].map(|function| functions.iter().filter(|f| **f == function).count());
        assert_eq!(decodes, [usize::from(held == "srgb"), usize::from(held == "power")], "{held}: {functions:?}");
    }
    let power = planned(ENCODED, &["power"]);
    let kernel = power.work().flat_map(|pass| &pass.kernels).find(|kernel| &*kernel.function == "decode_gamma");
    assert_eq!(kernel.expect("it is decoded").uniform[..4], 2.4_f32.to_le_bytes());
    assert_golden("decoded.txt", &power.to_text());
}

/// The state is that of the wire; the colors are those of the image that comes.
#[test]
fn an_output_of_a_node_that_is_skipped_has_the_state_of_its_wire() {
    let text = r#"Pipeline(inputs: { "scene": Color }, nodes: { "same": Exposure(source: "scene", stops: 0.0) },
        outputs: { "out": "same", "scene": "scene" })"#;
    let plan = planned(text, &[]);
    assert_eq!(plan.savings.skipped.len(), 1);
    assert_eq!(
        plan.outputs.iter().map(|output| output.state).collect::<Vec<_>>(),
        [ColorState::Exposed, ColorState::Scene]
    );
}

/// Passes write no bytes and no depths, and 32 bits are not shortened.
#[test]
fn an_input_that_is_shown_as_it_is_is_copied_to_floats() {
    let color = checked(r#"Pipeline(inputs: { "seen": Color }, nodes: {}, outputs: { "out": "seen" })"#);
    let depth = checked(r#"Pipeline(inputs: { "seen": Depth }, nodes: {}, outputs: { "out": "seen" })"#);
    for (graph, given, written) in [
        (&color, Format::Rgba8Unorm, Format::Rgba16Float),
        (&color, Format::Rgba16Float, Format::Rgba16Float),
        (&color, Format::Rgba32Float, Format::Rgba32Float),
        (&depth, Format::Depth32Float, Format::R32Float),
        (&depth, Format::R32Float, Format::R32Float),
    ] {
        let image = HostImageDesc { desc: ImageDesc::new(FRAME).format(given), finite: true };
        let given = HostInputs::all(FRAME, &graph.inputs, image);
        let plan = afterimage_plan::plan(graph, &PlanRequest { given, ..request(graph, &[]) });
        let plan = plan.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(plan.image(plan.outputs[0].image).desc.format, written, "{}", plan.to_text());
    }
}

fn exposed(stops: f32, more: &str) -> Plan {
    let node = format!("Exposure(source: \"scene\", stops: {stops:?})");
    planned(
        &format!(
            r#"Pipeline(inputs: {{ "scene": Color }}, nodes: {{ "a": {node} {more} }}, outputs: {{ "out": "a" }})"#
        ),
        &[],
    )
}

#[test]
fn plans_that_differ_in_numbers_alone_are_told_from_others() {
    let (one, other) = (exposed(1.0, ""), exposed(2.0, ""));
    assert!(one != other && one.differs_in_uniforms_only(&other) && one.differs_in_uniforms_only(&one));
    let mut slower = other.clone();
    slower.passes[0].workgroups[0] += 1;
    assert!(!one.differs_in_uniforms_only(&slower));
    let mut longer = other.clone();
    longer.passes[0].uniform.bytes.push(0);
    assert!(!one.differs_in_uniforms_only(&longer));
    assert!(!one.differs_in_uniforms_only(&exposed(1.0, ", \"b\": Exposure(source: \"scene\")").clone_with_label()));
}

trait Labeled {
    fn clone_with_label(&self) -> Self;
}

impl Labeled for Plan {
    /// The plan with another label of its first pass.
    fn clone_with_label(&self) -> Self {
        let mut plan = self.clone();
        plan.passes[0].pass.label = "another".into();
        plan
    }
}

#[test]
fn the_text_says_how_far_the_placement_is_from_the_best() {
    let (mut best, mut others) = (0, 0);
    for seed in 0..60 {
        let graph = Recipe { seed, nodes: 60, histories: 2, off: 5 }.graph();
        let plan = plan_at(&graph, FRAME, Options::default()).expect("the graph can be planned");
        let (placed, bound) = (plan.memory.placed, plan.memory.lower_bound);
        let text = plan.to_text();
        if placed == bound {
            best += 1;
            assert!(text.contains("the placement is the best there is for this order"), "{text}");
        } else {
            others += 1;
            let share = (placed as f64 / bound as f64 - 1.0) * 100.0;
            assert!(text.contains(&format!("within {share:.2} % of the best")), "{share}: {text}");
        }
    }
    assert!(best > 30 && others > 0, "{best} are the best, {others} are not");
}
