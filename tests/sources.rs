//! The table of source systems in the documentation, compared with kinds, pipelines, tests and pictures.

use std::collections::BTreeSet;
use std::path::Path;

use crate::support::docs;
use crate::support::gpu::built_in;

/// The cells of each row below its head: document, section, kind, pipeline, test, picture.
fn rows(text: &str) -> Vec<Vec<&str>> {
    let lines = text.lines().filter(|line| line.starts_with('|')).skip(2);
    lines.map(|line| line.trim_matches('|').split(" | ").map(str::trim).collect()).collect()
}

/// What a cell sets in the type of code.
fn code(cell: &str) -> impl Iterator<Item = &str> {
    cell.split('`').skip(1).step_by(2)
}

fn is_kind(name: &str) -> bool {
    afterimage_nodes::ALL.iter().chain(afterimage_nodes::HOST).any(|kind| kind.name() == name)
}

/// The kinds that a cell names; the other words are ports and parameters.
fn kinds(cell: &str) -> BTreeSet<&str> {
    code(cell).filter(|name| name.starts_with(char::is_uppercase)).collect()
}

/// Kinds that do not exist, and pipelines with none of the kinds or without an input that the cell names.
fn of_pipelines(row: &[&str]) -> Vec<String> {
    let (kinds, files) = (kinds(row[2]), code(row[3]).filter(|name| name.ends_with(".ron")));
    let mut found: Vec<String> =
        kinds.iter().filter(|name| !is_kind(name)).map(|name| format!("there is no kind `{name}`")).collect();
    let inputs: Vec<&str> = row[3].split("input `").skip(1).filter_map(|rest| rest.split('`').next()).collect();
    let mut declared = BTreeSet::new();
    for file in files {
        let graph = built_in(file, None);
        declared.extend(graph.inputs.iter().map(|input| input.name.clone()));
        let has_one = graph.nodes.iter().any(|node| kinds.contains(node.instance.kind().name()));
        if !kinds.is_empty() && !has_one {
            found.push(format!("`{file}` has none of {kinds:?}"));
        }
    }
    let missing = inputs.iter().filter(|name| !declared.contains(**name));
    found.extend(missing.map(|name| format!("no pipeline of the row has an input `{name}`")));
    found
}

/// Tests that are named and do not exist.
fn of_tests(cell: &str, names: &BTreeSet<String>) -> Vec<String> {
    let exists = |path: &str| names.iter().any(|name| name.starts_with(&format!("{path}::")) || name == path);
    let named: Vec<&str> = code(cell).collect();
    if named.is_empty() {
        return vec!["the row names no test".into()];
    }
    named.iter().filter(|path| !exists(path)).map(|path| format!("there is no test `{path}`")).collect()
}

/// Files that are named and do not exist, and sections of documents without a picture or a table.
fn of_pictures(cell: &str, written: &str) -> Vec<String> {
    let mut found = Vec::new();
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for name in code(cell) {
        let exists = match name {
            "demo" | "render --plan draws=on" => true,
            _ if name.contains('/') => repository.join(name).is_file(),
            _ if name.ends_with(".png") => written.contains(name),
            _ => !name.contains('.') || docs::path(name).exists(),
        };
        if !exists {
            found.push(format!("there is no picture `{name}`"));
        }
    }
    for link in cell.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
        let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
        let text = std::fs::read_to_string(docs::path(file)).unwrap_or_default();
        let heads = text.lines().filter(|line| line.starts_with('#'));
        let is_head = |line: &str| line.trim_start_matches(['#', ' ']).to_lowercase().replace(' ', "-") == anchor;
        if !heads.clone().any(is_head) {
            found.push(format!("`{link}` leads nowhere"));
        }
    }
    if code(cell).next().is_none() && !cell.contains("](") {
        found.push("the row names no picture".into());
    }
    found
}

/// The names of all tests of this program, as its option `--list` prints them.
fn tests() -> BTreeSet<String> {
    let program = std::env::current_exe().expect("the test knows its file");
    let done = std::process::Command::new(program).arg("--list").output().expect("the test starts itself");
    let text = String::from_utf8(done.stdout).expect("names are text");
    text.lines().filter_map(|line| Some(line.strip_suffix(": test")?.to_owned())).collect()
}

#[test]
fn every_effect_of_others_has_a_kind_or_a_reason() {
    let text = std::fs::read_to_string(docs::path("measurements/effects.csv")).expect("the table is there");
    assert!(text.starts_with("source,effect,kinds,remark\n") && text.lines().count() > 120);
    for line in text.lines().skip(1) {
        let [_, _, kinds, remark] = line.splitn(4, ',').collect::<Vec<_>>()[..] else {
            panic!("not four cells: {line}")
        };
        assert!(!kinds.is_empty() || !remark.is_empty(), "neither a kind nor a reason: {line}");
        for kind in kinds.split_whitespace() {
            assert!(is_kind(kind), "there is no kind `{kind}`: {line}");
        }
    }
}

#[test]
fn every_row_has_kinds_pipelines_tests_and_pictures_that_exist() {
    let text = std::fs::read_to_string(docs::path("sources.md")).expect("the table is there");
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let example =
        std::fs::read_to_string(repository.join("graph/afterimage/examples/scene/main.rs")).expect("the example");
    let (rows, tests) = (rows(&text), tests());
    assert!(rows.len() > 25 && tests.len() > 200, "{} rows, {} tests", rows.len(), tests.len());
    let mut wrong = Vec::new();
    for row in &rows {
        assert!(row.len() == 6 && row.iter().all(|cell| !cell.is_empty()), "not six cells: {row:?}");
        let found = [of_pipelines(row), of_tests(row[4], &tests), of_pictures(row[5], &example)].concat();
        wrong.extend(found.iter().map(|what| format!("{} {}: {what}", row[0], row[1])));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A row that is wrong in each cell is found to be.
#[test]
fn what_does_not_exist_is_found() {
    let text = "| a | b | c | d | e | f |\n|---|---|---|---|---|---|\n\
                | 000 | 1 | `Fogg` with `depth` | `mobile.ron`, input `rain` | `nodes::fogg` | `docs/none.jpg` |";
    let row = &rows(text)[0];
    assert_eq!(
        of_pipelines(row),
        [
            "there is no kind `Fogg`",
            "`mobile.ron` has none of {\"Fogg\"}",
            "no pipeline of the row has an input `rain`"
        ]
    );
    assert_eq!(of_tests(row[4], &BTreeSet::from(["nodes::fog::a".into()])), ["there is no test `nodes::fogg`"]);
    assert_eq!(of_tests("`nodes::fog`", &BTreeSet::from(["nodes::fog::a".into()])), [""; 0]);
    assert_eq!(of_pictures(row[5], ""), ["there is no picture `docs/none.jpg`"]);
    assert_eq!(of_pictures("`scene.png` of [it](depth.md#none)", "").len(), 2);
}
