//! Node kinds of two files and no Rust: one that works, and what is reported when either file is wrong.

use afterimage_graph::node::{InputValues, NodeInstance, folder_kind, folder_kind_of};
use afterimage_graph::value::Value;

pub(super) const DECLARATION: &str = r#"Kind(
    name: "Posterize",
    doc: "Leaves only a few levels of each color.",
    inputs: {
        "source": Image(doc: "The picture after the tone curve.", accepts: [DisplayLinear]),
        "mask":   Image(doc: "Where.", optional: true),
    },
    outputs: { "result": Image(doc: "The picture in levels.", state: Same("source")) },
    parameters: {
        "levels": Float(doc: "Levels of each channel.", default: 4.0, within: (2, 256), usually: (2.0, 16.0)),
    },
)
"#;

pub(super) const SHADER: &str = "struct Posterize { levels: f32 }

fn posterize(source: vec4f, mask: texture_2d<f32>, mask_sampler: sampler, at: Point, params: Posterize) -> vec4f {
    let steps = params.levels - 1.0;
    let levels = round(source.rgb * steps) / steps;
    return vec4f(mix(levels, source.rgb, tap(mask, mask_sampler, at.uv).x), source.a);
}
";

fn reported(declaration: &str, shader: &str) -> String {
    let kind = folder_kind(("posterize/node.ron", declaration), ("posterize/posterize.wgsl", shader));
    kind.map_or_else(|reported| reported.to_string(), |kind| panic!("{kind:?} is accepted"))
}

#[test]
fn a_folder_becomes_a_kind() {
    let kind = folder_kind(("node.ron", DECLARATION), ("posterize.wgsl", SHADER))
        .unwrap_or_else(|reported| panic!("{reported}"));
    assert_eq!((kind.name(), kind.main_output(), kind.inputs().len()), ("Posterize", "result", 2));
    let (_, levels) = kind.param("levels").expect("it is declared");
    assert_eq!((levels.domain, levels.usual, levels.replan), (Some((2.0, 256.0)), Some((2.0, 16.0)), false));
}

#[test]
fn a_parameter_may_depend_on_another_and_on_an_input() {
    let with = |condition: &str| {
        DECLARATION
            .replace("16.0)),", &format!("16.0), {condition}),\n        \"on\": Bool(doc: \"On.\", default: true),"))
    };
    let shader = SHADER.replace("levels: f32", "levels: f32, on: u32");
    let declared = with("when: { \"on\": [true], \"mask\": false }");
    let kind = folder_kind(("node.ron", &declared), ("posterize.wgsl", &shader));
    let kind = kind.unwrap_or_else(|reported| panic!("{reported}"));
    let values = |on: bool| [Value::Float(4.0), Value::Bool(on)];
    let unmet = |on, is_wired| kind.unmet_condition(&values(on), 0, |_| is_wired).map(ToString::to_string);
    assert_eq!(unmet(true, false), None);
    assert_eq!(unmet(false, false).as_deref(), Some("`on` is true"));
    assert_eq!(unmet(true, true).as_deref(), Some("`mask` is not wired"));
    let reported = reported(&with("when: { \"onn\": true }, unless: { \"on\": 1 }"), &shader);
    assert!(reported.contains("`onn` is neither a parameter nor an optional input"), "{reported}");
    assert!(reported.contains("did you mean `on`?") && reported.contains("this is a whole number"), "{reported}");
    let reported = self::reported(&with("when: { \"source\": true }"), &shader);
    assert!(reported.contains("`source` is neither a parameter nor an optional input"), "{reported}");
}

#[test]
fn a_node_is_skipped_where_every_parameter_is_neutral() {
    let amount = r#""amount": Float(doc: "Share.", default: 1.0, within: (0, 1), usually: (0.0, 1.0), neutral: 0),"#;
    let declared = DECLARATION.replace("16.0)),", &format!("16.0), neutral: 256), {amount}"));
    let shader = SHADER.replace("levels: f32", "levels: f32, amount: f32");
    let kind = folder_kind(("node.ron", &declared), ("posterize.wgsl", &shader));
    let kind = kind.unwrap_or_else(|reported| panic!("{reported}"));
    let is_skipped = |levels, amount, absent: &[&'static str]| {
        let node = NodeInstance::new(kind.clone(), vec![Value::Float(levels), Value::Float(amount)]);
        let is_absent = |index: &usize| absent.contains(&&*kind.inputs()[*index].name);
        let absent = (0..kind.inputs().len()).filter(is_absent).collect();
        node.identity_of("result", &InputValues::new(kind.clone(), Vec::new(), absent))
    };
    assert!(is_skipped(256.0, 0.0, &[]));
    assert!(!is_skipped(256.0, 1.0, &[]) && !is_skipped(4.0, 0.0, &[]));
    assert!(!is_skipped(256.0, 0.0, &["source"]), "its fallback is an input that is not there");
}

#[test]
fn only_the_first_output_may_leave_out_its_function() {
    let with = |function: &str| {
        let other =
            format!("Same(\"source\")), \"other\": Image(doc: \"More.\", state: Same(\"source\"){function}) }},");
        DECLARATION.replace("Same(\"source\")) },", &other)
    };
    let reported = reported(&with(""), SHADER);
    assert!(reported.contains("an output after the first needs `function`"), "{reported}");
    assert!(reported.contains("node.ron:8:"), "{reported}");
    let stated = with(", function: \"posterize\"");
    let kind = folder_kind(("posterize/node.ron", &stated), ("posterize/posterize.wgsl", SHADER));
    assert_eq!(kind.unwrap_or_else(|reported| panic!("{reported}")).outputs().len(), 2);
}

#[test]
fn a_byte_order_mark_at_the_beginning_is_skipped() {
    let marked = |text: &str| format!("\u{feff}{text}");
    let kind = folder_kind(("node.ron", &marked(DECLARATION)), ("posterize.wgsl", &marked(SHADER)));
    assert_eq!(kind.unwrap_or_else(|reported| panic!("{reported}")).name(), "Posterize");
}

#[test]
fn a_doc_has_no_control_characters() {
    for escape in ["\\u{1b}[8m", "\\u{9b}8m", "\\u{7}"] {
        let reported = reported(&DECLARATION.replacen("doc: \"", &format!("doc: \"{escape}"), 1), SHADER);
        assert!(
            reported.contains("`doc` is a text in quotes that is not empty and has no control characters"),
            "{reported}"
        );
    }
    let lines = DECLARATION.replacen("doc: \"", "doc: \"First.\\n\\n\\tSecond. ", 1);
    assert!(folder_kind(("node.ron", &lines), ("posterize.wgsl", SHADER)).is_ok(), "{lines}");
}

#[test]
fn other_files_of_the_folder_are_for_imports_and_may_have_any_names() {
    let shader = SHADER
        .replace("struct", "import super::steps::step;\nstruct")
        .replace("params.levels - 1.0", "step(params.levels)");
    let steps = "import afterimage::math::power;\nfn step(length: f32) -> f32 { return power(length, 1.0) - 1.0; }\n";
    let with = |steps: &str, name: &str| {
        folder_kind_of(("posterize/node.ron", DECLARATION), &[("posterize/steps.wgsl", steps), (name, &shader)])
    };
    let kind = with(steps, "posterize/posterize.wgsl");
    assert_eq!(kind.unwrap_or_else(|reported| panic!("{reported}")).name(), "Posterize");
    for (from, to, message) in [
        ("- 1.0", "- one", "posterize/steps.wgsl:2:59"),
        ("math", "maths", "no shared file is called `afterimage::maths`; did you mean `afterimage::math`?"),
        (
            "power;",
            "powr;",
            "`afterimage::math` declares no `powr`; did you mean `power`?\n --> posterize/steps.wgsl:1:26",
        ),
    ] {
        let reported = with(&steps.replace(from, to), "posterize/posterize.wgsl").expect_err(message).to_string();
        assert!(reported.contains(message), "{reported}");
    }
    let reported = with(steps, "posterize/poster.wgsl").expect_err("neither is its shader").to_string();
    assert!(reported.contains("no file of the folder is called `posterize.wgsl`"), "{reported}");
    // A name of several words has `_` between them.
    let [declared, shader] = [("Posterize", "FewLevels"), ("posterize", "few_levels")]
        .iter()
        .fold([DECLARATION.to_owned(), shader], |texts, (old, new)| texts.map(|text| text.replace(old, new)));
    let named = |name: &str| folder_kind_of(("few/node.ron", &declared), &[("few/steps.wgsl", steps), (name, &shader)]);
    for name in ["few/few_levels.wgsl", "few/few_levels.wesl"] {
        assert_eq!(named(name).unwrap_or_else(|reported| panic!("{reported}")).name(), "FewLevels");
    }
    let reported = named("few/fewlevels.wgsl").expect_err("it is no snake case").to_string();
    assert!(reported.contains("no file of the folder is called `few_levels.wgsl`"), "{reported}");
}

#[test]
fn errors_of_the_shader_are_reported_at_their_lines() {
    for (from, to, message, location) in [
        ("params.levels -", "parms.levels -", "no definition in scope for identifier: `parms`", "posterize.wgsl:4:17"),
        (
            "levels: f32",
            "level: f32, levels: f32",
            "`level` of `Posterize` is not a parameter of the node",
            "posterize.wgsl:1:20",
        ),
        (
            "(source: vec4f",
            "(at_: Point, source: vec4f",
            "the argument `at_` is not an input of the node",
            "posterize.wgsl:3:14",
        ),
        (
            "fn posterize",
            "fn posterizes",
            "the shader has no function `posterize` that gives a `vec4f`",
            "node.ron:2:11",
        ),
        (
            "fn posterize",
            "const POSTERIZE_PAIR = vec2f(1.0, 2.0);\n\
             fn posterize_twice(x: f32) -> vec3f { return vec3f(POSTERIZE_PAIR, x); }\nfn posterize",
            "a vector constant of the module cannot be a part of a larger vector: write its components",
            "posterize.wgsl:4:46",
        ),
        ("mask_sampler", "samp", "the sampler `samp` does not follow its texture", "posterize.wgsl:3:52"),
        (
            "tap(mask, mask_sampler, at.uv)",
            "textureSample(mask, mask_sampler, at.uv)",
            "read textures through `tap(source, source_sampler, uv)`",
            "posterize.wgsl:6:42",
        ),
        (
            "fn posterize",
            "@group(0) @binding(0) var posterize_t: texture_2d<f32>;\nfn posterize",
            "this is bound to a resource, which the framework makes by itself",
            "posterize.wgsl:3:27",
        ),
        (
            "fn posterize",
            "@compute @workgroup_size(1) fn posterize_all() { }\nfn posterize",
            "this belongs to an entry point or a binding, which the framework makes by itself",
            "posterize.wgsl:3:1",
        ),
        (
            "levels: f32",
            "levels: f32, is_soft: bool",
            "the struct `Posterize` has a member that no parameter fits",
            "posterize.wgsl:1:8",
        ),
        ("    let steps", "    loop { }\n    let steps", "this loop never ends", "posterize.wgsl:4:5"),
        (
            "let levels",
            "var pair = array<f32, 2>(1.0, 2.0);\n    let far = pair[5];\n    let levels",
            "index 5 is out of",
            "posterize.wgsl:6:15",
        ),
    ] {
        let reported = reported(DECLARATION, &SHADER.replace(from, to));
        assert!(reported.contains(message) && reported.contains(location), "{from} -> {to}:\n{reported}");
    }
}

#[test]
fn an_array_of_one_number_is_no_member_for_a_parameter() {
    let shader = SHADER.replace("levels: f32", "levels: array<f32, 1>").replace("params.levels", "params.levels[0]");
    let reported = reported(DECLARATION, &shader);
    assert!(reported.contains("`levels` is a number and does not fit its member"), "{reported}");
    assert!(reported.contains("posterize.wgsl:1:20"), "{reported}");
}

#[test]
fn errors_of_the_declaration_are_reported_at_their_lines() {
    for (from, to, message, location) in [
        ("Kind(", "Node(", "the file holds a name with parentheses, not a `Kind`", "node.ron:1:1"),
        ("Float(", "Flaot(", "no type of parameter is called `Flaot`", "node.ron:10:19"),
        ("within: (2, 256)", "witin: (2, 256)", "a parameter needs `within`", "node.ron:10:19"),
        (
            "within: (2, 256)",
            "within: 2",
            "`within` is the least and the greatest number in parentheses",
            "node.ron:10:79",
        ),
        (
            "default: 4.0",
            "default: 1.0",
            "`default` of `levels` is not acceptable: `levels` must be within 2 and 256",
            "node.ron:10:9",
        ),
        ("(2, 256)", "(256, 2)", "`within` is the least and the greatest number", "node.ron:10:79"),
        ("Same(\"source\")", "Same(\"mask\")", "`mask` is not a required image input", "node.ron:8:75"),
        ("\"Posterize\"", "\"posterize\"", "`posterize` is not a valid name of a kind", "node.ron:2:11"),
        ("\"Posterize\"", "\"Vignette\"", "the shader of `Vignette` is called `posterize.wgsl`", "node.ron:2:11"),
        ("[DisplayLinear]", "[Displaylinear]", "no image state is called `Displaylinear`", "node.ron:5:77"),
        ("Same(\"source\")", "Same(\"sauce\")", "`sauce` is not a required image input", "node.ron:8:75"),
        ("name: \"Posterize\"", "name: \"\"", "`name` is a text in quotes that is not empty", "node.ron:2:11"),
        (
            "\"mask\":   Image",
            "\"other\": Image(doc: \"O.\"), \"mask\": Image",
            "the shader does not read the input `other`",
            "node.ron:6:9",
        ),
        (
            "state: Same(\"source\")",
            "state: Same(\"source\"), fallback: \"levels\"",
            "`fallback` must be an input, `Zero` or `Absent`",
            "node.ron:8:96",
        ),
        ("    parameters: {", "    bypass: Zero, parameters: {", "a node file has no field `bypass`", "node.ron:9:5"),
        ("doc: \"Where.\"", "dok: \"Where.\"", "an input needs `doc`", "node.ron:6:19"),
        (
            "state: Same(\"source\")",
            "state: Same(\"source\"), size: Fixed(0, 4)",
            "`size` is `Fixed(width, height)` with sides of 1 to 16384",
            "node.ron:8:92",
        ),
    ] {
        let reported = reported(&DECLARATION.replace(from, to), SHADER);
        assert!(reported.contains(message) && reported.contains(location), "{from} -> {to}:\n{reported}");
    }
}

#[test]
fn each_output_has_a_fallback() {
    use afterimage_graph::node::Fallback;
    let glow = |fallback: &str| {
        let glow = format!(", \"glow\": Image(doc: \"G.\", state: Data, function: \"posterize\"{fallback}) }},");
        let declaration = DECLARATION.replace("Same(\"source\")) },", &format!("Same(\"source\")){glow}"));
        let kind = folder_kind(("node.ron", &declaration), ("posterize.wgsl", SHADER));
        let kind = kind.unwrap_or_else(|reported| panic!("{reported}"));
        kind.outputs().iter().map(|port| port.fallback.clone()).collect::<Vec<_>>()
    };
    let source = || Fallback::input("source");
    assert_eq!(glow(""), [source(), Fallback::Zero]);
    assert_eq!(glow(", fallback: Absent"), [source(), Fallback::Absent]);
    assert_eq!(glow(", fallback: \"mask\""), [source(), Fallback::input("mask")]);
}

#[test]
fn no_text_makes_it_panic() {
    for cut in (0..DECLARATION.len() - 2).step_by(7) {
        reported(&DECLARATION[..cut], SHADER);
    }
    for cut in (0..SHADER.len() - 2).step_by(7) {
        reported(DECLARATION, &SHADER[..cut]);
    }
}

/// `Float` goes into `f32`, `Int` into `i32`, `u32` or `f32`, `Bool` into `u32`, and a vector into one as long.
#[test]
fn a_member_has_the_width_and_the_kind_of_its_parameter() {
    let report = |parameter: &str, member: &str| {
        let from = "Float(doc: \"Levels of each channel.\", default: 4.0, within: (2, 256), usually: (2.0, 16.0))";
        let declaration = DECLARATION.replace(from, parameter);
        assert_ne!(declaration, DECLARATION);
        let shader = SHADER
            .replace("levels: f32", &format!("levels: {member}"))
            .replace("params.levels - 1.0", "f32(all(vec2f(f32(params.x)) == vec2f(1.0)))");
        let shader =
            shader.replace("params.x", if member.starts_with("vec") { "params.levels.x" } else { "params.levels" });
        folder_kind(("node.ron", &declaration), ("posterize.wgsl", &shader)).err().map(|reported| reported.to_string())
    };
    let float = r#"Float(doc: "A number.", default: 4.0, within: (2, 256), usually: (2.0, 16.0))"#;
    let int = r#"Int(doc: "A number.", default: 4, within: (2, 256), usually: (2, 16))"#;
    let truth = r#"Bool(doc: "A switch.", default: true)"#;
    let vector = r#"Vector3(doc: "Numbers.", default: (1.0, 1.0, 1.0), within: (0, 1), usually: (0.0, 1.0))"#;
    for (parameter, fitting) in
        [(float, &["f32"][..]), (int, &["f32", "i32", "u32"]), (truth, &["u32", "i32"]), (vector, &["vec3f"])]
    {
        for member in ["f32", "i32", "u32", "vec2f", "vec3f", "vec4f", "vec3i", "vec2u"] {
            let reported = report(parameter, member);
            let fits = fitting.contains(&member);
            assert_eq!(reported.is_none(), fits, "{parameter} in {member}: {reported:?}");
            assert!(fits || reported.is_some_and(|text| text.contains("does not fit its member")), "{parameter}");
        }
    }
}

#[test]
fn errors_of_a_shader_are_found_together_and_suggest_names_of_wgsl() {
    let shader = "struct Posterize { levels: f32 }\n\
        fn half_of(a: f32) -> f32 { return lerp(a, 0.0, 0.5); }\n\
        fn third_of(a: f32) -> f32 { return flooor(a / 3.0); }\n\
        fn posterize(source: vec4f, params: Posterize) -> vec4f { return sourse * half_of(third_of(params.levels)); }";
    let reported = folder_kind(("node.ron", DECLARATION), ("posterize.wgsl", shader)).expect_err("wrong names");
    let reported = reported.to_string();
    for part in [
        "WGSL has `mix` for it",
        "did you mean `floor`?",
        "did you mean `source`?",
        "posterize.wgsl:2:36",
        "posterize.wgsl:3:37",
        "posterize.wgsl:4:66",
    ] {
        assert!(reported.contains(part), "no {part} in {reported}");
    }
}

#[test]
fn errors_of_a_shader_name_types_and_code() {
    let shader = "struct Posterize { levels: f32 }\n\
        fn posterize(source: vec4f, params: Posterize) -> vec4f { return source.rgb * params.levels; }";
    let reported = folder_kind(("node.ron", DECLARATION), ("posterize.wgsl", shader)).expect_err("a wrong type");
    let reported = reported.to_string();
    assert!(reported.contains("`vec4<f32>`") && reported.contains("`source.rgb * params.levels`"), "{reported}");
    assert!(!reported.contains("Some("), "{reported}");
}

/// Every name of the declaration and of the shader that is nearly one that is known.
#[test]
fn a_slip_of_a_name_is_answered_with_the_name_that_is_meant() {
    let of_wires = "[DisplayLinear]),\n        \"mask\"";
    for (declared, shader, meant) in [
        (DECLARATION.to_owned(), SHADER.replace("fn posterize(", "fn posterise("), "posterise"),
        (
            DECLARATION.to_owned(),
            SHADER.replace("levels: f32", "level: f32").replace("params.levels", "params.level"),
            "levels",
        ),
        (DECLARATION.to_owned(), SHADER.replace("params.levels -", "parms.levels -"), "params"),
        (DECLARATION.replace("parameters:", "paramters:"), SHADER.to_owned(), "parameters"),
        (DECLARATION.replace("default:", "defult:"), SHADER.to_owned(), "default"),
        (DECLARATION.replace(of_wires, &of_wires.replace("Display", "Dispaly")), SHADER.to_owned(), "DisplayLinear"),
        (DECLARATION.replace("Same(\"source\")", "Same(\"sorce\")"), SHADER.to_owned(), "source"),
    ] {
        let reported = reported(&declared, &shader);
        assert!(reported.contains(&format!("did you mean `{meant}`?")), "{meant}:\n{reported}");
    }
}
