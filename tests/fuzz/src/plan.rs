//! PlanCache: whatever the device, the frame and the settings, a plan is proved or refused with words.

use std::collections::BTreeMap;

use afterimage_graph::check::{CheckOptions, FactKind, Facts, Graph, check};
use afterimage_graph::document::{Document, parse};
use afterimage_graph::image::{Format, ImageDesc, Size};
use afterimage_graph::node::{Bake, NodeKind};
use afterimage_graph::value::{Param, Type};
use afterimage_plan::{
    Alias, Caps, HostImageDesc, HostInputs, Options, Part, Plan, PlanError, PlanRequest, Requirement, When, diff, plan,
    verify,
};

use crate::bytes::Bytes;
use crate::document::{Few, all_shipped, registry};

/// Bytes that the choices of one plan need at most, about.
pub(crate) const MAX_CHOICES: usize = 96;

const SIDES: [u32; 12] = [1, 2, 3, 7, 16, 17, 63, 640, 1080, 1921, 8192, 65535];
/// The slices of every volume of a host.
const SLICES: u32 = 5;
const NUMBERS: [&str; 8] = ["0", "0.0", "-1.0", "1e-30", "1e30", "NaN", "inf", "65536"];

/// A shipped pipeline, and the names and kinds of its nodes.
struct Shipped {
    document: Document,
    nodes: Vec<(String, NodeKind)>,
}

/// The shipped pipelines, read once.
fn pipelines() -> &'static [Shipped] {
    static PIPELINES: std::sync::OnceLock<Vec<Shipped>> = std::sync::OnceLock::new();
    let read = |(name, text): &(String, String)| {
        let document = parse(name, text).unwrap_or_else(|told| panic!("{told}"));
        let options = CheckOptions { loader: &Few::new(""), ..Default::default() };
        let (graph, _) = check(&document, registry(), &options).unwrap_or_else(|told| panic!("{told}"));
        let nodes = graph.nodes.into_iter().map(|node| (node.name, node.instance.kind().clone())).collect();
        Shipped { document, nodes }
    };
    PIPELINES.get_or_init(|| all_shipped().iter().map(read).collect())
}

/// The plan of a graph without facts, all inputs given at the size of the frame.
pub(crate) fn planned(graph: &Graph, size: Size, caps: Caps, options: Options) -> Result<Plan, PlanError> {
    let given = HostImageDesc { desc: ImageDesc::new(size), finite: false };
    let inputs = graph.inputs.iter().map(|input| (input.name.clone(), given)).collect();
    let requirement = &Requirement::typical;
    plan(
        graph,
        &PlanRequest {
            given: HostInputs { inputs, ..HostInputs::none(size) },
            facts: Facts::default(),
            caps,
            options,
            dynamic: Default::default(),
            requirement,
        },
    )
}

/// True if the choices lead to a plan.
pub(crate) fn survives(choices: &mut Bytes<'_>) -> bool {
    let shipped = &pipelines()[choices.below(pipelines().len())];
    let tiers: Vec<&str> = shipped.document.tiers.iter().map(|(name, _)| name.value.as_str()).collect();
    let tier = tiers.get(choices.below(8)).map(|tier| (*tier).to_owned());
    let sets = (0..choices.below(4)).map(|_| set(&shipped.nodes, choices)).collect();
    let options = CheckOptions { tier, sets, loader: &Few::new("") };
    let Ok((mut graph, _)) = check(&shipped.document, registry(), &options) else { return false };
    switch(&mut graph, choices);
    match plan_anyhow(&graph, choices) {
        Ok(plan) => {
            proves(&plan);
            if choices.rarely(16) {
                shows(&plan);
            }
            true
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
            false
        }
    }
}

/// A change of a parameter to the ends of its domain, between them, or beyond.
fn set(nodes: &[(String, NodeKind)], choices: &mut Bytes<'_>) -> (String, String) {
    let (name, kind) = &nodes[choices.below(nodes.len())];
    match kind.params() {
        [] => (format!("{name}.nothing"), "1".into()),
        params => {
            let param = &params[choices.below(params.len())];
            (format!("{name}.{}", param.name), value(param, choices))
        }
    }
}

fn value(param: &Param, choices: &mut Bytes<'_>) -> String {
    let (low, high) = param.domain.unwrap_or((0.0, 1.0));
    let number = |choices: &mut Bytes<'_>| {
        match choices.below(4) {
            0 => low,
            1 => high,
            2 => low + (high - low) * choices.below(256) as f64 / 255.0,
            _ => return NUMBERS[choices.below(NUMBERS.len())].to_owned(),
        }
        .to_string()
    };
    match param.ty {
        Type::Bool => choices.flag().to_string(),
        Type::Choice(all) => choices.one_of(&all.iter().map(|choice| choice.name).collect::<Vec<_>>()).to_owned(),
        Type::Int => (low + ((high - low) * choices.below(256) as f64 / 255.0).floor()).to_string(),
        Type::Float => number(choices),
        Type::Vector(n) => format!("({})", (0..n).map(|_| number(choices)).collect::<Vec<_>>().join(", ")),
        Type::Text => ["", "\"a\""][choices.below(2)].to_owned(),
        Type::File => ["look.cube", "none.png", ""][choices.below(3)].to_owned(),
    }
}

/// Nodes off that can be, and formats that the file might have asked for.
fn switch(graph: &mut Graph, choices: &mut Bytes<'_>) {
    let formats: Vec<Format> = Format::ALL.to_vec();
    for node in &mut graph.nodes {
        let can_be_off = node.kind().can_be_off();
        node.off |= can_be_off && choices.rarely(8);
        if choices.rarely(16) {
            node.format = Some(choices.one_of(&formats));
        }
    }
}

fn plan_anyhow(graph: &Graph, choices: &mut Bytes<'_>) -> Result<Plan, PlanError> {
    let size = Size::new(choices.one_of(&SIDES), choices.one_of(&SIDES));
    let mut inputs = BTreeMap::new();
    for input in &graph.inputs {
        if !choices.rarely(6) {
            inputs.insert(input.name.clone(), given(input.volume, size, choices));
        }
    }
    let (facts, caps, options) = (facts(graph, choices), caps(choices), options(choices));
    let mut given = HostInputs { inputs, ..HostInputs::none(size) };
    rectangles(graph, &mut given, choices);
    let requirement = &Requirement::typical;
    plan(graph, &PlanRequest { given, facts, caps, options, dynamic: Default::default(), requirement })
}

/// Some inputs and outputs are rectangles of the host's images.
fn rectangles(graph: &Graph, given: &mut HostInputs, choices: &mut Bytes<'_>) {
    for input in &graph.inputs {
        if choices.rarely(4) {
            given.parts.insert(input.name.clone(), choices.one_of(&[Part::Rectangle, Part::Scaled]));
        }
    }
    for output in &graph.outputs {
        if choices.rarely(4) {
            given.rectangles.insert(output.name.clone());
        }
    }
}

fn given(volume: bool, size: Size, choices: &mut Bytes<'_>) -> HostImageDesc {
    let size = if choices.rarely(4) { Size::new(choices.one_of(&SIDES), choices.one_of(&SIDES)) } else { size };
    let slices = || ImageDesc::volume(Size::volume(size.width, size.height, SLICES));
    let desc = if volume { slices() } else { ImageDesc::new(size) };
    let formats: Vec<Format> = Format::ALL.to_vec();
    HostImageDesc { desc: desc.format(choices.one_of(&formats)), finite: choices.flag() }
}

fn facts(graph: &Graph, choices: &mut Bytes<'_>) -> Facts {
    let mut facts = Facts::default();
    for (name, kind) in graph.facts() {
        match (choices.below(3), kind) {
            (0, _) => {}
            (1, FactKind::Flag) | (2, FactKind::Number) => facts.set(name, choices.flag()),
            _ => facts.set(name, choices.one_of(&[0.0, 0.5, 1.0, -1e30, f64::NAN, f64::INFINITY])),
        }
    }
    facts
}

fn caps(choices: &mut Bytes<'_>) -> Caps {
    let plain = Caps::default();
    Caps {
        storage: if choices.flag() { Format::ALL.into() } else { plain.storage },
        filter_32_bit: choices.flag(),
        fast_workgroup_memory: choices.flag(),
        prefer_fragment: choices.flag(),
        max_side: choices.one_of(&[8192, 16384, 32768]),
        ..plain
    }
}

fn options(choices: &mut Bytes<'_>) -> Options {
    Options {
        fuse: choices.flag(),
        row_downsample: choices.one_of(&[When::Never, When::WhereItPays, When::Always]),
        alias: choices.one_of(&[Alias::None, Alias::Pool, Alias::Placed]),
        repeatable: choices.flag(),
        serial: choices.flag(),
        exact: choices.flag(),
        batches_first: choices.flag(),
        bounds_checks: choices.flag(),
        bake: choices.one_of(&[None, Some(Bake::Off), Some(Bake::Auto), Some(Bake::Size(33))]),
        count_faults: false,
        one_frame: false,
    }
}

/// A plan holds what plans promise.
fn proves(plan: &Plan) {
    if let Err(faults) = verify(plan) {
        panic!("{} faults, the first: {}", faults.len(), faults[0]);
    }
    assert!(plan.memory.lower_bound <= plan.memory.placed);
    assert!(diff(plan, plan).is_empty());
}

/// Every way to show a plan works.
fn shows(plan: &Plan) {
    assert!(plan.to_text().contains("pass") || plan.passes.is_empty());
    assert!(plan.to_json().starts_with('{'));
}
