//! The files that a document names, for hosts that load them asynchronously.

use std::collections::{BTreeMap, BTreeSet};

use afterimage_graph::check::{CheckOptions, LoadedFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::Registry;

const LOOK: &str = r#"Pipeline(
    extends: "../base.ron",
    nodes: { "again": Pipeline(file: "parts/inner.ron", source: "exposed") },
    tiers: { "low": "low.ron", "table": { "again/graded.file": "tables/low.cube" } },
)"#;

const OTHERS: [(&str, &str); 6] = [
    (
        "base.ron",
        r#"Pipeline(inputs: { "scene": Color }, nodes: { "exposed": Exposure(source: "scene") },
        outputs: { "display": "exposed" })"#,
    ),
    (
        "looks/parts/inner.ron",
        r#"Pipeline(inputs: { "source": Exposed }, nodes: { "mapped": ToneMap(source: "source", curve: Reinhard),
        "graded": ColorLut(source: "mapped", file: "../tables/inner.cube") }, outputs: { "result": "graded" })"#,
    ),
    ("looks/low.ron", r#"Pipeline(extends: "../lower.ron")"#),
    ("lower.ron", r#"Pipeline(extends: "base.ron", set: { "exposed.stops": 1.0 })"#),
    ("looks/tables/inner.cube", CUBE),
    ("looks/tables/low.cube", CUBE),
];

const CUBE: &str = "LUT_3D_SIZE 2\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n0.9 1 1\n";

#[test]
fn every_file_of_a_document_is_asked_for_until_none_is_missing() {
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
    let document = parse("looks/look.ron", LOOK).unwrap_or_else(|errors| panic!("{errors}"));
    let on_disk = BTreeMap::from(OTHERS);
    let mut files = LoadedFiles::default();
    let mut rounds = Vec::new();
    loop {
        let missing = files.missing(&document, &registry);
        if missing.is_empty() {
            break;
        }
        for path in &missing {
            let bytes = on_disk.get(path.as_str()).map(|text| text.as_bytes().into());
            files.insert(path.clone(), bytes.ok_or_else(|| "there is no such file".to_owned()));
        }
        rounds.push(missing);
    }
    let all: BTreeSet<&String> = rounds.iter().flatten().collect();
    assert_eq!(rounds.iter().map(BTreeSet::len).sum::<usize>(), all.len(), "no file is asked for twice");
    let wanted: BTreeSet<&str> = OTHERS.iter().map(|(path, _)| *path).collect();
    assert!(all.iter().map(|path| path.as_str()).collect::<BTreeSet<_>>().is_superset(&wanted), "{rounds:?}");
    assert!(rounds.len() > 1, "files name further files: {rounds:?}");
    let options = CheckOptions { loader: &files, ..CheckOptions::default() };
    let (graph, _) = check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors}"));
    assert!(graph.nodes.iter().any(|node| node.kind().name() == "ColorLut"), "the nested pipeline is there");
}

#[test]
fn a_file_that_cannot_be_loaded_is_reported_where_it_is_named() {
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
    let document = parse("a.ron", r#"Pipeline(extends: "b.ron")"#).unwrap_or_else(|errors| panic!("{errors}"));
    let mut files = LoadedFiles::default();
    assert_eq!(files.missing(&document, &registry), ["b.ron".to_owned()].into());
    files.insert("b.ron".into(), Err("the download has failed".into()));
    assert!(files.missing(&document, &registry).is_empty());
    let options = CheckOptions { loader: &files, ..CheckOptions::default() };
    let errors = check(&document, &registry, &options).expect_err("it has no base").to_string();
    assert!(errors.contains("cannot read `b.ron`: the download has failed") && errors.contains("a.ron:1"), "{errors}");
}
