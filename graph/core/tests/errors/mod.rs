//! What users are reported when a file is wrong: every `errors/NAME.ron` against `errors/NAME.txt`, to the letter.
//!
//! `AFTERIMAGE_BLESS=1 cargo test -p afterimage-graph errors` writes the texts anew; read the difference before you
//! keep it. A first line `//! tier: NAME` or `//! set: node.parameter=value` gives options to the check.

mod absurd;
mod accepted;
mod conditions;
mod contract;
mod diagnosed;
mod folder;
mod folder_images;
mod folder_workgroups;
mod fuzz;
mod kinds;
mod once;
mod promises;
mod ranges;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use afterimage_graph::check::{CheckOptions, Graph, Loader, check};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::parse;
use afterimage_graph::node::Registry;

/// Files of the folder of cases.
struct CaseFiles;

impl Loader for CaseFiles {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        std::fs::read(folder().join(path)).map(Into::into).map_err(|_| "there is no such file".into())
    }
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/errors")
}

/// Parses and checks a text; all errors and warnings.
fn checked(name: &str, text: &str) -> Result<(Graph, Diagnostics), Diagnostics> {
    let option = |word: &str| {
        let prefix = format!("//! {word}: ");
        text.lines().filter_map(|line| line.strip_prefix(&prefix).map(str::to_owned)).collect::<Vec<_>>()
    };
    let set =
        |set: String| set.split_once('=').map(|(key, value)| (key.to_owned(), value.to_owned())).expect("`key=value`");
    let registry = Registry::new(&[kinds::ALL]).expect("the kinds have different names");
    let sets = option("set").into_iter().map(set).collect();
    let options = CheckOptions { tier: option("tier").pop(), sets, loader: &CaseFiles };
    check(&parse(name, text)?, &registry, &options)
}

fn reported(name: &str, text: &str) -> String {
    match checked(name, text) {
        Ok((_, warnings)) => warnings.to_string(),
        Err(all) => all.to_string(),
    }
}

#[test]
fn every_broken_file_has_exactly_its_expected_report() {
    let bless = std::env::var_os("AFTERIMAGE_BLESS").is_some();
    let mut names: Vec<PathBuf> =
        std::fs::read_dir(folder()).expect("the folder of cases").map(|e| e.expect("an entry").path()).collect();
    names.sort();
    let cases: Vec<&PathBuf> = names.iter().filter(|path| path.extension().is_some_and(|e| e == "ron")).collect();
    assert!(cases.len() >= 40, "only {} cases", cases.len());
    let mut wrong = Vec::new();
    for case in cases {
        let name = case.file_name().expect("a file has a name").to_string_lossy();
        let text = std::fs::read_to_string(case).expect("a case is text");
        let found = reported(&name, &text);
        let path = case.with_extension("txt");
        if bless {
            std::fs::write(&path, &found).expect("the folder of cases can be written");
        }
        let expected = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(!found.is_empty(), "`{name}` is not wrong");
        if found != expected {
            wrong.push(format!("`{name}` tells\n{found}\nand not\n{expected}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_expected_text_belongs_to_a_case() {
    for entry in std::fs::read_dir(folder()).expect("the folder of cases") {
        let path = entry.expect("an entry").path();
        let is_text = path.extension().is_some_and(|e| e == "txt");
        assert!(!is_text || path.with_extension("ron").is_file(), "{} has no case", path.display());
    }
}

#[test]
fn json_has_the_location_that_the_text_has() {
    let text = "Pipeline(\n  inputs: { \"ä\": Color },\n  nodes: {},\n  outputs: { \"ö\": \"ü\" },\n)\n";
    let all = checked("umlaut.ron", text).expect_err("nothing is called `ü`");
    let json = all.to_json();
    let label = &json[0]["labels"][0];
    assert_eq!(
        (&label["line"], &label["column"], &label["end_column"]),
        (&4.into(), &19.into(), &22.into()),
        "{json:#}"
    );
    assert_eq!((json[0]["code"].as_str(), json[0]["severity"].as_str()), (Some("unknown-name"), Some("error")));
    assert_eq!(label["file"], "umlaut.ron");
}

/// `main` prints the error that it returns by `Debug`.
#[test]
fn an_error_of_main_is_a_text_with_an_excerpt() {
    let errors = checked("look.ron", "Pipeline(nodes: { \"a\" Exposure() })").expect_err("a colon is missing");
    let error: Box<dyn std::error::Error> = Box::new(errors);
    let printed = format!("Error: {error:?}");
    assert!(printed.starts_with("Error: \nerror["), "{printed}");
    assert!(printed.contains("--> look.ron:1:") && printed.contains("^"), "{printed}");
}
