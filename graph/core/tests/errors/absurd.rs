//! Files that no person writes: deep, long, endless.

use super::{checked, reported};

/// The first line of what is reported.
fn headline(text: &str) -> String {
    reported("absurd.ron", text).lines().next().unwrap_or_default().to_owned()
}

#[test]
fn deep_nesting_is_refused() {
    for (open, close) in [("[", "]"), ("(", ")"), ("{1:", "}"), ("A(", ")"), ("Some(", ")"), ("/*", "*/")] {
        let deep = format!("Pipeline(nodes: {}{}, outputs: {{}})", open.repeat(100_000), close.repeat(100_000));
        let reported = headline(&deep);
        assert!(reported.starts_with("error["), "{open}: {reported}");
    }
    let brackets = format!("Pipeline(nodes: {}1{}, outputs: {{}})", "[".repeat(5000), "]".repeat(5000));
    assert_eq!(headline(&brackets), "error[syntax]: brackets are nested too deeply");
}

#[test]
fn megabytes_are_refused() {
    let long = format!("Pipeline(nodes: {{}}, outputs: {{}}) // {}", "x".repeat(5 << 20));
    assert_eq!(
        headline(&long),
        format!("error[file-too-long]: the file has {} bytes, more than a pipeline can have", long.len())
    );
}

#[test]
fn a_long_line_is_named_and_not_shown() {
    let long = format!("Pipeline(nodes: {{}}, outputs: {{ \"display\": \"{}\" }})", "x".repeat(100_000));
    let reported = reported("absurd.ron", &long);
    assert!(reported.len() < 500, "{} bytes", reported.len());
    assert!(reported.contains("absurd.ron:1:43"), "{reported}");
}

#[test]
fn thousands_of_errors_are_counted() {
    let nodes: String = (0..3000).map(|n| format!("\"n{n}\": Nothing(), ")).collect();
    let reported = reported("absurd.ron", &format!("Pipeline(\n nodes: {{\n{nodes}\n}}, outputs: {{}})"));
    assert!(reported.ends_with("and 2950 more like these\n"), "{}", &reported[reported.len() - 200..]);
}

#[test]
fn too_many_nodes_are_refused() {
    let nodes: String = (0..17_000).map(|n| format!("\"{n}\":Tint(source:\"s\"),\n")).collect();
    let reported =
        headline(&format!("Pipeline(inputs: {{ \"s\": Color }}, nodes: {{\n{nodes}}}, outputs: {{ \"d\": \"0\" }})"));
    assert_eq!(reported, "error[too-many-nodes]: the pipeline has more than 16384 nodes");
}

#[test]
fn control_characters_do_not_reach_the_terminal() {
    let reported = reported(
        "absurd.ron",
        "Pipeline(nodes: { \"a\": Tint(source: \"\\u{1b}[31m\u{7}\") }, outputs: { \"d\": \"a\" })",
    );
    assert!(reported.chars().all(|c| c == '\n' || !c.is_control()), "{reported:?}");
    let reported = super::reported("ab\u{1b}[31m.ron", "Pipeline(nodes: { \"a\": Tint() }, outputs: { \"d\": \"a\" })");
    assert!(reported.contains("ab\\u001b[31m.ron") && !reported.contains('\u{1b}'), "{reported:?}");
}

/// Also those of the text that an error shows, at the places that it underlines.
#[test]
fn control_characters_of_an_excerpt_are_replaced() {
    let text = "Pipeline(/* \u{9b}2J \u{1b}[2J \u{85} \r \u{7f} \u{202e} */ nodes: { \"a\": Nothing() }, outputs: {})";
    let reported = reported("absurd.ron", text);
    assert!(reported.chars().all(|c| c == '\n' || !c.is_control()), "{reported:?}");
    let lines: Vec<&str> = reported.lines().collect();
    let place = |text: &str| lines.iter().find_map(|line| line.find(text).map(|at| line[..at].chars().count()));
    assert_eq!(place("Nothing()"), place("^^^^^^^"), "{reported}");
    assert!(reported.contains("/* ·2J ␛[2J · "), "{reported}");
}

#[test]
fn a_chain_of_sixteen_thousand_nodes_is_checked_in_order() {
    let nodes: String = (1..16_000).rev().map(|n| format!("\"{n}\":Tint(source:\"{}\"),\n", n - 1)).collect();
    let text = format!("Pipeline(inputs: {{ \"0\": Color }}, nodes: {{\n{nodes}}}, outputs: {{ \"d\": \"15999\" }})");
    let (graph, warnings) = checked("chain.ron", &text).expect("a long chain is no error");
    assert_eq!((graph.nodes.len(), graph.wires.edge_count(), warnings.len()), (15_999, 15_998, 0));
}
