//! Untrusted files whose functions share memory of a workgroup: what they may hold, and where a barrier may stand.

use afterimage_wgsl::limits::{BARRIERS, WORKGROUP_BYTES};
use afterimage_wgsl::{ArgType, Shader, ShaderError};

fn shared(text: &str) -> Shader {
    Shader::untrusted("kind.wgsl".into(), text.into()).with_workgroups()
}

fn refused(text: &str) -> ShaderError {
    let error = shared(text).reflect().expect_err(text);
    assert_eq!(error.file, "kind.wgsl", "{error}");
    error
}

/// A file with shared memory and a function around that body; the body begins in line 4.
fn with_body(body: &str) -> String {
    with_more("", body)
}

/// The same with more declarations, which begin in line 2.
fn with_more(more: &str, body: &str) -> String {
    format!(
        "import afterimage::workgroup::{{Invocation, workgroup_sum}};\n\
         {more}var<workgroup> sums: array<atomic<u32>, 4>;\n\
         fn kind(source: vec4f, at: Point, invocation: Invocation) -> vec4f {{\n{body}\nreturn source;\n}}"
    )
}

#[test]
fn functions_with_a_workgroup_share_memory_and_wait() {
    let text = "import afterimage::workgroup::{Invocation, workgroup_sum};
var<workgroup> tile: array<vec4f, 256>;
var<workgroup> count: atomic<u32>;
fn wait() { workgroupBarrier(); }
fn kind(source: vec4f, invocation: Invocation) -> vec4f {
    tile[invocation.index] = source;
    if source.x > 0.5 { atomicAdd(&count, 1u); }
    wait();
    for (var step = 0u; step < 4u; step++) { if tile[step].x < 0.0 { return tile[step]; } }
    { let sum = workgroup_sum(invocation, 256u, source.xy); }
    return source;
}
fn alone(source: vec4f) -> vec4f { return 2.0 * source; }";
    // A loop that may return stands before the barriers of `workgroup_sum`.
    assert_eq!(refused(text).line, 10);
    let text = text.replace("return tile[step]; }", "break; }");
    let shader = shared(&text);
    let reflection = shader.reflect().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(reflection.sharing, ["wait", "kind"]);
    let function = reflection.function("kind").expect("it returns a pixel");
    assert_eq!(function.args[1], ("invocation".to_owned(), ArgType::Invocation));
    let error = Shader::untrusted("kind.wgsl".into(), text).reflect().map(|_| ()).expect_err("it has no workgroup");
    assert!(error.message.contains("declares a `workgroup`"), "{error}");
}

#[test]
fn a_barrier_stands_where_every_invocation_arrives() {
    for body in [
        "if source.x > 0.0 { workgroupBarrier(); }",
        "if source.x > 0.0 { } else { workgroupBarrier(); }",
        "for (var step = 0; step < 4; step++) { workgroupBarrier(); }",
        "for (var step = 0; step < 4; step++) { { workgroupBarrier(); } }",
        "loop { continuing { workgroupBarrier(); break if source.x > 0.0; } }",
        "switch i32(source.x) { case 1 { workgroupBarrier(); } default { } }",
        "if source.x > 0.0 { return source; } workgroupBarrier();",
        "while source.x > 0.0 { return source; } workgroupBarrier();",
        "{ if source.x > 0.0 { return source; } } { workgroupBarrier(); }",
        "if source.x > 0.0 { let all = workgroup_sum(invocation, 256u, source.xy); }",
        "let all = source.x > 0.0 && workgroup_sum(invocation, 256u, source.xy).x > 1.0;",
    ] {
        let error = refused(&with_body(body));
        assert!(error.message.starts_with("not every invocation may arrive at this barrier"), "{body}: {error}");
        assert_eq!(error.line, 4, "{body}: {error}");
    }
    for body in
        ["workgroupBarrier();", "{ workgroupBarrier(); }", "workgroupBarrier(); if source.x > 0.0 { return source; }"]
    {
        shared(&with_body(body)).reflect().unwrap_or_else(|error| panic!("{body}: {error}"));
    }
}

#[test]
fn what_devices_may_not_have_is_refused_also_with_a_workgroup() {
    for (body, message) in [
        ("let first = workgroupUniformLoad(&flag);", "only some devices check"),
        ("storageBarrier();", "cannot wait for others"),
        ("let sum = subgroupAdd(source.x);", "does not see its neighbors"),
        ("textureStore(out, at.pixel, source);", "writes only its result"),
    ] {
        let error = refused(&with_body(body).replace("\nfn kind", "var<workgroup> flag: u32;\nfn kind"));
        assert!(error.message.contains(message), "{body}: {error}");
    }
    for variable in ["var<private> x: f32;", "@group(0) @binding(0) var<storage, read_write> x: atomic<u32>;"] {
        assert_eq!(refused(&with_more(&format!("{variable}\n"), "")).line, 2, "{variable}");
    }
}

#[test]
fn memory_and_barriers_have_limits() {
    let memory = |bytes: usize| format!("var<workgroup> a: array<u32, {}>;\nvar<workgroup> b: vec4f;\n", bytes / 4 - 4);
    let uses = |text: String| with_more(&text, "a[0] = 1u; b = source;");
    let fits = WORKGROUP_BYTES.max - 16;
    shared(&uses(memory(fits))).reflect().unwrap_or_else(|error| panic!("{error}"));
    let error = refused(&uses(memory(fits + 16)));
    assert_eq!(Some(error.message.clone()), WORKGROUP_BYTES.exceeded(usize::MAX), "{error}");
    let doubled = format!("fn both() {{ {} }}\n", "workgroupBarrier();".repeat(BARRIERS.max / 2));
    shared(&with_more(&doubled, "both(); both();")).reflect().unwrap_or_else(|error| panic!("{error}"));
    let error = refused(&with_more(&doubled, "both(); both(); workgroupBarrier();"));
    assert_eq!((Some(error.message.clone()), error.line), (BARRIERS.exceeded(usize::MAX), 4), "{error}");
}
