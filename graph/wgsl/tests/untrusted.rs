//! Untrusted files: what is refused, where, and that the limits hold before a parser or a driver sees the file.

use std::time::{Duration, Instant};

use crate::hostile::bombs::{bombs, in_body};
use afterimage_base::diagnostic::Diagnostics;
use afterimage_wgsl::limits::{self, Limit};
use afterimage_wgsl::{Library, Linker, SampleMode, Shader, ShaderError, validate};

fn untrusted(text: &str) -> Shader {
    Shader::untrusted("kind.wgsl".into(), text.into())
}

fn refused(text: &str) -> ShaderError {
    let start: String = text.chars().take(200).collect();
    let error = untrusted(text).reflect().expect_err(&start);
    assert_eq!(error.file, "kind.wgsl", "{error}");
    assert!(error.line > 0 && error.column > 0, "{error}");
    error
}

#[test]
fn what_a_function_of_one_pixel_cannot_hold_is_refused_at_its_place() {
    let whole = in_body("return source;");
    for (before, message, column) in [
        ("var<workgroup> w: array<f32, 64>;", "no memory of a workgroup", 16),
        ("var<workgroup> w: atomic<u32>;", "no memory of a workgroup", 16),
        ("var<immediate> f: f32;", "which the framework makes by itself", 16),
        ("var<private> p: f32 = 0.0;", "keeps nothing outside of itself", 14),
        ("@group(0) @binding(9) var<uniform> f: f32;", "is bound to a resource", 36),
        ("@group(0) @binding(9) var<storage, read_write> f: array<u32>;", "is bound to a resource", 48),
        ("@group(0) @binding(9) var t: texture_2d<f32>;", "is bound to a resource", 27),
        ("var s: sampler;", "is bound to a resource", 5),
        ("@compute @workgroup_size(1) fn main() { }", "belongs to an entry point", 1),
        ("@fragment fn main() -> @location(0) vec4f { return vec4f(); }", "belongs to an entry point", 1),
        ("@id(3) override gain = 2.0;", "belongs to an entry point", 1),
        ("struct Place { @location(0) at: vec4f }", "belongs to an entry point", 16),
        ("const ONE = 1; struct Place { at: vec4f, @builtin(position) up: vec4f }", "belongs to an entry point", 42),
        ("override gain: f32;", "nothing sets this `override`", 1),
        ("enable f16;", "without extensions", 1),
        ("requires readonly_and_readwrite_storage_textures;", "without extensions", 1),
        ("diagnostic(off, derivative_uniformity);", "without extensions", 1),
    ] {
        let error = refused(&format!("{before}\n{whole}"));
        assert!(error.message.contains(message), "{before}: {error}");
        assert_eq!((error.line, error.column), (1, column), "{before}: {error}");
    }
    for (body, message) in [
        ("workgroupBarrier(); return source;", "cannot wait for others"),
        ("storageBarrier(); return source;", "cannot wait for others"),
        ("textureBarrier(); return source;", "cannot wait for others"),
        ("return subgroupAdd(source);", "does not see its neighbors"),
        ("return quadSwapX(source);", "does not see its neighbors"),
        ("return source * f32(f64(2.0));", "numbers have 32 bits"),
        ("return source * f32(i64(2));", "numbers have 32 bits"),
        ("return source * f32(u64(2));", "numbers have 32 bits"),
        ("let wide = 2.5lf; return source;", "numbers have 32 bits"),
        ("let wide = 2li; return source;", "numbers have 32 bits"),
        ("let half = 2.5h; return source;", "numbers have 32 bits"),
        ("return dpdx(source);", "neighboring pixels"),
        ("if source.x > 1.0 { discard; } return source;", "cannot discard a pixel"),
        ("loop { } return source;", "this loop never ends"),
        ("return __1_sanitize(source);", "__1_sanitize"),
    ] {
        let error = refused(&format!("// a line\n{}", in_body(body)));
        assert!(error.message.contains(message), "{body}: {error}");
        assert_eq!(error.line, 2, "{body}: {error}");
    }
}

/// naga's validator accepts these; the compiler behind it, or a device, does not.
#[test]
fn what_only_a_device_would_refuse_is_refused_at_its_line() {
    let order = "fn order(a: ptr<function, f32>, b: ptr<function, f32>) { *b = max(*a, *b); }";
    for (before, body, message) in [
        (order, "var v = array<f32, 3>(); order(&v[0], &v[1]); return source;", "pointers to whole variables"),
        (
            order,
            "var v = array<array<f32, 2>, 2>(); let p = &v[1]; order(&(*p)[0], &v[0][1]); return source;",
            "pointers to whole variables",
        ),
        ("override N: i32 = 5;", "var v = array<f32, 3>(); return vec4f(v[N]);", "out of bounds"),
        ("override N: u32 = 40u;", "return vec4f(f32(u32(source.x) << N));", "hift"),
        ("override N: i32 = 0;", "return vec4f(f32(7 / N));", "ivision"),
    ] {
        let error = refused(&format!("{before}\n{}", in_body(body)));
        assert!(error.message.contains(message), "{body}: {error}");
        assert_eq!(error.line, 2, "{body}: {error}");
    }
}

#[test]
fn copies_of_arrays_count_as_what_they_take_to_compile() {
    let pick = "fn pick(v: array<f32, 8>, i: i32) -> f32 { var all = v; return all[i & 7]; }";
    let made = "let a = array(source.x, source.y, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0); var s = source;";
    let copies = |count: usize| {
        let uses = "s += pick(a, i32(s.x));".repeat(count);
        format!("{pick}\n{}", in_body(&format!("{made} {uses} return s;")))
    };
    untrusted(&copies(6)).reflect().unwrap_or_else(|error| panic!("{error}"));
    assert!(refused(&copies(16)).message.contains(limits::OPERATIONS.counts));
}

#[test]
fn an_override_is_a_constant_of_its_file() {
    let shader =
        untrusted(&format!("override N: i32 = 2;\n{}", in_body("var v = array<f32, 3>(); return vec4f(v[N]);")));
    shader.reflect().unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn what_is_of_another_language_is_told_with_what_to_write() {
    let whole = in_body("return source;");
    for (before, message, help) in [
        ("use a::b;", "`use` is not WGSL", "`import super::name::item;`"),
        ("#include \"a.wgsl\"", "`#include` is not WGSL", "`import super::name::item;`"),
        ("#import color", "`#import` is not WGSL", "`import afterimage::color::luminance;`"),
        ("#import a::b", "`#import` is not WGSL", "`import super::name::item;`"),
        ("#ifdef SHADOWS", "`#ifdef` is not WGSL", "branch on a parameter"),
        ("#define TWO 2.0", "`#define` is not WGSL", "write a `const`"),
        ("#pragma once", "`#pragma` is not WGSL", ""),
        ("@if(SHADOWS) const TWO = 2.0;", "`@if` is not WGSL", "branch on a parameter"),
        ("@inline fn two() { }", "no such attribute", ""),
    ] {
        let error = refused(&format!("{before}\n{whole}"));
        assert!(error.message.contains(message), "{before}: {error}");
        assert!(error.help.as_deref().unwrap_or_default().contains(help), "{before}: {error}");
        assert_eq!(error.line, 1, "{before}: {error}");
    }
    let error = refused(&in_body("\n@if(FOO) let x = 1;\nreturn source;"));
    assert!(error.message.contains("`@if` is not WGSL") && error.line == 2, "{error}");
}

#[test]
fn the_code_that_repairs_host_images_does_not_count() {
    let reads = "s += tap(image, image_sampler, at.uv + s.xy) + texel(image, at.pixel);".repeat(20);
    let text = format!(
        "fn kind(image: texture_2d<f32>, image_sampler: sampler, at: Point) -> vec4f {{
    var s = vec4f();
    {reads}
    return s;
}}"
    );
    untrusted(&text).reflect().unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn names_of_the_author_may_begin_like_forbidden_ones() {
    let text = "fn atomics(x: vec4f) -> vec4f { let f64_ = x; return f64_; }\n\
                struct Pair { atomic: f32, workgroupBarrier: f32 }\n\
                fn subgroupAdd(x: vec4f) -> vec4f { return atomics(x); }\n";
    let text = format!("{text}{}", in_body("var p: Pair; p.atomic = 1.0; return subgroupAdd(source) * p.atomic;"));
    untrusted(&text).reflect().unwrap_or_else(|error| panic!("{error}"));
    let set = format!("override gain = 2.0;\n{}", in_body("return source * gain;"));
    untrusted(&set).reflect().unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn what_an_imported_file_holds_is_refused_in_that_file() {
    let import = |helper: &str, name: &str| {
        let library = Library::of_files([(name.to_owned(), helper.to_owned())], []);
        let name = name.trim_end_matches(".wgsl");
        let own = format!("\nimport super::{name}::help;\n{}", in_body("return source * help();"));
        untrusted(&own).with_loaded_library(library).reflect().expect_err(helper).to_string()
    };
    let bound = import("@group(0) @binding(0) var<uniform> f: f32;\nfn help() -> f32 { return f; }", "own.wgsl");
    assert!(bound.starts_with("own.wgsl:1:36: this is bound to a resource"), "{bound}");
    let unset = import("\noverride q: f32;\nfn help() -> f32 { return q; }", "own.wgsl");
    assert!(unset.starts_with("own.wgsl:2:1: nothing sets"), "{unset}");
    let invocation = "import afterimage::workgroup::Invocation;\n";
    let text = invocation.to_owned() + &in_body("let i = Invocation(0u); return source * f32(i.index);");
    untrusted(&text).reflect().unwrap_or_else(|error| panic!("a struct needs no workgroup: {error}"));
    let body = "return source * f32(workgroup_scan(Invocation(0u), 1u, 1u).x);";
    let import = "import afterimage::math::power;\nimport afterimage::workgroup::{Invocation, workgroup_scan};\n";
    let error = refused(&format!("{import}{}", in_body(body)));
    assert!(error.message.contains("of a workgroup") || error.message.contains("wait for others"), "{error}");
    assert_eq!((error.line, error.column), (2, 32), "{error}");
}

/// The limit that refuses each bomb.
const LIMITS: [(&str, Limit); 27] = [
    ("a long comment", limits::FILE_BYTES),
    ("many tokens", limits::FILE_TOKENS),
    ("many imports", limits::IMPORTS),
    ("minus signs", limits::NESTING),
    ("parentheses", limits::NESTING),
    ("calls", limits::NESTING),
    ("blocks", limits::NESTING),
    ("a sum", limits::OPERATORS),
    ("a conjunction", limits::OPERATORS),
    ("swizzles", limits::OPERATORS),
    ("branches", limits::OPERATORS),
    ("types", limits::OPERATORS),
    ("functions", limits::DECLARATIONS),
    ("a call tree", limits::OPERATIONS),
    ("long code", limits::OPERATIONS),
    ("a chain of calls", limits::CALLS),
    ("loops", limits::LOOPS),
    ("powers", limits::OPERATIONS),
    ("a chain of sums", limits::OPERATIONS),
    ("a chain of maxima", limits::OPERATIONS),
    ("a chain of choices", limits::OPERATIONS),
    ("a chain behind returns", limits::OPERATIONS),
    ("doubling types", limits::VALUE_TOKENS),
    ("doubling constants", limits::VALUE_TOKENS),
    ("a large value", limits::VALUE_BYTES),
    ("large variables", limits::ARRAY_BYTES),
    ("variables of calls", limits::ARRAY_BYTES),
];

#[test]
fn every_bomb_is_refused_by_its_limit_and_soon() {
    let all = bombs(1);
    assert_eq!(all.len(), LIMITS.len());
    for (what, text) in all {
        let limit = LIMITS.iter().find(|(name, _)| *name == what).unwrap_or_else(|| panic!("{what} has no limit")).1;
        let start = Instant::now();
        let error = refused(&text);
        let took = start.elapsed();
        let expected = format!("too many {}: the limit is {}", limit.counts, limit.max);
        assert_eq!(error.message, expected, "{what}: {error}");
        assert!(took < Duration::from_secs(2), "{what} took {took:?}");
    }
}

#[test]
fn the_variables_of_a_function_count_together() {
    let with = |count: usize| {
        let variables: String = (0..count).map(|at| format!("var v{at}: array<f32, 100>; ")).collect();
        in_body(&format!("{variables} return source + v0[u32(source.x)];"))
    };
    untrusted(&with(2)).reflect().unwrap_or_else(|error| panic!("800 bytes: {error}"));
    assert!(refused(&with(3)).message.contains(limits::ARRAY_BYTES.counts));
}

/// The text of the module that a pass of an untrusted function becomes.
fn linked(text: &str) -> String {
    let shader = untrusted(text);
    let mut linker = Linker::new(SampleMode::Plain);
    let instance = linker.add(shader.source(), &[]).unwrap_or_else(|error| panic!("{error}"));
    let before = linker.before_call(limits::LOOP_STEPS).unwrap_or_default();
    let call = linker.name(instance, "kind");
    let code = format!("@fragment\nfn run() -> @location(0) vec4f {{ {before} return {call}(vec4f()); }}");
    let linked = linker.link(code, &[(afterimage_wgsl::Instance::GENERATED, "run")]).expect("all names are known");
    validate(&linked.text, &linked.map).unwrap_or_else(|error| panic!("{error}\n{}", linked.text));
    linked.text
}

#[test]
fn the_steps_of_every_loop_are_counted_whatever_its_form() {
    let text = linked(&in_body(
        "var s = source; let is_last_step = 1.0; /* for { */
        for (var i = 0; i < 4; i++) { s += is_last_step; }
        while s.x < 1.0 /* { */ { s *= 2.0; }
        loop { if s.x > 9.0 { break; } continuing { s += 1.0; } }
        return s;",
    ));
    let counted = "{ if loops_is_last_step() { break; }";
    assert_eq!(text.matches(counted).count(), 3, "{text}");
    for begin in ["i++) ", "{ */ ", "loop "] {
        assert!(text.contains(&format!("{begin}{counted}")), "after `{begin}`: {text}");
    }
    let nested = linked(&in_body("var s = source; while s.x < 1.0 { if s.y > 0.0 { s *= 2.0; } } return s;"));
    assert!(nested.contains("while s.x < 1.0 { if is_last_step() { break; }"), "{nested}");
    let begin = format!("begin_steps({});", limits::LOOP_STEPS.max);
    assert_eq!(text.matches(&begin).count(), 1, "{text}");
    let plain = linked(&in_body("return source;"));
    assert!(!plain.contains("steps"), "{plain}");
}

#[test]
fn a_declaration_without_an_end_is_reported_where_it_stops() {
    // The parser goes on with what the linker puts behind it: files of the library that no other imports.
    for import in ["color::luminance", "workgroup::Invocation", "noise::hash"] {
        for cut in ["fn kind(source: vec4f) -> vec4f", "fn kind(source: vec4f)", "const A: f32 ="] {
            let text = format!("import afterimage::{import};\nfn first(x: vec4f) -> vec4f {{ return x; }}\n{cut}");
            let error = refused(&text);
            assert_eq!(error.line, 3, "{import} {cut}: {error}");
        }
    }
}

#[test]
fn a_wrong_use_of_the_library_is_reported_where_it_is_used() {
    for body in [
        "let p = Point(0.5, source); return source;",
        "return sanitize(source.x);",
        "return sanitize(source, source);",
        "var p: Point; p.pixel = source; return source;",
        "return source * between(1, 2);",
    ] {
        let error = refused(&format!("\n{}", in_body(body)));
        assert_eq!(error.line, 2, "{body}: {error}");
    }
}

#[test]
fn a_lone_semicolon_is_no_declaration() {
    let text = format!(";;\nconst ONE = 1.0;;\n; {};", in_body("return source * ONE;").trim_end());
    let kernel = untrusted(&text);
    let reflection = kernel.reflect().unwrap_or_else(|error| panic!("{error}"));
    assert!(reflection.function("kind").is_some());
    let error = refused(&format!(";\n;;\n{}", in_body("return sauce;")));
    assert_eq!((error.line, error.column), (3, 42), "{error}");
    assert!(error.message.starts_with("no definition in scope"), "{error}");
}

/// An error is shown in the text of its own file; of a file that is imported, only the place is known.
#[test]
fn an_error_is_shown_in_the_file_that_it_is_in() {
    let wrong = "fn help() -> f32 {\n    return sauce;\n}";
    let own = untrusted(&format!("{wrong}\n{}", in_body("return source * help();")));
    let library = Library::of_files([("other.wgsl".to_owned(), wrong.to_owned())], []);
    let importing = untrusted(&format!("import super::other::help;\n{}", in_body("return source * help();")));
    for (shader, file, is_shown) in
        [(own, "kind.wgsl", true), (importing.with_loaded_library(library), "other.wgsl", false)]
    {
        let error = shader.reflect().expect_err("a name is unknown");
        assert_eq!((error.file.as_str(), error.line, error.column), (file, 2, 12), "{error}");
        let mut diagnostics = Diagnostics::default();
        shader.report(&error, &mut diagnostics);
        let text = diagnostics.to_string();
        assert!(text.contains(&format!("{file}:2:12")) && text.contains("sauce"), "{text}");
        assert_eq!(text.contains("return sauce;"), is_shown, "{text}");
        assert_eq!(diagnostics.iter().map(|one| one.labels.len()).sum::<usize>(), usize::from(is_shown), "{text}");
    }
}

#[test]
fn one_declaration_more_than_the_limit_is_refused() {
    let constants: String = (0..=limits::DECLARATIONS.max).map(|at| format!("const c{at} = 1.0;\n")).collect();
    let error = refused(&format!("{constants}fn untrusted(source: vec4f) -> vec4f {{ return source; }}"));
    assert!(error.message.starts_with("too many declarations"), "{error}");
}
