//! The facts of the built-in pipelines: what a scene does not require is skipped.

use std::collections::BTreeSet;

use afterimage_graph::check::{CheckOptions, Fact, Facts, Graph, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{Format, ImageDesc};
use afterimage_graph::node::Registry;
use afterimage_plan::{Caps, GivenImage, HostInputs, Options, Plan, PlanRequest, Requirement, plan};

use super::planned::{FRAME, built_in, pipelines};

/// All facts that built-in pipelines have, each with the same meaning in all of them.
const FACTS: [(&str, &str); 3] = [
    ("emissive", "something in view gives out light"),
    ("illuminance", "the light on the scene in lux; below 10 night vision begins"),
    ("moving", "the camera or something in view moves"),
];

fn planned(graph: &Graph, facts: Facts) -> Plan {
    let image = GivenImage { desc: ImageDesc::new(FRAME).format(Format::Rgba16Float), finite: false };
    let given = HostInputs::everything(FRAME, &graph.inputs, image);
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

/// The pipeline of a file with another illuminance of its night vision.
fn at_night(name: &str) -> Graph {
    let text = std::fs::read_to_string(pipelines().join(name)).expect("it is built in");
    let document = parse(name, &text).unwrap_or_else(|errors| panic!("{errors}"));
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("no two kinds share a name");
    let sets = vec![("seen.illuminance".to_owned(), "0.1".to_owned())];
    let options = CheckOptions { sets, ..CheckOptions::default() };
    check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors}")).0
}

#[test]
fn a_fact_has_one_meaning_in_all_pipelines() {
    let mut found = BTreeSet::new();
    for entry in std::fs::read_dir(pipelines()).expect("the repository has pipelines") {
        let path = entry.expect("a folder can be listed").path();
        if path.extension().is_none_or(|ending| ending != "ron") {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("it can be read");
        let document = parse("pipeline.ron", &text).unwrap_or_else(|errors| panic!("{errors}"));
        for (name, meaning) in document.facts.into_iter().flatten() {
            let known = FACTS.iter().find(|(known, _)| *known == name.value);
            assert_eq!(
                known.map(|(_, meaning)| *meaning),
                Some(meaning.as_str()),
                "{}: {}",
                path.display(),
                name.value
            );
            found.insert(name.value);
        }
    }
    assert_eq!(found.len(), FACTS.len());
}

#[test]
fn what_a_fact_rules_out_is_skipped() {
    let bloom = ["caracal", "cinematic", "cookbook", "course", "glare", "hdr", "lynx", "mobile", "tsushima"];
    for name in bloom {
        let graph = built_in(&format!("{name}.ron"));
        let (written, dark) = (planned(&graph, Facts::default()), planned(&graph, with("emissive", false)));
        assert!(dark.passes.len() + 3 <= written.passes.len(), "{name}: {} passes", dark.passes.len());
        assert_eq!(planned(&graph, with("emissive", true)).hash(), written.hash(), "{name}");
    }
    for name in ["tsushima.ron", "mobile.ron"] {
        let graph = at_night(name);
        let is_seen = |facts: Facts| planned(&graph, facts).skipped.iter().all(|skipped| skipped.node != "seen");
        assert!(is_seen(Facts::default()) && is_seen(with("illuminance", 9.9)), "{name}");
        assert!(!is_seen(with("illuminance", 10.0)), "{name}");
    }
    let graph = built_in("cinematic.ron");
    let (written, still) = (planned(&graph, Facts::default()), planned(&graph, with("moving", false)));
    assert!(still.passes.len() < written.passes.len());
    assert!(still.skipped.iter().any(|skipped| skipped.node == "moved"));
}
