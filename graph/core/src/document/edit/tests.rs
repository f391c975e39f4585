//! Where entries go in each layout.

use super::Editor;

/// The text after fields `p` and `q` of the node `a`, whose kind is `K`.
fn with_fields(text: &str) -> String {
    let mut editor = Editor::new(&"test".into(), text);
    let kind = text.find('K').expect("the node is there");
    editor.add_field(kind, "p", "1.0".to_owned());
    editor.add_field(kind, "q", "(1, 2)".to_owned());
    editor.text()
}

#[test]
fn fields_follow_the_layout_of_the_node() {
    for (before, after) in [
        ("K", "K(p: 1.0, q: (1, 2))"),
        ("K()", "K(p: 1.0, q: (1, 2))"),
        ("K( )", "K(p: 1.0, q: (1, 2) )"),
        ("K(/* c */)", "K(p: 1.0, q: (1, 2)/* c */)"),
        ("K /* c */ ()", "K /* c */ (p: 1.0, q: (1, 2))"),
        ("K(o: 0)", "K(o: 0, p: 1.0, q: (1, 2))"),
        ("K(o: 0,)", "K(o: 0, p: 1.0, q: (1, 2),)"),
        ("K( o: (0) /* c */ , )", "K( o: (0), p: 1.0, q: (1, 2) /* c */ , )"),
        ("K(o: 0, // c\n  n: 2)", "K(o: 0, // c\n  n: 2, p: 1.0, q: (1, 2))"),
        ("K(o: 0 // c\n /* ) */ )", "K(o: 0, p: 1.0, q: (1, 2) // c\n /* ) */ )"),
        ("K(\n    o: 0,\n)", "K(\n    o: 0,\n    p: 1.0,\n    q: (1, 2),\n)"),
        ("K(\n\to: 0 // c\n)", "K(\n\to: 0, // c\n\tp: 1.0,\n\tq: (1, 2)\n)"),
        ("K(\r\n  o: 0,\r\n)", "K(\r\n  o: 0,\r\n  p: 1.0,\r\n  q: (1, 2),\r\n)"),
        ("K(o: 0, n: 2,\n)", "K(o: 0, n: 2,\n    p: 1.0,\n    q: (1, 2),\n)"),
        ("K(\n  // c\n)", "K(\n  // c\n    p: 1.0,\n    q: (1, 2),\n)"),
    ] {
        let text = |node: &str| format!("Pipeline(nodes: {{ \"a\": {node} }}, outputs: {{}})");
        assert_eq!(with_fields(&text(before)), text(after), "{before}");
    }
}

/// The text after an override in `set` and one in the tier `t`.
fn with_overrides(text: &str) -> String {
    let mut editor = Editor::new(&"test".into(), text);
    editor.add_to_set("a.p", "1.0".to_owned());
    editor.add_to_tier("t", "b \"c\"", "Off".to_owned());
    editor.text()
}

#[test]
fn sections_are_made_where_there_are_none() {
    for (before, after) in [
        ("Pipeline()", r#"Pipeline(set: { "a.p": 1.0 }, tiers: { "t": { "b \"c\"": Off } })"#),
        ("Pipeline(x: 1,)", r#"Pipeline(x: 1, set: { "a.p": 1.0 }, tiers: { "t": { "b \"c\"": Off } },)"#),
        (
            "Pipeline(\n  x: 1\n)",
            "Pipeline(\n  x: 1,\n  set: {\n    \"a.p\": 1.0,\n  },\n  tiers: {\n    \"t\": {\n      \
             \"b \\\"c\\\"\": Off,\n    },\n  }\n)",
        ),
        (
            "Pipeline(\n  set: {},\n  tiers: { \"t\": {} },\n)",
            "Pipeline(\n  set: {\n    \"a.p\": 1.0,\n  },\n  tiers: { \"t\": {\n    \"b \\\"c\\\"\": Off,\n  } },\n)",
        ),
        (
            "Pipeline(set: {}, tiers: { \"u\": { \"v\": On } })",
            "Pipeline(set: { \"a.p\": 1.0 }, tiers: { \"u\": { \"v\": On }, \"t\": { \"b \\\"c\\\"\": Off } })",
        ),
        (
            "Pipeline(tiers: { \"t\": { } }, set: {\n\"x\": 1,\n})",
            "Pipeline(tiers: { \"t\": { \"b \\\"c\\\"\": Off } }, set: {\n\"x\": 1,\n\"a.p\": 1.0,\n})",
        ),
    ] {
        assert_eq!(with_overrides(before), after);
    }
}

#[test]
fn values_and_numbers_are_replaced() {
    let text = "Pipeline(a: 1, b: (1, /* 2 */ -2.5, +3e1,), c: \"x\")";
    let mut editor = Editor::new(&"test".into(), text);
    let span = |part: &str| {
        let start = text.find(part).expect("the part is there");
        start..start + part.len()
    };
    editor.replace(span("\"x\""), "\"y\"".to_owned());
    editor
        .replace_numbers(span("(1, /* 2 */ -2.5, +3e1,)"), vec![Some("4.0".to_owned()), None, Some("5.0".to_owned())]);
    assert_eq!(editor.text(), "Pipeline(a: 1, b: (4.0, /* 2 */ -2.5, 5.0,), c: \"y\")");
}
