//! Dynamic parameters: their uniforms follow new values without a new plan.

use std::collections::{BTreeMap, BTreeSet};

use afterimage_graph::check::{CheckOptions, Facts, Graph, ParameterId, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::Registry;
use afterimage_graph::prelude::*;
use afterimage_graph::value::Param;
use afterimage_plan::{HostImageDesc, HostInputs, NeedsPlan, Options, PlanCache, PlanRequest, Planned, Requirement};

use super::support::{FRAME, all_formats, built_in, checked};

/// The plan of a graph in which these parameters are dynamic, with an image for every input.
fn planned(graph: &Graph, dynamic: &BTreeSet<ParameterId>, facts: &[(&str, bool)]) -> Planned {
    let mut given_facts = Facts::default();
    facts.iter().for_each(|(name, holds)| given_facts.set(*name, *holds));
    let given = HostImageDesc { desc: ImageDesc::new(FRAME), finite: false };
    let inputs: BTreeMap<_, _> = graph.inputs.iter().map(|input| (input.name.clone(), given)).collect();
    let request = PlanRequest {
        given: HostInputs { inputs, ..HostInputs::none(FRAME) },
        facts: given_facts,
        caps: all_formats(),
        options: Options::default(),
        dynamic: dynamic.clone(),
        requirement: &Requirement::typical,
    };
    Planned::new(graph, &request).unwrap_or_else(|error| panic!("{error}"))
}

/// The parameters of a graph that can change without a new plan.
fn live(graph: &Graph) -> BTreeSet<ParameterId> {
    graph.parameters().filter(|parameter| !graph.declaration(*parameter).replan).collect()
}

fn probes(param: &Param) -> Vec<Value> {
    [param.lowest(), param.highest(), param.middle(), param.neutral.clone()].into_iter().flatten().collect()
}

/// Changes each parameter of a pipeline to several values, one after the other; the number of changes.
fn follow_all(name: &str) -> usize {
    let graph = built_in(name);
    let dynamic = live(&graph);
    let mut planned_once = planned(&graph, &dynamic, &[]);
    let mut changes = 0;
    for parameter in &dynamic {
        let mut changed = PlanCache::new(graph.clone());
        for value in probes(graph.declaration(*parameter)) {
            // Values that do not go with others of the node are refused.
            let Ok(needs_plan) = changed.set(*parameter, value.clone()) else { continue };
            assert!(!needs_plan);
            let mut bytes = planned_once.plan.uniform_buffer();
            let mut write = |at: u64, new: &[u8]| bytes[at as usize..][..new.len()].copy_from_slice(new);
            let instance = &changed.graph().nodes[parameter.node].instance;
            let what = format!("{name}: {} = {value}", graph.parameter_name(*parameter));
            assert_eq!(planned_once.dynamic.uniforms(parameter.node, instance, &mut write), Ok(()), "{what}");
            let fresh = planned(changed.graph(), &dynamic, &[]);
            let wanted = fresh.plan.uniform_buffer();
            let differing = bytes.iter().zip(&wanted).position(|(left, right)| left != right);
            assert_eq!((bytes.len(), differing), (wanted.len(), None), "{what}: the uniforms are those of a new plan");
            assert!(planned_once.plan.differs_in_uniforms_only(&fresh.plan), "{what}: nothing else changes");
            changes += usize::from(bytes != planned_once.plan.uniform_buffer());
        }
    }
    changes
}

#[test]
fn uniforms_follow_every_parameter_of_the_built_in_pipelines() {
    for (name, at_least) in [("lynx.ron", 10), ("tsushima.ron", 100), ("grade.ron", 20), ("glare.ron", 10)] {
        let changes = follow_all(name);
        assert!(changes > at_least, "{name}: {changes} changes were seen");
    }
}

const LOOK: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "bright": Extract(source: "scene", threshold: 1.0, when: "emissive"),
        "mips": Downsample(source: "bright", levels: 3),
        "bloom": Upsample(source: "mips", blend: Mix),
        "lit": Composite(base: "scene", bloom: "bloom", blend: Add, strength: 0.0),
        "exposed": Exposure(source: "lit"),
    },
    outputs: { "out": "exposed" },
)"#;

#[test]
fn a_node_with_a_dynamic_parameter_runs_also_where_it_changes_nothing() {
    let graph = checked(LOOK);
    let strength = BTreeSet::from([graph.parameter("lit.strength").unwrap()]);
    let is_skipped =
        |planned: &Planned, node: &str| planned.plan.savings.skipped.iter().any(|skipped| skipped.node == node);
    let still = planned(&graph, &BTreeSet::new(), &[("emissive", true)]);
    assert!(is_skipped(&still, "lit") && is_skipped(&still, "bloom"), "a strength of 0 needs no bloom");
    let moving = planned(&graph, &strength, &[("emissive", true)]);
    assert!(!is_skipped(&moving, "lit") && !is_skipped(&moving, "bloom"));
    assert!(is_skipped(&moving, "exposed"), "other nodes are skipped as before");
    assert_eq!(moving.plan.dynamic, ["lit.strength"]);
    assert!(moving.plan.to_text().contains("lit.strength"), "{}", moving.plan.to_text());
    let dark = planned(&graph, &strength, &[("emissive", false)]);
    assert!(is_skipped(&dark, "lit"), "without bloom no strength changes anything");
}

#[test]
fn values_that_need_another_plan_are_found() {
    let graph = checked(LOOK);
    let strength = graph.parameter("lit.strength").unwrap();
    let mut moving = planned(&graph, &BTreeSet::from([strength]), &[("emissive", true)]);
    let mut changed = graph.clone();
    let blend = graph.parameter("lit.blend").unwrap();
    changed.nodes[blend.node].instance.set(blend.index, Value::Choice("Screen"));
    let instance = &changed.nodes[blend.node].instance;
    let mut write = |_: u64, _: &[u8]| panic!("nothing is written");
    assert_eq!(moving.dynamic.uniforms(blend.node, instance, &mut write), Err(NeedsPlan));
    let bright = graph.parameter("bright.threshold").unwrap();
    let other = &graph.nodes[bright.node].instance;
    assert_eq!(moving.dynamic.uniforms(bright.node, other, &mut write), Ok(()), "it is not dynamic, so it stays");
}

/// A recording that differs leaves nothing behind, neither passes nor uniforms.
#[test]
fn values_that_fit_again_have_their_uniforms() {
    let graph = checked(LOOK);
    let [strength, blend] = ["lit.strength", "lit.blend"].map(|name| graph.parameter(name).unwrap());
    let mut moving = planned(&graph, &BTreeSet::from([strength]), &[("emissive", true)]);
    let mut changed = graph.clone();
    for value in [0.25, 0.5, 0.75] {
        let instance = &mut changed.nodes[blend.node].instance;
        instance.set(blend.index, Value::Choice("Screen"));
        assert_eq!(moving.dynamic.uniforms(blend.node, instance, &mut |_, _| ()), Err(NeedsPlan));
        instance.set(blend.index, Value::Choice("Add"));
        instance.set(strength.index, Value::Float(value));
        let mut bytes = moving.plan.uniform_buffer();
        let mut writes = 0;
        let mut write = |at: u64, new: &[u8]| {
            writes += 1;
            bytes[at as usize..at as usize + new.len()].copy_from_slice(new);
        };
        assert_eq!(moving.dynamic.uniforms(strength.node, instance, &mut write), Ok(()));
        assert_eq!(writes, 1);
        assert_ne!(bytes, moving.plan.uniform_buffer(), "{value} is another value");
        let fresh = planned(&changed, &BTreeSet::from([strength]), &[("emissive", true)]);
        assert_eq!(bytes, fresh.plan.uniform_buffer(), "{value}");
    }
}

static FICKLE: Shader = Shader::new(
    "fickle.wgsl",
    "struct Fickle { amount: f32, extra: f32 }
fn first(source: vec4f, params: Fickle) -> vec4f { return source * params.extra; }
fn fickle(source: vec4f, chosen: texture_2d<f32>, at: Point, params: Fickle) -> vec4f {
    return source * params.amount + texel(chosen, at.pixel) * params.extra;
}",
);

node_kind! {
    /// Says other things of its pass at other values.
    pub struct Fickle {
        /// Above 0.5 the pass reads another image, and above 0.25 it computes a number twice.
        pub amount: f32 = 0.1 => within(0.0..=1.0);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The image.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The result.").or_input("source")];
}

impl Node for Fickle {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let between = pass.transient("between", desc);
        pass.function(&FICKLE, "first").set("extra", 0.5_f32).write_to(between);
        let chosen = if self.amount > 0.5 { source } else { between };
        let kernel = pass.function(&FICKLE, "fickle").read("chosen", chosen).set("extra", 2.0_f32);
        let kernel = if self.amount > 0.25 { kernel.set("extra", 3.0 + self.amount) } else { kernel };
        kernel.write("result", desc);
    }
}

/// What was looked up for one value holds for another only where the node says the same of its pass.
#[test]
fn a_node_that_says_other_things_of_a_pass_is_looked_up_again() {
    let text = r#"Pipeline(inputs: { "scene": Color }, nodes: { "fickle": Fickle(source: "scene") },
        outputs: { "display": "fickle" })"#;
    let document = parse("fickle.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
    let registry = Registry::new(&[&[NodeKind::of::<Fickle>()]]).expect("one kind");
    let (mut graph, _) =
        check(&document, &registry, &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}"));
    let amount = graph.parameter("fickle.amount").unwrap();
    let mut moving = planned(&graph, &BTreeSet::from([amount]), &[]);
    for value in [0.2, 0.3, 0.1, 0.7, 0.4, 0.6, 0.2, 0.25, 0.3, 0.45] {
        graph.nodes[amount.node].instance.set(amount.index, Value::Float(value));
        let mut bytes = moving.plan.uniform_buffer();
        let mut write = |at: u64, new: &[u8]| bytes[at as usize..][..new.len()].copy_from_slice(new);
        let outcome = moving.dynamic.uniforms(amount.node, &graph.nodes[amount.node].instance, &mut write);
        if value > 0.5 {
            assert_eq!(outcome, Err(NeedsPlan), "{value}: it reads another image");
            continue;
        }
        assert_eq!(outcome, Ok(()), "{value}");
        let fresh = planned(&graph, &BTreeSet::from([amount]), &[]);
        assert_eq!(bytes, fresh.plan.uniform_buffer(), "{value}");
    }
}

static FORMS: Shader = Shader::new(
    "forms.wgsl",
    "struct Forms { form: f32 }
const FORMS_TWICE = false;
fn forms(source: vec4f, params: Forms) -> vec4f {
    return source * params.form * select(1.0, 2.0, FORMS_TWICE);
}
fn forms_other(source: vec4f, params: Forms) -> vec4f { return source + params.form; }",
);

node_kind! {
    /// Each whole number is a pass that differs from all others in one thing.
    pub struct Forms {
        /// The number.
        pub form: f32 = 0.0 => within(0.0..=5.0);
    }

    const INPUTS: &'static [Input] =
        &[Input::image("source", "The image."), Input::image("other", "An image of the same size.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The result.").or_input("source")];
}

impl Node for Forms {
    fn record(&self, pass: &mut Recorder<'_>) {
        let (source, other) = (pass.image("source"), pass.image("other"));
        let desc = ImageDesc::new(pass.desc(source).size);
        let form = self.form.round() as u32;
        let call = pass.function(&FORMS, if form == 1 { "forms_other" } else { "forms" });
        let call = if form == 2 { call.label("forms of its own") } else { call };
        let call = if form == 3 { call.read("source", other) } else { call };
        let call = if form == 4 { call.define("FORMS_TWICE", true) } else { call };
        call.write("result", if form == 5 { desc.format(Format::Rgba32Float) } else { desc });
    }
}

/// From each form to each other one, and back.
#[test]
fn a_pass_that_differs_in_one_thing_needs_another_plan() {
    let text = r#"Pipeline(inputs: { "scene": Color, "other": Color }, outputs: { "display": "forms" },
        nodes: { "forms": Forms(source: "scene", other: "other") })"#;
    let document = parse("forms.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
    let registry = Registry::new(&[&[NodeKind::of::<Forms>()]]).expect("one kind");
    let (mut graph, _) =
        check(&document, &registry, &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}"));
    let form = graph.parameter("forms.form").unwrap();
    for first in 0..6 {
        graph.nodes[form.node].instance.set(form.index, Value::Float(f64::from(first)));
        let mut moving = planned(&graph, &BTreeSet::from([form]), &[]);
        for next in 0..6 {
            let mut changed = graph.clone();
            changed.nodes[form.node].instance.set(form.index, Value::Float(f64::from(next)));
            let outcome = moving.dynamic.uniforms(form.node, &changed.nodes[form.node].instance, &mut |_, _| ());
            assert_eq!(outcome, if first == next { Ok(()) } else { Err(NeedsPlan) }, "from {first} to {next}");
        }
    }
}

#[test]
fn a_parameter_is_found_by_its_name_and_near_names_are_suggested() {
    let graph = checked(LOOK);
    let found = graph.parameter("lit.strength").unwrap();
    assert_eq!(graph.parameter_name(found), "lit.strength");
    assert_eq!(graph.value(found), &Value::Float(0.0));
    for (wrong, hint) in
        [("lit.strenght", "`strength`"), ("lid.strength", "`lit`"), ("lit", "is a node"), ("", "no node")]
    {
        let error = graph.parameter(wrong).unwrap_err();
        assert!(error.contains(hint), "{wrong}: {error}");
    }
}

#[test]
fn a_value_that_a_node_refuses_changes_nothing() {
    let graph = checked(
        r#"Pipeline(inputs: { "scene": Color }, nodes: {
            "mean": MeanLuminance(source: "scene"),
            "meter": Adapt(mean: "mean", min_ev: 0.0, max_ev: 10.0),
            "exposed": Exposure(source: "scene", meter: "meter"),
        }, outputs: { "out": "exposed" })"#,
    );
    let mut plans = PlanCache::new(graph);
    let lowest = plans.graph().parameter("meter.min_ev").unwrap();
    for (value, why) in [(Value::Float(11.0), "max_ev"), (Value::Float(1e30), "within"), (Value::Bool(true), "number")]
    {
        let error = plans.set(lowest, value).unwrap_err();
        assert!(error.contains(why), "{error}");
        assert_eq!(plans.graph().value(lowest), &Value::Float(0.0));
    }
}

/// A value that a plan without the node cannot show asks for another plan.
#[test]
fn an_identity_of_several_parameters_is_none_at_other_values() {
    let graph = checked(
        r#"Pipeline(inputs: { "scene": Color }, nodes: {
            "exposed": Exposure(source: "scene", stops: 1.0),
            "seen": Purkinje(source: "exposed", illuminance: 1000.0),
        }, outputs: { "out": "seen" })"#,
    );
    let seen = graph.node("seen").unwrap().0;
    for parameters in [vec!["seen.illuminance"], vec!["seen.illuminance", "seen.strength", "seen.scale"]] {
        let dynamic = parameters.iter().map(|name| graph.parameter(name).unwrap()).collect();
        let planned = planned(&graph, &dynamic, &[]);
        assert!(planned.plan.savings.skipped.is_empty(), "{parameters:?}: {:?}", planned.plan.savings.skipped);
    }
    // By day no strength changes anything, so the node is skipped; at another illuminance it would be missed.
    let mut by_day = planned(&graph, &BTreeSet::from([graph.parameter("seen.strength").unwrap()]), &[]);
    assert_eq!(by_day.plan.savings.skipped.len(), 1);
    let mut at_night = graph.clone();
    let illuminance = graph.parameter("seen.illuminance").unwrap();
    at_night.nodes[seen].instance.set(illuminance.index, Value::Float(0.1));
    let mut write = |_: u64, _: &[u8]| panic!("nothing is written");
    assert_eq!(by_day.dynamic.uniforms(seen, &graph.nodes[seen].instance, &mut write), Ok(()));
    assert_eq!(by_day.dynamic.uniforms(seen, &at_night.nodes[seen].instance, &mut write), Err(NeedsPlan));
}

#[test]
fn the_built_in_kinds_keep_the_contract() {
    afterimage_graph::node::contract(afterimage_nodes::ALL)
        .unwrap_or_else(|complaints| panic!("{}", complaints.join("\n")));
}

/// A new value of a node that is off needs no plan: it is off at all values.
#[test]
fn a_node_that_is_off_asks_for_no_plan() {
    let graph = checked(&LOOK.replace("blend: Add, strength: 0.0", "blend: Add, strength: 0.0, when: \"emissive\""));
    let strength = graph.parameter("lit.strength").unwrap();
    let mut dark = planned(&graph, &BTreeSet::from([strength]), &[("emissive", false)]);
    let mut changed = graph.clone();
    changed.nodes[strength.node].instance.set(strength.index, Value::Float(0.5));
    let mut write = |_: u64, _: &[u8]| panic!("nothing is written");
    let instance = &changed.nodes[strength.node].instance;
    assert_eq!(dark.dynamic.uniforms(strength.node, instance, &mut write), Ok(()));
}

static LATER: Shader = Shader::new("later.wgsl", "fn later(source: vec4f) -> vec4f { return source; }\n");

node_kind! {
    /// Calls a function that does not exist, if it is not `right`.
    pub struct Later {
        /// Whether it exists.
        pub right: bool = true;
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "An image.")];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "An image.").or_input("source")];
}

impl Node for Later {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        pass.function(&LATER, if self.right { "later" } else { "latter" }).write("result", desc);
    }
}

#[test]
fn a_wrong_shader_at_a_new_value_asks_for_a_plan_which_has_the_error() {
    let text = r#"Pipeline(
        inputs: { "scene": Color }, nodes: { "node": Later(source: "scene") }, outputs: { "out": "node" },
    )"#;
    let registry = Registry::new(&[&[NodeKind::of::<Later>()]]).unwrap();
    let (graph, _) = check(&parse("test.ron", text).unwrap(), &registry, &CheckOptions::default()).unwrap();
    let right = graph.parameter("node.right").expect("it has one");
    let mut planned = planned(&graph, &BTreeSet::from([right]), &[]);
    let mut changed = PlanCache::new(graph.clone());
    assert!(changed.set(right, Value::Bool(false)).is_ok());
    let instance = &changed.graph().nodes[right.node].instance;
    assert_eq!(planned.dynamic.uniforms(right.node, instance, &mut |_, _| {}), Err(NeedsPlan));
}
