//! What authors read of errors: the place, remarks, help, and further errors of the same module.

use afterimage_base::diagnostic::Diagnostics;
use afterimage_wgsl::{Library, Place, Shader, ShaderError, ShaderLabel};

fn error_of(text: &str) -> ShaderError {
    Shader::loaded("own.wgsl".into(), text.into()).reflect().map(|_| ()).expect_err(text)
}

#[test]
fn names_of_other_languages_and_near_names_are_suggested() {
    let table = [
        ("lerp(v, v, v)", "WGSL has `mix` for it"),
        ("frac(v)", "WGSL has `fract` for it"),
        ("rsqrt(v)", "WGSL has `inverseSqrt` for it"),
        ("inversesqrt(v)", "WGSL has `inverseSqrt` for it"),
        ("float4(v)", "WGSL has `vec4f` for it"),
        ("float3(1.0).xxxx", "WGSL has `vec3f` for it"),
        ("float2(1.0).xxxx", "WGSL has `vec2f` for it"),
        ("mul(v, v)", "WGSL has `*` for it"),
        ("mod(v, v)", "WGSL has `%` for it"),
        ("ddx(v)", "WGSL has `dpdx` for it"),
        ("ddy(v)", "WGSL has `dpdy` for it"),
        ("dFdx(v)", "WGSL has `dpdx` for it"),
        ("dFdy(v)", "WGSL has `dpdy` for it"),
        ("atan2f(v, v)", "WGSL has `atan2` for it"),
        ("vec4f(ivec2(1).xxxx)", "WGSL has `vec2i` for it"),
        ("vec4f(uvec2(1u).xxxx)", "WGSL has `vec2u` for it"),
        ("vec4f(half(1.0))", "WGSL has `f32` for it"),
        ("flooor(v)", "did you mean `floor`?"),
        ("brightnes(v)", "did you mean `brightness`?"),
    ];
    for (call, help) in table {
        let text =
            format!("fn brightness(v: vec4f) -> vec4f {{ return v; }}\nfn f(v: vec4f) -> vec4f {{ return {call}; }}");
        let error = error_of(&text);
        assert_eq!(error.help.as_deref(), Some(help), "{call}: {error}");
        assert_eq!((error.file.as_str(), error.line), ("own.wgsl", 2), "{call}");
        assert!(error.message.starts_with("no definition in scope for identifier"), "{error}");
    }
    assert_eq!(error_of("fn f(v: vec4f) -> vec4f { return zzyzx(v); }").help, None);
}

#[test]
fn common_mistakes_have_advice() {
    let vector = "`v` is a `vec3f`; a vector has `x`, `y`, `z`, `w` or `r`, `g`, `b`, `a`, as many as its size";
    let declared = "WGSL declares a value by `let x = ...`, and one that changes by `var x = ...`";
    for (body, help) in [
        ("return v.a;", vector),
        ("return v.rgbx;", vector),
        ("return p.strenght;", "did you mean `strength`?"),
        ("return p.gain;", "`p` is a `Parameters`"),
        ("float x = 1.0; return x;", declared),
        ("vec3 x = v; return x.x;", declared),
        ("return 1.0", "a statement ends with `;`: it is missing before this"),
        (
            "return select(0.0, 1.0, v.x > 0.5) + (v.x > 0.5 ? 1.0 : 0.0);",
            "WGSL has `select(otherwise, value, condition)` for `condition ? value : otherwise`",
        ),
        ("return vec4f(v, v).x;", "together, the arguments have as many numbers as the vector has components"),
    ] {
        let text = format!("struct Parameters {{ strength: f32 }}\nfn f(v: vec3f, p: Parameters) -> f32 {{ {body} }}");
        let error = error_of(&text);
        assert_eq!(error.help.as_deref(), Some(help), "{body}: {error}");
    }
    let number = error_of("fn f() -> i32 { let x: i32 = 2.5; return x; }");
    assert!(number.message.ends_with("but got a number with a point"), "{number}");
}

#[test]
fn a_texture_without_its_sampler_is_one_sentence() {
    let reads = |arguments: &str, call: &str| {
        let library =
            "fn tap(t: texture_2d<f32>, s: sampler, uv: vec2f) -> vec4f { return textureSampleLevel(t, s, uv, 0.0); }";
        error_of(&format!("{library}\nfn f(a: texture_2d<f32>, {arguments}uv: vec2f) -> vec4f {{\nreturn {call}; }}"))
    };
    for (call, name) in [
        ("tap(a, uv)", "tap"),
        ("tap(a, uv.yx)", "tap"),
        ("0.5 * tap( a, uv + vec2f(0.1, 0.2))", "tap"),
        ("textureSample(a, uv)", "textureSample"),
        ("textureSampleLevel(a, uv, 0.0)", "textureSampleLevel"),
    ] {
        let error = reads("", call);
        let message = format!(
            "`{name}` reads a texture through its sampler: write `tap(a, a_sampler, uv)`, with the argument \
             `a_sampler: sampler` after the texture `a`"
        );
        assert_eq!((error.line, error.message.as_str(), &error.help), (3, message.as_str(), &None), "{call}");
    }
    let unknown = reads("", "tap(a, a_sampler, uv)");
    assert_eq!(unknown.help.as_deref(), Some("the argument `a_sampler: sampler` follows that of its texture"));
    let no_level = reads("a_sampler: sampler, ", "textureSampleLevel(a, a_sampler, uv)");
    assert!(no_level.message.starts_with("wrong number of arguments"), "{no_level}");
}

#[test]
fn the_first_five_functions_with_errors_are_reported_each_at_its_place() {
    let wrong = |count: usize| {
        (0..count).map(|at| format!("fn f{at}(v: f32) -> f32 {{ return wrong{at}(v) + 1.0; }}\n")).collect::<String>()
    };
    let places = |count: usize| -> Vec<(u32, u32)> {
        let error = error_of(&wrong(count));
        std::iter::once(&error).chain(&error.others).map(|error| (error.line, error.column)).collect()
    };
    assert_eq!(places(1), [(1, 31)]);
    assert_eq!(places(3), [(1, 31), (2, 31), (3, 31)]);
    assert_eq!(places(9), [(1, 31), (2, 31), (3, 31), (4, 31), (5, 31)]);
    let signature = error_of("fn f(v: Nothing) -> f32 { return 1.0; }\nfn g(v: f32) -> f32 { return wrong(v); }");
    assert!(signature.others.is_empty(), "what a signature lacks may be the cause of all else: {signature}");
}

#[test]
fn an_error_is_printed_with_its_remarks_its_help_and_the_others() {
    let mut error = ShaderError::new("a.wgsl", (3, 0), "it is wrong");
    assert_eq!(error.to_string(), "a.wgsl:3:1: it is wrong");
    let place = Place { file: "b.wgsl".into(), line: 4, column: 5 };
    error.labels.push(ShaderLabel { place, text: "here".into() });
    error.help = Some("do it right".into());
    error.others = [ShaderError::new("c.wgsl", (6, 7), "this, too")].into();
    let expected = "a.wgsl:3:1: it is wrong\n  b.wgsl:4:5: here\n  help: do it right\nc.wgsl:6:7: this, too";
    assert_eq!(error.to_string(), expected);
}

#[test]
fn an_error_is_reported_with_excerpts_of_its_file() {
    let text = "fn f(v: f32) -> f32 {\n    return wrong(v);\n}\nfn g(v: f32) -> f32 { return lerp(v, v, v); }\n";
    let shader = Shader::loaded("own.wgsl".into(), text.into());
    let error = shader.reflect().map(|_| ()).expect_err("two names are unknown");
    let mut diagnostics = Diagnostics::default();
    shader.report(&error, &mut diagnostics);
    let found: Vec<(String, Option<String>)> = diagnostics
        .iter()
        .map(|one| {
            let location = &one.labels[0].location;
            (
                diagnostics.sources.text(&location.file).expect("it is known")[location.start..].to_owned(),
                one.help.clone(),
            )
        })
        .collect();
    assert_eq!(found.len(), 2);
    assert!(found[0].0.starts_with("wrong(v)") && found[1].0.starts_with("lerp(v"), "{found:?}");
    assert_eq!(found[1].1.as_deref(), Some("WGSL has `mix` for it"));
    assert!(diagnostics.iter().all(|one| one.code == "shader"));
    let label = ShaderLabel { place: Place { file: "own.wgsl".into(), line: 2, column: 12 }, text: "this one".into() };
    let other = ShaderLabel { place: Place { file: "own.wgsl".into(), line: 1, column: 4 }, text: "that one".into() };
    let remarked = ShaderError { labels: vec![other, label], ..ShaderError::new("own.wgsl", (2, 12), "it is wrong") };
    let mut diagnostics = Diagnostics::default();
    shader.report(&remarked, &mut diagnostics);
    let labels: Vec<(&str, bool)> =
        diagnostics.iter().flat_map(|one| &one.labels).map(|label| (label.text.as_str(), label.primary)).collect();
    assert_eq!(labels, [("this one", true), ("that one", false)]);
}

#[test]
fn a_place_is_found_by_whole_words() {
    let shader = Shader::loaded("own.wgsl".into(), "fn gains() { }\nfn gain_2() { }\n  fn gain() { }".into());
    let at = |words: &str| {
        let error = shader.error_at(words, "it is wrong");
        (error.file, error.line, error.column)
    };
    assert_eq!(at("fn gain"), ("own.wgsl".to_owned(), 3, 3));
    assert_eq!(at("fn gains"), ("own.wgsl".to_owned(), 1, 1));
    assert_eq!(at("fn nothing"), ("own.wgsl".to_owned(), 1, 1));
    assert_eq!(at("gain_2"), ("own.wgsl".to_owned(), 2, 4));
}

/// The validator's numbers become types and code, and its sentences begin as ours do.
#[test]
fn errors_of_the_validator_are_in_the_words_of_the_author() {
    for (body, parts) in [
        ("return v.rgb * 2.0;", &["`v.rgb * 2.0`", "return type"][..]),
        ("var a = array<f32, 2>(); return v * a[3];", &["index 3 is out of"]),
        ("let n = 1 / 0; return v;", &["ivision by zero"]),
        ("if v { } return v;", &["ondition"]),
        ("loop { return v; } return f(v);", &[]),
    ] {
        let text = format!("fn f(v: vec4f) -> vec4f {{ {body} }}");
        let error = error_of(&text);
        for part in parts {
            assert!(error.to_string().contains(part), "{body}: {error}");
        }
        assert!(!error.to_string().contains("Some(["), "{error}");
        assert!(!error.message.chars().next().is_some_and(char::is_uppercase), "{error}");
        assert_eq!((error.file.as_str(), error.line), ("own.wgsl", 1), "{body}: {error}");
    }
}

#[test]
fn files_are_imported_by_their_names_without_folders_and_endings() {
    let texts = [("deep/in/a.wgsl", "a"), ("c:\\folder\\b.wgsl", "b"), ("c", "c")];
    for (path, name) in texts {
        let library = Library::of_files([(path.to_owned(), "fn help() -> f32 { return 2.0; }".to_owned())], []);
        let text = format!("import super::{name}::help;\nfn f(v: vec4f) -> vec4f {{ return v * help(); }}");
        let shader = Shader::untrusted("own.wgsl".into(), text).with_loaded_library(library);
        shader.reflect().map(|_| ()).unwrap_or_else(|error| panic!("{path}: {error}"));
    }
}

/// Everything that only whole kernels and other devices have, by the words that name it.
#[test]
fn each_word_that_no_function_of_a_pixel_can_use_is_refused() {
    let words = [
        ("var x = atomicLoad(&y);", "needs no atomics"),
        ("workgroupBarrier();", "cannot wait"),
        ("storageBarrier();", "cannot wait"),
        ("textureBarrier();", "cannot wait"),
        ("let a = subgroupBallot(true);", "does not see its neighbors"),
        ("let a = quadBroadcast(v, 1u);", "does not see its neighbors"),
        ("let a = quadSwapY(v);", "does not see its neighbors"),
        ("let a = f64(1.0);", "32 bits"),
        ("let a = i64(1);", "32 bits"),
        ("let a = u64(1);", "32 bits"),
        ("let a = f16(1.0);", "32 bits"),
        ("let a = i16(1);", "32 bits"),
        ("let a = u16(1);", "32 bits"),
        ("let a = 1.0lf;", "32 bits"),
        ("let a = 1li;", "32 bits"),
        ("let a = 1lu;", "32 bits"),
        ("let a = 1.0h;", "32 bits"),
        ("textureStore(t, vec2i(), v);", "writes only its result"),
        ("textureAtomicAdd(t, vec2i(), 1u);", "writes only its result"),
        ("var r: ray_query;", "writes only its result"),
        ("var r: acceleration_structure;", "writes only its result"),
        ("var r: binding_array<texture_2d<f32>>;", "writes only its result"),
        ("var r: texture_storage_1d<r32float, write>;", "writes only its result"),
    ];
    for (statement, why) in words {
        let text = format!("fn f(v: vec4f) -> vec4f {{\n  {statement} return v; }}");
        let shader = Shader::untrusted("own.wgsl".into(), text);
        let error = shader.reflect().map(|_| ()).expect_err(statement);
        assert!(error.message.contains(why), "{statement}: {error}");
        assert_eq!(error.line, 2, "{statement}: {error}");
    }
}

#[test]
fn the_validator_speaks_of_types_and_expressions_by_their_names() {
    let returned = "the `return` expression `v.rgb` does not match the declared return type `vec4<f32>`";
    for (text, message) in [
        ("fn f(v: vec4f) -> vec4f {\n return v.rgb; }", returned),
        (
            "fn f(v: vec4f) -> f32 {\n return v; }",
            "the `return` expression `v` does not match the declared return type `f32`",
        ),
        (
            "fn f(v: vec4f) -> vec4f {\n if v.x > 0.0 { return v; } }",
            "some path of the function ends without a `return` of its type, `vec4<f32>`",
        ),
        (
            "fn f(v: vec4f) -> vec4f {\n return v * v.rgb; }",
            "operation Multiply can't work with a value (of type `vec4<f32>`) and one (of type `vec3<f32>`)",
        ),
    ] {
        let error = error_of(text);
        assert_eq!(error.message, message, "{text}");
    }
}
