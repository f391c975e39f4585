//! The facts of the built-in pipelines: what a scene does not require is skipped.

use std::collections::BTreeSet;

use afterimage_graph::check::{CheckOptions, Fact, Facts, Graph, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{Format, ImageDesc};
use afterimage_graph::node::Registry;
use afterimage_plan::{Caps, HostImageDesc, HostInputs, Options, Plan, PlanRequest, Requirement, plan};

use super::support::{FRAME, Files, built_in, pipelines};

/// All facts that built-in pipelines have, each with the same meaning in all of them.
const FACTS: [(&str, &str); 3] = [
    ("emissive", "something in view gives out light"),
    ("illuminance", "the light on the scene in lux; below 10 night vision begins"),
    ("moving", "the camera or something in view moves"),
];

/// The plan for a host that gives all inputs.
fn planned(graph: &Graph, facts: Facts) -> Plan {
    let image = HostImageDesc { desc: ImageDesc::new(FRAME).format(Format::Rgba16Float), finite: false };
    planned_for(graph, facts, HostInputs::all(FRAME, &graph.inputs, image))
}

fn planned_for(graph: &Graph, facts: Facts, given: HostInputs) -> Plan {
    let request = PlanRequest {
        given,
        facts,
        caps: Caps::default(),
        options: Options::default(),
        dynamic: Default::default(),
        requirement: &Requirement::typical,
    };
    plan(graph, &request).unwrap_or_else(|error| panic!("{error}"))
}

fn with(name: &str, fact: impl Into<Fact>) -> Facts {
    let mut facts = Facts::default();
    facts.set(name, fact);
    facts
}

/// A built-in pipeline with another value of a parameter.
fn changed(name: &str, parameter: &str, value: &str) -> Graph {
    let path = pipelines().join(name);
    let text = std::fs::read_to_string(&path).expect("it is built in");
    let document = parse(&path.to_string_lossy(), &text).unwrap_or_else(|errors| panic!("{errors}"));
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let sets = vec![(parameter.to_owned(), value.to_owned())];
    let options = CheckOptions { sets, loader: &Files, ..CheckOptions::default() };
    check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors}")).0
}

/// The built-in pipelines, by name, with the facts of their files.
fn files() -> Vec<(String, Vec<(String, String)>)> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(pipelines()).expect("the repository has pipelines") {
        let path = entry.expect("a folder can be listed").path();
        let name = path.file_name().expect("it has one").to_string_lossy().into_owned();
        if name.ends_with(".ron") {
            let text = std::fs::read_to_string(&path).expect("it can be read");
            let document = parse(&name, &text).unwrap_or_else(|errors| panic!("{errors}"));
            let facts = document.facts.into_iter().flatten().map(|(name, meaning)| (name.value, meaning));
            files.push((name, facts.collect()));
        }
    }
    files
}

#[test]
fn a_fact_has_one_meaning_in_all_pipelines() {
    let mut found = BTreeSet::new();
    for (file, facts) in files() {
        for (name, meaning) in facts {
            let known = FACTS.iter().find(|(known, _)| *known == name);
            assert_eq!(known.map(|(_, meaning)| *meaning), Some(meaning.as_str()), "{file}: {name}");
            found.insert(name);
        }
    }
    assert_eq!(found.len(), FACTS.len());
}

/// Every fact of every pipeline, with those that it inherits.
#[test]
fn what_a_fact_rules_out_is_skipped() {
    let mut checked = 0;
    for (file, own) in files() {
        let graph = built_in(&file);
        let names: Vec<String> = graph.facts().into_iter().map(|(name, _)| name).collect();
        assert!(own.iter().all(|(name, _)| names.contains(name)), "{file} has a fact that nothing reads: {own:?}");
        for name in names {
            assert!(FACTS.iter().any(|(known, _)| *known == name), "{file}: {name}");
            // By day, a file has no night vision in any case.
            let graph = if name == "illuminance" { changed(&file, "seen.illuminance", "0.1") } else { graph.clone() };
            let (written, without) = match name.as_str() {
                "illuminance" => (with(&name, 9.9), with(&name, 10.0)),
                _ => (with(&name, true), with(&name, false)),
            };
            let [unknown, written, without] = [Facts::default(), written, without].map(|facts| planned(&graph, facts));
            assert_eq!(unknown.hash(), written.hash(), "{file}: {name}");
            let why = format!("`when: {name}");
            let is_skipped = without.savings.skipped.iter().any(|skipped| skipped.why.starts_with(&why));
            assert!(is_skipped, "{file} without {name}: {:?}", without.savings.skipped);
            // Night vision is a part of a pass that does more.
            let saves = without.passes.len() < written.passes.len() || name == "illuminance";
            assert!(saves && without.hash() != written.hash(), "{file} does as much without {name}");
            checked += 1;
        }
    }
    assert!(checked >= 13, "only {checked}");
}

/// Fog that a renderer does not give is in no pass, and fog of no density is in none.
#[test]
fn fog_that_is_not_there_is_skipped() {
    let image = HostImageDesc { desc: ImageDesc::new(FRAME).format(Format::Rgba16Float), finite: false };
    let skipped = |graph: &Graph, is_given: bool| {
        let inputs = graph.inputs.iter().filter(|input| is_given || input.name != "fog");
        let given = HostInputs::all(FRAME, inputs, image);
        let skipped = planned_for(graph, Facts::default(), given).savings.skipped;
        ["foggy", "volumetric"].map(|node| skipped.iter().any(|skipped| skipped.node == node))
    };
    let written = built_in("cinematic.ron");
    let thick = changed("cinematic.ron", "foggy.density", "0.01");
    assert_eq!([skipped(&written, true), skipped(&written, false)], [[true, false], [true, true]]);
    assert_eq!([skipped(&thick, true), skipped(&thick, false)], [[false, false], [false, true]]);
}

/// There is no depth then, rather than one of 0, and what needs it is off, too.
#[test]
fn where_the_host_draws_nothing_what_needs_its_depth_is_off() {
    let text = r#"Pipeline(
        inputs: { "scene": Color },
        nodes: { "drawn": Draw(when: "geometry"), "fogged": Fog(source: "scene", depth: "drawn.depth") },
        outputs: { "out": "fogged" },
    )"#;
    let registry = Registry::new(&[afterimage_nodes::ALL, afterimage_nodes::HOST]).expect("no two kinds share a name");
    let document = parse("test.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
    let graph = check(&document, &registry, &CheckOptions::default()).unwrap_or_else(|errors| panic!("{errors}")).0;
    let skips_fog = |is_drawn: bool| {
        let plan = planned(&graph, with("geometry", is_drawn));
        plan.savings.skipped.iter().any(|skipped| skipped.node == "fogged")
    };
    assert_eq!([true, false].map(skips_fog), [false, true]);
}
