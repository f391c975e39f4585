//! Files that no person writes: deep, long, endless.

use super::{checked, told};

/// The first line of what is reported.
fn headline(text: &str) -> String {
    told("absurd.ron", text).lines().next().unwrap_or_default().to_owned()
}

#[test]
fn deep_nesting_is_refused() {
    for (open, close) in [("[", "]"), ("(", ")"), ("{1:", "}"), ("A(", ")"), ("Some(", ")"), ("/*", "*/")] {
        let deep = format!("Pipeline(nodes: {}{}, outputs: {{}})", open.repeat(100_000), close.repeat(100_000));
        let told = headline(&deep);
        assert!(told.starts_with("error["), "{open}: {told}");
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
    let told = told("absurd.ron", &long);
    assert!(told.len() < 500, "{} bytes", told.len());
    assert!(told.contains("absurd.ron:1:43"), "{told}");
}

#[test]
fn thousands_of_mistakes_are_counted() {
    let nodes: String = (0..3000).map(|n| format!("\"n{n}\": Nothing(), ")).collect();
    let told = told("absurd.ron", &format!("Pipeline(\n nodes: {{\n{nodes}\n}}, outputs: {{}})"));
    assert!(told.ends_with("and 2950 more like these\n"), "{}", &told[told.len() - 200..]);
}

#[test]
fn too_many_nodes_are_refused() {
    let nodes: String = (0..66_000).map(|n| format!("\"{n}\":Tint(source:\"s\"),\n")).collect();
    let told =
        headline(&format!("Pipeline(inputs: {{ \"s\": Color }}, nodes: {{\n{nodes}}}, outputs: {{ \"d\": \"0\" }})"));
    assert_eq!(told, "error[too-many-nodes]: the pipeline has more than 65536 nodes");
}

#[test]
fn control_characters_do_not_reach_the_terminal() {
    let told =
        told("absurd.ron", "Pipeline(nodes: { \"a\": Tint(source: \"\\u{1b}[31m\u{7}\") }, outputs: { \"d\": \"a\" })");
    assert!(told.chars().all(|c| c == '\n' || !c.is_control()), "{told:?}");
    let told = super::told("ab\u{1b}[31m.ron", "Pipeline(nodes: { \"a\": Tint() }, outputs: { \"d\": \"a\" })");
    assert!(told.contains("ab\\u{1b}[31m.ron") && !told.contains('\u{1b}'), "{told:?}");
}

#[test]
fn a_chain_of_sixty_thousand_nodes_is_checked_in_order() {
    let nodes: String = (1..60_000).rev().map(|n| format!("\"{n}\":Tint(source:\"{}\"),\n", n - 1)).collect();
    let text = format!("Pipeline(inputs: {{ \"0\": Color }}, nodes: {{\n{nodes}}}, outputs: {{ \"d\": \"59999\" }})");
    let (graph, warnings) = checked("chain.ron", &text).expect("a long chain is no mistake");
    assert_eq!((graph.nodes.len(), graph.wires.edge_count(), warnings.len()), (59_999, 59_998, 0));
}
