//! Tests of the linker: each links files and lets naga judge the result.

use std::collections::BTreeSet;

use afterimage_wgsl::{Instance, Library, Linked, Linker, SampleMode, Shader, validate};

fn shader(file: &str, text: &str) -> Shader {
    Shader::loaded(file.into(), text.into())
}

fn linker<'a>() -> Linker<'a> {
    Linker::new(SampleMode::Plain)
}

/// A module of the functions, all called by one entry point.
fn calling(shaders: &[(&Shader, &str)]) -> Linked {
    let mut linker = linker();
    let mut calls = String::new();
    for (shader, call) in shaders {
        let instance = linker.add(shader.source(), &[]).unwrap_or_else(|error| panic!("{error}"));
        let (function, args) = call.split_once('(').expect("a call has arguments");
        calls += &format!("    sum += {}({args};\n", linker.name(instance, function));
    }
    let code =
        format!("@fragment\nfn run() -> @location(0) vec4f {{\n    var sum = vec4f();\n{calls}    return sum;\n}}");
    let linked = linker.link(code, &[(Instance::GENERATED, "run")]).unwrap_or_else(|error| panic!("{error}"));
    valid(&linked);
    linked
}

fn valid(linked: &Linked) -> naga::Module {
    validate(&linked.text, &linked.map).unwrap_or_else(|error| panic!("{error}\n{}", linked.text))
}

#[test]
fn two_files_may_have_the_same_names() {
    let text = "struct Params { gain: f32 }\nconst K = 2.0;\nfn helper(x: vec4f) -> vec4f { return K * x; }\n";
    let one = shader("one.wgsl", &format!("{text}fn main(x: vec4f) -> vec4f {{ return helper(x) + Params(K).gain; }}"));
    let two = shader("two.wgsl", &format!("{text}fn main(x: vec4f) -> vec4f {{ return helper(x) - Params(K).gain; }}"));
    let linked = calling(&[(&one, "main(vec4f())"), (&two, "main(vec4f())")]);
    for name in ["one_helper", "two_helper", "one_K", "two_K", "one_Params"] {
        assert!(linked.text.contains(name), "{name}:\n{}", linked.text);
    }
}

#[test]
fn names_stay_as_they_are_where_no_other_file_has_them() {
    let own = shader("own.wgsl", "fn gain(x: vec4f) -> vec4f { return 2.0 * x; }");
    let linked = calling(&[(&own, "gain(vec4f())")]);
    assert!(linked.text.contains("fn gain(x: vec4f)"), "{}", linked.text);
}

#[test]
fn a_file_may_declare_names_of_the_language_and_others_keep_them() {
    let one =
        shader("one.wgsl", "fn length(v: vec4f) -> vec4f { return v; }\nfn f(v: vec4f) -> vec4f { return length(v); }");
    let two = shader("two.wgsl", "fn f(v: vec4f) -> vec4f { return vec4f(length(v)); }");
    let linked = calling(&[(&one, "f(vec4f())"), (&two, "f(vec4f())")]);
    assert!(linked.text.contains("return one_length(v)"), "{}", linked.text);
    assert!(linked.text.contains("vec4f(length(v))"), "{}", linked.text);
}

#[test]
fn a_name_that_another_file_has_made_like_ours_gets_a_number() {
    let one = shader("one.wgsl", "fn f(v: vec4f) -> vec4f { return v; }");
    let two =
        shader("two.wgsl", "fn one_f(v: vec4f) -> vec4f { return v; }\nfn f(v: vec4f) -> vec4f { return one_f(v); }");
    let linked = calling(&[(&one, "f(vec4f())"), (&two, "f(vec4f())")]);
    assert!(linked.text.contains("fn one_f_2("), "{}", linked.text);
}

#[test]
fn locals_parameters_and_members_may_have_names_of_the_file() {
    let text = "struct gain { gain: f32, size: f32 }
const size = 3.0;
fn scale(gain: f32) -> f32 { let size = size * gain; return size; }
fn f(v: vec4f) -> vec4f {
    var g = gain(size, size);
    g.gain = scale(g.size);
    for (var size = 0; size < 2; size++) { g.size += f32(size); }
    return v * g.gain * size;
}";
    let (one, two) = (shader("one.wgsl", text), shader("two.wgsl", text));
    calling(&[(&one, "f(vec4f())"), (&two, "f(vec4f())")]);
}

#[test]
fn a_local_does_not_hide_what_a_file_imports() {
    let text = "import afterimage::color::luminance;
fn f(color_luminance: vec4f) -> vec4f {
    let luminance_2 = luminance(color_luminance.rgb);
    return vec4f(luminance_2);
}";
    let one = shader("one.wgsl", text);
    let two = shader("two.wgsl", "fn luminance(v: vec4f) -> vec4f { return v; }");
    let linked = calling(&[(&one, "f(vec4f())"), (&two, "luminance(vec4f())")]);
    assert!(linked.text.contains("color_luminance_2(color_luminance.rgb)"), "{}", linked.text);
}

#[test]
fn any_format_will_do() {
    let text = "/*a*/fn/*b*/helper(/*c*/x/*d*/:/*e*/vec4f)->vec4f{return/*f*/x;}struct S{a:f32}const K=1.0;\
                fn f(x:vec4f)->vec4f{return helper(x)*K*S(K)\n.\na;}// end";
    let (one, two) = (shader("one.wgsl", text), shader("two.wgsl", text));
    calling(&[(&one, "f(vec4f())"), (&two, "f(vec4f())")]);
}

#[test]
fn a_file_brings_a_library_beside_that_of_the_framework() {
    static LIBRARY: Library = Library::new(&[
        ("color", "import package::deep::deep;\nfn luminance(c: vec3f) -> f32 { return c.x * deep(); }"),
        ("deep", "import afterimage::math::power;\nfn deep() -> f32 { return power(2.0, 3.0); }"),
    ]);
    static OWN: Shader = Shader::new(
        "own.wgsl",
        "import super::color::luminance;\nfn f(c: vec4f) -> vec4f { return vec4f(luminance(c.rgb)); }",
    )
    .with_library(&LIBRARY);
    let text = "fn f(c: vec4f) -> vec4f { return vec4f(afterimage::color::luminance(c.rgb)); }";
    let other = shader("other.wgsl", text);
    let linked = calling(&[(&OWN, "f(vec4f())"), (&other, "f(vec4f())")]);
    assert_eq!(linked.text.matches("c.x * deep()").count(), 1);
    let names: BTreeSet<&str> =
        linked.text.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|w| w.contains("luminance")).collect();
    assert_eq!(names.len(), 2, "{names:?}");
}

#[test]
fn generated_code_may_import_what_no_file_does() {
    let own = shader("own.wgsl", "fn f(c: f32) -> f32 { return c; }");
    let mut linker = linker();
    let instance = linker.add(own.source(), &[]).unwrap_or_else(|error| panic!("{error}"));
    let call = linker.name(instance, "f");
    let code = format!(
        "import afterimage::workgroup::{{Invocation, WORKGROUP_ROW}};
fn run(i: Invocation) -> f32 {{ return {call}(f32(i.index + WORKGROUP_ROW)); }}"
    );
    let linked = linker.link(code, &[(Instance::GENERATED, "run")]).unwrap_or_else(|error| panic!("{error}"));
    valid(&linked);
}

/// The files of a kind's folder, of which this one imports, and what generated code calls.
fn with_files(text: &str) -> Shader {
    let file = |(name, text): (&str, &str)| (name.to_owned(), text.to_owned());
    let own =
        [("kinds/own/steps.wgsl", "fn step(x: f32) -> f32 { return super::other::half() * x; }\nconst MOST = 8.0;")];
    let own = own.into_iter().chain([("kinds/own/other.wgsl", "fn half() -> f32 { return 0.5; }")]).map(file);
    let shared = [("kinds/lib/steps.wgsl", "import super::shares::third;\nfn step() -> f32 { return third; }")];
    let shared = shared.into_iter().chain([("kinds/lib/shares.wgsl", "const third = 0.3;")]).map(file);
    Shader::untrusted("kinds/own/own.wgsl".into(), text.into()).with_loaded_library(Library::of_files(own, shared))
}

#[test]
fn imports_name_items_and_files_under_any_name_and_in_any_form() {
    for text in [
        "import super::steps::step;\nfn f(v: vec4f) -> vec4f { return v * step(1.0); }",
        "import super :: steps :: { step , } ;\nfn f(v: vec4f) -> vec4f { return v * step(1.0); }",
        "import super::{other::half, steps::{MOST as step, step as half_step}};
fn f(v: vec4f) -> vec4f { return v * step * half_step(1.0) * half(); }",
        "import super::steps;\nfn f(v: vec4f) -> vec4f { return v * steps::step(steps::MOST); }",
        "import super::steps as s;\nimport package::lib::steps;
fn f(v: vec4f) -> vec4f { let s = steps::step(); return v * s::step(s); }",
        "fn f(v: vec4f) -> vec4f { return v * super::steps::step(1.0) * package::lib::steps::step(); }",
        "import super::steps::step as power;\nimport afterimage::math::power as raise;
fn f(v: vec4f) -> vec4f { return v * power(raise(2.0, 3.0)); }",
        "import super::steps::step;\nimport super::steps::step;\nfn f(v: vec4f) -> vec4f { return v * step(1.0); }",
    ] {
        let own = with_files(text);
        own.reflect().unwrap_or_else(|error| panic!("{text}\n{error}"));
        let linked = calling(&[(&own, "f(vec4f())")]);
        assert!(!linked.text.contains("import") && !linked.text.contains("::"), "{}", linked.text);
    }
}

#[test]
fn errors_of_imports_have_a_place() {
    for (text, place, message) in [
        (
            "\n  import super::nothing::a;",
            (2, 17),
            "no shared file is called `super::nothing`; there are `super::steps`",
        ),
        ("import afterimage::colour::luminance;", (1, 20), "did you mean `afterimage::color`?"),
        ("import color::luminance;", (1, 8), "no shared file is called `color`; did you mean `afterimage::color`?"),
        ("import super::{steps::{MOST, stop}};", (1, 30), "`super::steps` declares no `stop`; did you mean `step`?"),
        ("import package::steps::step;", (1, 17), "did you mean `super::steps`?"),
        ("import luminance;", (1, 8), "an import names a file and what it declares"),
        ("import super::super::lib::steps::step;", (1, 27), "no shared file"),
        ("import super::steps::step::x;", (1, 22), "no shared file"),
        ("import super::steps::step, super::other::half;", (1, 26), "an import is a path and a semicolon"),
        ("import super::steps::{};", (1, 23), "an import is a path"),
        ("import super::steps::{step half};", (1, 28), "an import is a path"),
        ("import super::steps::step as super::x;", (1, 30), "an import is a path"),
        ("import super::steps::step", (2, 1), "an import is a path"),
        ("import a::b::c::d::e::f::g::h::i;", (1, 8), "a path has at most 8 names"),
        (
            "import super::steps::step;\nimport package::lib::steps::step;",
            (2, 29),
            "`step` is imported as `super::steps::step` and as `package::lib::steps::step`: give one another name",
        ),
        ("import super::steps::step;\nfn step() { }", (2, 4), "`step` is imported, too: give that another name"),
        ("fn g() -> f32 { return super::steps::stop(1.0); }", (1, 38), "`super::steps` declares no `stop`"),
        ("fn g() -> f32 { return steps::step(1.0); }", (1, 24), "did you mean `super::steps`?"),
        ("@compute @workgroup_size(1) fn g() { a::b(); }", (1, 38), "no shared file is called `a`"),
    ] {
        let own = with_files(&format!("{text}\nfn f(c: vec4f) -> vec4f {{ return c; }}"));
        let error = own.reflect().map(|_| ()).expect_err(text);
        assert_eq!((error.file.as_str(), (error.line, error.column)), ("kinds/own/own.wgsl", place), "{text}: {error}");
        assert!(error.message.contains(message), "{text}: {error}");
    }
}

/// Only the import is wrong that a file makes, also if another file that it imports is in another folder.
#[test]
fn errors_in_imported_files_are_in_those() {
    let library = Library::of_files(
        [],
        [("kinds/lib/a.wgsl".to_owned(), "\nimport super::nothing::b;\nfn a() -> f32 { return b(); }".to_owned())],
    );
    let own = Shader::untrusted("own.wgsl".into(), "fn f() -> vec4f { return vec4f(package::lib::a::a()); }".into());
    let error = own.with_loaded_library(library).reflect().map(|_| ()).expect_err("there is no such file");
    assert_eq!((error.file.as_str(), error.line, error.column), ("kinds/lib/a.wgsl", 2, 15), "{error}");
}

#[test]
fn errors_are_at_the_authors_line_and_column_also_behind_changed_names() {
    let one = shader(
        "one.wgsl",
        "fn helper() -> f32 { return 1.0; }\nfn f(v: vec4f) -> vec4f { return helper() * helper() * v; }",
    );
    let text = "fn helper() -> f32 { return 1.0; }
fn f(v: vec4f) -> vec4f { let a = helper() + helper(); return a * wrong; }";
    let two = shader("two.wgsl", text);
    let mut linker = linker();
    let instances = [&one, &two].map(|shader| linker.add(shader.source(), &[]).expect("its imports are there"));
    let calls = instances.map(|instance| linker.name(instance, "f"));
    let code = format!("fn run(v: vec4f) -> vec4f {{ return {}(v) + {}(v); }}", calls[0], calls[1]);
    let linked = linker.link(code, &[]).expect("all names are known");
    let error = validate(&linked.text, &linked.map).expect_err("`wrong` is not declared");
    let column = text.lines().nth(1).and_then(|line| line.find("wrong")).expect("it is there") as u32 + 1;
    assert_eq!((error.file.as_str(), error.line, error.column), ("two.wgsl", 2, column), "{error}");
}

#[test]
fn open_brackets_and_comments_are_found() {
    for (text, place, part) in [
        ("fn f() {\n  if true {\n", (2, 11), "never closed"),
        ("fn f() { let a = (1; }", (1, 22), "does not close"),
        ("fn f() { }\n/* and so on", (2, 1), "has no end"),
        ("fn f() {\nimport super::color::luminance;\n}", (2, 1), "come first"),
        ("const A = 1;\nimport super::color::luminance;", (2, 1), "come first"),
    ] {
        let error = shader("own.wgsl", text).reflect().expect_err(text);
        assert_eq!((error.line, error.column), place, "{text}: {error}");
        assert!(error.message.contains(part), "{text}: {error}");
    }
}

#[test]
fn bindings_formats_overrides_and_immediates_are_changed() {
    let text = "struct Params { gain: f32 }
@group(0)@binding(0)var<uniform>params:Params;
@binding(1) @group(0) var source: texture_2d<f32>;
@group(0) @binding(2) var result
    : texture_storage_2d<rgba16float /* the node's choice */, write>;
@group(0) @binding(3) var<uniform> frame: Frame;
@id(7) override ROWS: u32 = 4 * 2; override HALF = 0.5; override ON: bool;
var<workgroup> sums: array<f32, ROWS>;
@compute @workgroup_size(ROWS) fn main(@builtin(local_invocation_index) i: u32) {
    sums[i] = params.gain * HALF + frame.part;
    if ON { textureStore(result, vec2i(), sums[i] * textureLoad(source, vec2i(), 0)); }
}";
    let own = shader("own.wgsl", text);
    let mut linker = linker();
    let instance = linker.add_copy(own.source()).expect("it imports nothing");
    linker.bind(instance, "params", 0, 4);
    linker.bind(instance, "source", 1, 5);
    linker.set_storage_format(instance, "result", "rgba32float");
    linker.make_immediate(instance, "frame");
    for (name, value) in [("ROWS", 16.0), ("HALF", 0.25), ("ON", 1.0)] {
        linker.set_override(instance, name, value);
    }
    let linked = linker.link(String::new(), &[(instance, "main")]).expect("all names are known");
    for part in [
        "@group(0)@binding(4)var<uniform>params",
        "@binding(5) @group(1) var source",
        "texture_storage_2d<rgba32float /*",
        "var<immediate> frame: Frame;",
        "const ROWS: u32 = 16;",
        "const HALF = 0.25f;",
        "const ON: bool = true;",
    ] {
        assert!(linked.text.contains(part), "{part}:\n{}", linked.text);
    }
    let module = valid(&linked);
    assert_eq!(linked.entries, ["main"]);
    assert_eq!(module.entry_points[0].workgroup_size, [16, 1, 1]);
}

#[test]
fn a_variable_is_replaced_by_members_of_another_and_locals_of_its_name_stay() {
    let text = "struct Params { gain: f32 }
@group(0) @binding(0) var<uniform> params: Params;
fn scale(params: Params, all: f32) -> f32 { return params.gain * all; }
fn f(all: vec4f) -> vec4f { let own = scale(params, params.gain); return all * own; }";
    let own = shader("own.wgsl", text);
    let mut linker = linker();
    let instance = linker.add(own.source(), &[]).expect("it imports nothing");
    linker.replace(instance, "params", "all", ".first");
    let (ty, function) = (linker.name(instance, "Params"), linker.name(instance, "f"));
    let code = format!(
        "struct All {{ first: {ty} }}\n@group(0) @binding(9) var<uniform> all: All;
@fragment fn run() -> @location(0) vec4f {{ return {function}(vec4f()); }}"
    );
    let linked = linker.link(code, &[]).expect("all names are known");
    valid(&linked);
    assert!(linked.text.contains("scale(generated_all.first, generated_all.first.gain)"), "{}", linked.text);
    assert!(!linked.text.contains("@binding(0)"), "{}", linked.text);
}

#[test]
fn instances_with_other_promises_are_apart() {
    let own = shader(
        "own.wgsl",
        "const SAME: bool = false;\nfn f(v: vec4f) -> vec4f { if SAME { return v; } return 2.0 * v; }",
    );
    let mut linker = linker();
    let (never, always) = (linker.add(own.source(), &[]), linker.add(own.source(), &["SAME"]));
    let calls = [never, always].map(|instance| linker.name(instance.expect("it imports nothing"), "f"));
    let code = format!("fn run(v: vec4f) -> vec4f {{ return {}(v) + {}(v); }}", calls[0], calls[1]);
    let linked = linker.link(code, &[]).expect("all names are known");
    valid(&linked);
    assert!(
        linked.text.contains("own_SAME: bool = false;") && linked.text.contains("own_SAME_2: bool = true;"),
        "{}",
        linked.text
    );
}

#[test]
fn what_nothing_calls_is_left_out() {
    let own = shader(
        "own.wgsl",
        "const_assert LIMIT > 1;\nconst LIMIT = 2;\nfn unused() { }\nfn f(v: vec4f) -> vec4f { return v; }",
    );
    let linked = calling(&[(&own, "f(vec4f())")]);
    assert!(!linked.text.contains("unused") && linked.text.contains("const LIMIT"), "{}", linked.text);
}

#[test]
fn generated_code_that_names_what_a_file_does_not_declare_is_an_error_of_the_file() {
    let own = shader("own.wgsl", "fn f(v: vec4f) -> vec4f { return v; }");
    let mut linker = linker();
    let instance = linker.add(own.source(), &[]).expect("it imports nothing");
    let code = format!("fn run() -> vec4f {{ return {}(vec4f()); }}", linker.name(instance, "g"));
    let error = linker.link(code, &[]).expect_err("there is no `g`");
    assert_eq!(error.to_string(), "own.wgsl:0:1: the file declares no `g`");
}

/// Steps are counted from a limit that generated code sets, and it can ask whether a loop was ended.
#[test]
fn generated_code_sets_the_limit_of_steps_and_asks_whether_it_was_reached() {
    let looped = Shader::untrusted(
        "own.wgsl".into(),
        "fn f(v: vec4f) -> vec4f { var x = v; while x.x < 1.0 { x += v; } return x; }".into(),
    );
    let plain = Shader::untrusted("own.wgsl".into(), "fn f(v: vec4f) -> vec4f { return v; }".into());
    let trusted = Shader::loaded(
        "own.wgsl".into(),
        "fn f(v: vec4f) -> vec4f { var x = v; while x.x < 1.0 { x += v; } return x; }".into(),
    );
    for (shader, is_counted) in [(&looped, true), (&plain, false), (&trusted, false)] {
        let mut linker = Linker::new(SampleMode::Plain);
        let instance = linker.add(shader.source(), &[]).expect("it imports nothing");
        assert_eq!(linker.after_call(), None, "nothing was called yet");
        let before = linker.before_call(afterimage_wgsl::limits::WORKGROUP_LOOP_STEPS);
        let after = linker.after_call();
        assert_eq!((before.is_some(), after.is_some()), (is_counted, is_counted));
        let (before, after) = (before.unwrap_or_default(), after.unwrap_or_else(|| "false".into()));
        let call = linker.name(instance, "f");
        let code = format!(
            "@fragment fn run() -> @location(0) vec4f {{ {before} let v = {call}(vec4f()); return v * f32({after}); }}"
        );
        let linked = linker.link(code, &[(Instance::GENERATED, "run")]).expect("all names are known");
        validate(&linked.text, &linked.map).unwrap_or_else(|error| panic!("{error}\n{}", linked.text));
        assert_eq!(linked.text.contains("begin_steps(16384);"), is_counted, "{}", linked.text);
        assert_eq!(linked.text.contains("were_steps_cut()"), is_counted);
    }
}

/// The name of a file becomes a part of names, whatever it holds.
#[test]
fn namespaces_are_made_of_letters_digits_and_single_underscores() {
    let text = "fn same(v: vec4f) -> vec4f { return v; }";
    for (file, namespace) in [
        ("a b--c.wgsl", "a_b_c"),
        ("2nd.wgsl", "file2nd"),
        ("__x__.wgsl", "x"),
        ("folder/e.é.wgsl", "e"),
        ("...wgsl", "file"),
    ] {
        let (one, other) = (Shader::loaded(file.into(), text.into()), Shader::loaded("other.wgsl".into(), text.into()));
        let mut linker = Linker::new(SampleMode::Plain);
        let names = [&one, &other].map(|shader| {
            let instance = linker.add(shader.source(), &[]).expect("it imports nothing");
            linker.name(instance, "same")
        });
        let code = format!("fn run(v: vec4f) -> vec4f {{ return {}(v) + {}(v); }}", names[0], names[1]);
        let linked = linker.link(code, &[]).expect("all names are known");
        assert!(linked.text.contains(&format!("fn {namespace}_same(")), "{file}: {}", linked.text);
        assert!(linked.text.contains("fn other_same("), "{file}");
    }
}
