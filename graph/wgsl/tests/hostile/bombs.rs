//! Shaders that take a parser or a driver very long, much memory or all of its stack.

/// A file with a kernel function `kind` of this body.
pub fn in_body(body: &str) -> String {
    format!("fn kind(source: vec4f) -> vec4f {{ {body} }}\n")
}

fn numbered(count: usize, item: impl Fn(usize) -> String) -> String {
    (0..count).map(item).collect()
}

/// Each bomb with its name. A part of 1 is the whole bomb; with a part of N it has N times less of what it has too many
/// of.
pub fn bombs(part: usize) -> Vec<(&'static str, String)> {
    let all = [nested(part), repeated(part), doubled(part), large(part)];
    all.into_iter().flatten().collect()
}

fn nested(part: usize) -> Vec<(&'static str, String)> {
    let nested = |open: &str, inner: &str, close: &str| {
        in_body(&format!("return {}{inner}{};", open.repeat(3800 / part), close.repeat(3800 / part)))
    };
    let blocks = format!("{}{} return source;", "{".repeat(3800 / part), "}".repeat(3800 / part));
    let types = format!("alias T = {}f32{};\n", "array<".repeat(1000 / part), ", 1>".repeat(1000 / part));
    let chain = numbered(900 / part, |i| format!("fn g{}(x: vec4f) -> vec4f {{ return g{i}(x); }}\n", i + 1));
    let last = in_body(&format!("return g{}(source);", 900 / part));
    vec![
        ("minus signs", nested("- ", "source", "")),
        ("parentheses", nested("(", "source", ")")),
        ("calls", nested("abs(", "source", ")")),
        ("blocks", in_body(&blocks)),
        ("types", types + &in_body("return source;")),
        ("a chain of calls", format!("fn g0(x: vec4f) -> vec4f {{ return x; }}\n{chain}{last}")),
    ]
}

fn repeated(part: usize) -> Vec<(&'static str, String)> {
    let line = in_body("return source;");
    let returning = |statement: &str, count: usize| {
        in_body(&format!("var s = source; {} return s;", statement.repeat(count / part)))
    };
    let conjunction = format!("let a = {}true; return source;", "true && ".repeat(6000 / part));
    let branches = "else if source.x > 1.0 { }".repeat(3000 / part);
    let early = "fn early(c: vec4f) -> vec4f {
    if c.x > 0.7 { return sin(c) * cos(c * 3.1) + tan(c); }
    if c.y > 0.5 { return exp(c) * tan(c.yzwx); }
    return c;
}
";
    let uses = in_body(&format!("let t = early(source); var s = t; {} return s;", "s += t; ".repeat(1500 / part)));
    let functions = numbered(3000 / part, |i| format!("fn g{i}(x: vec4f) -> vec4f {{ return x; }}\n"));
    vec![
        ("a long comment", format!("/*{}*/{line}", "x".repeat(3_000_000 / part))),
        ("many tokens", format!("{}{line}", ";".repeat(100_000 / part))),
        ("many imports", numbered(5000 / part, |i| format!("import afterimage::math::power as p{i};\n")) + &line),
        ("a sum", in_body(&format!("return {}source;", "source + ".repeat(3800 / part)))),
        ("a conjunction", in_body(&conjunction)),
        ("swizzles", in_body(&format!("return source{};", ".xyzw".repeat(5000 / part)))),
        ("branches", in_body(&format!("if source.x > 0.0 {{ }} {branches} return source;"))),
        ("functions", functions + &line),
        ("long code", returning("s = sin(s) * cos(s) + s.yzwx;", 3000)),
        ("loops", returning("for (var i = 0; i < 9; i++) { s += s.yzwx; }", 100)),
        ("powers", returning("s = pow(s, s.yzwx);", 200)),
        ("a chain of sums", returning("s += source;", 6000)),
        ("a chain of maxima", returning("s = max(s, source.yzwx + s);", 1800)),
        ("a chain of choices", returning("s = select(s, source + s, source.x > s.y);", 2500)),
        ("a chain behind returns", format!("{early}{uses}")),
    ]
}

/// Each of these has twice as much with each line.
fn doubled(part: usize) -> Vec<(&'static str, String)> {
    let less = part.ilog2() as usize;
    let (levels, sizes, steps) = (16 - less, 25 - less, 23 - less);
    let tree =
        numbered(levels, |i| format!("fn f{}(x: vec4f) -> vec4f {{ return f{i}(x) + f{i}(x * 0.5); }}\n", i + 1));
    let structs = numbered(sizes, |i| format!("struct S{} {{ a: S{i}, b: S{i} }}\n", i + 1));
    let arrays = numbered(steps, |i| format!("const A{} = array(A{i}, A{i});\n", i + 1));
    let call = in_body(&format!("return f{levels}(source);"));
    let value = in_body(&format!("var s = S{sizes}(); return source;"));
    let constant = in_body(&format!("let z = A{steps}; return source;"));
    vec![
        ("a call tree", format!("fn f0(x: vec4f) -> vec4f {{ return x * 1.5; }}\n{tree}{call}")),
        ("doubling types", format!("struct S0 {{ a: f32 }}\n{structs}{value}")),
        ("doubling constants", format!("const A0 = array(1.0, 1.0);\n{arrays}{constant}")),
    ]
}

fn large(part: usize) -> Vec<(&'static str, String)> {
    let value = format!("var z = array<f32, {}>(); return source * z[u32(source.x)];", 16_777_216 / part);
    let variable =
        format!("var z: array<f32, {}>; z[u32(source.y)] = 1.0; return source * z[u32(source.x)];", 8192 / part);
    let calls = in_body(&format!("var s = source; {} return s;", "s += big(s);".repeat(20)));
    let big = format!(
        "fn big(x: vec4f) -> vec4f {{ var z: array<vec4f, {}>; z[u32(x.y)] = x; return z[u32(x.x)]; }}\n",
        (64 / part).max(1)
    );
    vec![
        ("a large value", in_body(&value)),
        ("large variables", in_body(&variable)),
        ("variables of calls", big + &calls),
    ]
}
