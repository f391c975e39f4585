//! What is reported of folders whose functions share memory of a workgroup.

use afterimage_graph::node::folder_kind;

const DECLARATION: &str = r#"Kind(
    name: "Shares",
    doc: "Shares memory.",
    inputs: { "source": Image(doc: "A picture.") },
    images: { "between": Image(function: "alone") },
    outputs: {
        "result": Image(doc: "Another.", state: Same("source"), workgroup: (8, 4)),
    },
)
"#;

const SHADER: &str = "import afterimage::workgroup::Invocation;
var<workgroup> words: array<u32, 32>;
fn alone(source: vec4f) -> vec4f { return 2.0 * source; }
fn shares(between: vec4f, at: Point, invocation: Invocation) -> vec4f {
    words[invocation.index] = u32(between.x);
    workgroupBarrier();
    return between * f32(words[31u - invocation.index]);
}
";

fn report(declaration: (&str, &str), shader: (&str, &str)) -> Option<String> {
    let (declared, text) = (DECLARATION.replace(declaration.0, declaration.1), SHADER.replace(shader.0, shader.1));
    assert!(declared != DECLARATION || text != SHADER || declaration == shader, "nothing is changed");
    folder_kind(("node.ron", &declared), ("shares.wgsl", &text)).err().map(|reported| reported.to_string())
}

const SAME: (&str, &str) = ("Kind", "Kind");

#[test]
fn a_function_with_a_workgroup_becomes_a_kind() {
    assert_eq!(report(SAME, SAME), None);
    for sides in ["(256, 1)", "(1, 256)", "(16, 16)", "(1, 1)"] {
        assert_eq!(report(("(8, 4)", sides), SAME), None, "{sides}");
    }
}

#[test]
fn a_workgroup_is_two_whole_numbers_within_the_limit() {
    for (sides, message) in [
        ("(16, 17)", "too many invocations in a workgroup: the limit is 256"),
        ("(9223372036854775807, 2)", "too many invocations in a workgroup: the limit is 256"),
        ("(0, 4)", "`workgroup` is the invocations across and down, `(16, 16)`"),
        ("(8, -4)", "`workgroup` is the invocations across and down"),
        ("(8, 4, 1)", "`workgroup` is the invocations across and down"),
        ("(8.0, 4)", "`workgroup` is the invocations across and down"),
        ("32", "`workgroup` is the invocations across and down"),
    ] {
        let reported = report(("(8, 4)", sides), SAME).unwrap_or_else(|| panic!("{sides} is accepted"));
        assert!(reported.contains(message) && reported.contains("node.ron:7:76"), "{sides}:\n{reported}");
    }
    let declared = ("Image(function: \"alone\")", "Pyramid(down: \"source\", levels: 2, workgroup: (8, 4))");
    let reported = report(declared, ("fn alone", "fn shares_between")).expect("a pyramid has no workgroup");
    assert!(reported.contains("has no field `workgroup`"), "{reported}");
}

#[test]
fn only_functions_with_a_workgroup_share_memory() {
    let reported = report((", workgroup: (8, 4)", ""), SAME).expect("nothing has a workgroup");
    assert!(reported.contains("shares.wgsl:2:16") && reported.contains("declares a `workgroup`"), "{reported}");
    for shader in [
        ("return 2.0 * source", "return source * f32(words[0])"),
        ("return 2.0 * source", "workgroupBarrier(); return source"),
        ("return 2.0 * source", "wait(); return source"),
    ] {
        let text =
            SHADER.replace(shader.0, shader.1).replace("fn alone(", "fn wait() { workgroupBarrier(); }\nfn alone(");
        let reported = folder_kind(("node.ron", DECLARATION), ("shares.wgsl", &text)).err();
        let reported = reported.unwrap_or_else(|| panic!("{} is accepted", shader.1)).to_string();
        assert!(reported.contains("`alone` shares memory of a workgroup, which it has not"), "{reported}");
        assert!(reported.contains("shares.wgsl:4:4"), "{reported}");
    }
    let reported = report(SAME, ("alone(source: vec4f)", "alone(source: vec4f, invocation: Invocation)"));
    let reported = reported.expect("`alone` has no workgroup");
    assert!(reported.contains("shares.wgsl:3:25") && reported.contains("`workgroup: (16, 16)`"), "{reported}");
    let reported = report(SAME, ("invocation", "place")).expect("it has another name");
    assert!(reported.contains("shares.wgsl:4:38"), "{reported}");
}

#[test]
fn a_barrier_in_a_branch_is_reported_at_its_line() {
    let reported = report(SAME, ("workgroupBarrier();", "if between.x > 1.0 {\n        workgroupBarrier();\n    }"));
    let reported = reported.expect("invocations may not arrive");
    assert!(reported.contains("shares.wgsl:7:9") && reported.contains("not every invocation"), "{reported}");
}
