//! Which members of a uniform a kernel reads, at the numbers that it holds.

use afterimage_wgsl::{Instance, Linker, SampleMode, Shader, UniformReads, UniformValue, validate};

const STRUCT: &str = "struct Look { amount: f32, count: u32, way: i32, one: f32, two: f32 }\n";

/// The members that are read by a function with this body, where amount is 0.5, count 3 and way -2.
fn read(body: &str, constants: &[(&str, f64)]) -> Vec<&'static str> {
    let text = format!(
        "{STRUCT}override LIMIT: f32 = 2.0;\nfn helped(look: Look, x: f32) -> f32 {{ return look.two * x; }}
fn kind(v: vec4f, params: Look) -> vec4f {{ {body} }}"
    );
    let shader = Shader::loaded("look.wgsl".into(), text);
    let reflection = shader.reflect().unwrap_or_else(|error| panic!("{body}: {error}"));
    let values = [("amount", 0.5_f32.into()), ("count", 3_u32.into()), ("way", (-2_i32).into())];
    let rest = [("one", UniformValue::from(0.0_f32)), ("two", 0.0_f32.into())];
    let bytes = reflection.pack("Look", &[&values[..], &rest].concat()).expect("every member has a value");
    let mask = UniformReads::new(&shader, &[], constants).expect("it is valid").mask("kind", &bytes);
    assert_eq!(mask.len(), 20);
    let names = ["amount", "count", "way", "one", "two"];
    assert!(mask.chunks(4).all(|member| member.iter().all(|byte| *byte == member[0])), "whole members: {mask:?}");
    names.into_iter().zip(mask.chunks(4)).filter(|(_, member)| member[0]).map(|(name, _)| name).collect()
}

#[test]
fn a_condition_of_known_numbers_decides_what_is_read() {
    let table: [(&str, bool); 23] = [
        ("params.amount < 0.5", false),
        ("params.amount <= 0.5", true),
        ("params.amount > 0.5", false),
        ("params.amount >= 0.5", true),
        ("params.amount == 0.5", true),
        ("params.amount != 0.5", false),
        ("params.count == 3u", true),
        ("params.count < 3u", false),
        ("params.way == -2", true),
        ("params.way < 0", true),
        ("params.way > 0", false),
        ("!(params.way > 0)", true),
        ("params.amount > 0.0 && params.way < 0", true),
        ("params.amount > 0.0 && params.way > 0", false),
        ("params.amount > 1.0 || params.way < 0", true),
        ("params.amount > 1.0 || params.way > 0", false),
        ("(params.amount > 1.0) == (params.way > 0)", true),
        ("(params.amount > 1.0) != (params.way > 0)", false),
        ("-params.amount < 0.0", true),
        ("0.25 < params.amount", true),
        ("1.0 < params.amount", false),
        ("true", true),
        ("false", false),
    ];
    for (condition, holds) in table {
        let found = read(&format!("if {condition} {{ return v * params.one; }} return v * params.two;"), &[]);
        let read = ["one", "two"].map(|name| found.contains(&name));
        assert_eq!(read, [holds, !holds], "{condition}");
    }
    let limited = "if params.amount < LIMIT { return v * params.one; } return v * params.two;";
    assert_eq!(read(limited, &[]), ["amount", "one", "two"], "what sets an override comes later");
    assert_eq!(read(limited, &[("LIMIT", 0.75)]), ["amount", "one"], "an override is what it is set to");
    assert_eq!(read(limited, &[("LIMIT", 0.25)]), ["amount", "two"]);
}

#[test]
fn what_may_run_is_read() {
    let table: [(&str, &[&str]); 12] = [
        ("return v;", &[]),
        ("if v.x > 0.0 { return v * params.one; } return v * params.two;", &["one", "two"]),
        (
            "switch params.count { case 1u { return v * params.one; } default { return v * params.two; } }",
            &["count", "one", "two"],
        ),
        ("var x = v; for (var i = 0u; i < params.count; i++) { x *= params.one; } return x;", &["count", "one"]),
        ("return v * helped(params, params.amount);", &["amount", "two"]),
        ("{ if params.amount > 0.0 { return v; } } return v * params.one;", &["amount"]),
        ("let small = params.amount < 1.0; if small { return v; } return v * params.two;", &["amount"]),
        (
            "var small = params.amount < 1.0; if v.x > 0.0 { small = false; } if small { return v; }
             return v * params.two;",
            &["amount", "two"],
        ),
        ("var x = 0.5; x = params.amount; if x == 0.5 { return v; } return v * params.two;", &["amount"]),
        ("var x = 0.5; x = v.x; if x == 0.5 { return v; } return v * params.two;", &["two"]),
        ("let all = array<Look, 1>(params); return v * all[0].one;", &["amount", "count", "way", "one", "two"]),
        ("if params.amount + 1.0 > 1.0 { return v * params.one; } return v * params.two;", &["amount", "one", "two"]),
    ];
    for (body, expected) in table {
        assert_eq!(read(body, &[]), expected, "{body}");
    }
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
