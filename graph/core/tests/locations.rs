//! Where errors are: the text under a label is what is wrong.

use afterimage_graph::check::{CheckOptions, check};
use afterimage_graph::diagnostic::{Diagnostics, Severity};
use afterimage_graph::document::parse;
use afterimage_graph::node::Registry;

const TEXT: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: { "a": Exposure(source: "scene"), "b": Vignette(source: "a") },
    outputs: { "out": "b" },
)"#;

fn checked(text: &str, sets: &[(&str, &str)]) -> Diagnostics {
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("the kinds have different names");
    let sets = sets.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let document = match parse("a.ron", text) {
        Ok(document) => document,
        Err(errors) => return errors,
    };
    match check(&document, &registry, &CheckOptions { sets, ..CheckOptions::default() }) {
        Ok((_, warnings)) => warnings,
        Err(errors) => errors,
    }
}

/// Each wrong setting of a command line is shown at its own place in it.
#[test]
fn a_wrong_setting_is_shown_where_it_stands_among_the_others() {
    let right = [("a.stops", "1.5"), ("b.amount", "0.25"), ("a.stops", "-2.0")];
    for (key, value, is_key) in [("a.stops", "zz", false), ("b.amont", "0.5", true), ("cc", "On", true)] {
        for place in 0..=right.len() {
            let mut sets = right.to_vec();
            sets.insert(place, (key, value));
            let line: Vec<String> = sets.iter().map(|(key, value)| format!("{key}={value}")).collect();
            let all = line.join("\n");
            let errors = checked(TEXT, &sets);
            let label = errors.iter().flat_map(|error| &error.labels).find(|label| &*label.location.file != "a.ron");
            let location = &label.unwrap_or_else(|| panic!("{sets:?}: {errors}")).location;
            let begin: usize = line[..place].iter().map(|line| line.len() + 1).sum();
            let (start, length) = if is_key { (begin, key.len()) } else { (begin + key.len() + 1, value.len()) };
            let shown = &all[location.start..location.end];
            assert_eq!((location.start, location.end), (start, start + length), "{sets:?}: `{shown}`\n{errors}");
        }
    }
}

/// What is meant as a comment begins with a sign that is shown.
#[test]
fn a_sign_that_begins_no_token_is_shown() {
    for (text, sign) in [("# words\nPipeline()", "#"), ("Pipeline(\n# words\n)", "#"), ("Pipeline() %", "%")] {
        let errors = checked(text, &[]);
        let shown = |error: &afterimage_graph::diagnostic::Diagnostic| {
            let location = &error.labels[0].location;
            text[location.start..location.end].to_owned()
        };
        assert!(errors.iter().any(|error| shown(error) == sign), "{text:?}: {errors}");
    }
}

/// An input that is handed to an inner pipeline counts as read although the inner one does not use it.
#[test]
fn only_inputs_that_nothing_names_are_unread() {
    let inner = r#"Pipeline(
        inputs: { "picture": Color, "spare": Color(optional: true) },
        nodes: { "x": Exposure(source: "picture") },
        outputs: { "result": "x" },
    )"#;
    struct Inner(&'static str);
    impl afterimage_graph::check::Loader for Inner {
        fn load(&self, path: &str) -> Result<std::sync::Arc<[u8]>, String> {
            if path == "inner.ron" { Ok(self.0.as_bytes().into()) } else { Err("there is no such file".into()) }
        }
    }
    let text = r#"Pipeline(
        inputs: { "scene": Color, "handed": Color, "left": Color },
        nodes: { "inner": Pipeline(file: "inner.ron", picture: "scene", spare: "handed") },
        outputs: { "out": "inner" },
    )"#;
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("the kinds have different names");
    let options = CheckOptions { loader: &Inner(inner), ..CheckOptions::default() };
    let document = parse("a.ron", text).unwrap_or_else(|errors| panic!("{errors}"));
    let (_, warnings) = check(&document, &registry, &options).unwrap_or_else(|errors| panic!("{errors}"));
    let unread: Vec<&str> = warnings.iter().filter(|one| one.code == "unread-input").map(|one| &*one.message).collect();
    assert_eq!(unread, ["nothing reads the input `left`"], "{warnings}");
    assert!(warnings.iter().all(|one| one.severity == Severity::Warning));
}
