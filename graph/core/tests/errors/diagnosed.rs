//! What is reported, where it points, and what it advises: one document after the other, with its limits on both sides.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use afterimage_graph::check::{CheckOptions, Graph, Loader, check};
use afterimage_graph::diagnostic::{Diagnostic, Diagnostics};
use afterimage_graph::document::parse;
use afterimage_graph::image::Format;
use afterimage_graph::node::Registry;

use super::kinds;

/// Files in memory.
#[derive(Default)]
struct Files(BTreeMap<String, Arc<[u8]>>);

impl Files {
    fn of(files: &[(&str, &str)]) -> Self {
        Self(files.iter().map(|(name, text)| ((*name).to_owned(), text.as_bytes().into())).collect())
    }

    fn check(
        &self,
        text: &str,
        tier: Option<&str>,
        sets: &[(&str, &str)],
    ) -> Result<(Graph, Diagnostics), Diagnostics> {
        let registry = Registry::new(&[kinds::ALL]).expect("the kinds have different names");
        let sets = sets.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
        let options = CheckOptions { tier: tier.map(str::to_owned), sets, loader: self };
        check(&parse("top.ron", text)?, &registry, &options)
    }

    /// Of each error or warning its code, the text that it underlines, its message and its help.
    fn told(&self, text: &str) -> Vec<[String; 4]> {
        let told = self.check(text, None, &[]).map_or_else(|errors| errors, |(_, warnings)| warnings);
        let underlined = |one: &Diagnostic| {
            let location = &one.labels.first().expect("it is somewhere").location;
            let text = told.sources.text(&location.file).expect("the file is known");
            text[location.span()].to_owned()
        };
        let row = |one: &Diagnostic| -> [String; 4] {
            let Diagnostic { code, message, help, .. } = one;
            [(*code).to_owned(), underlined(one), message.clone(), help.clone().unwrap_or_default()]
        };
        told.iter().map(row).collect()
    }
}

impl Loader for Files {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        self.0.get(path).cloned().ok_or_else(|| "there is no such file".into())
    }
}

const BLOOM: &str = include_str!("files/bloom.ron");
/// Hands its input on.
const PASS: &str = r#"Pipeline(inputs: { "in": Color }, nodes: {}, outputs: { "out": "in" })"#;
const DEEP: &str = r#"Pipeline(inputs: { "in": Color }, nodes: { "kept": Tint(source: "in") },
    outputs: { "now": "kept", "before": "kept@previous:10" })"#;
const IDLE: &str = r#"Pipeline(inputs: { "in": Color, "more": Color(optional: true) },
    nodes: { "a": Tint(source: "in") }, outputs: { "out": "a" })"#;

/// Neither its input nor its output can be read.
const UNREAD: &str = r#"Pipeline(inputs: { "in": "Color" }, nodes: {}, outputs: { "out": 3 })"#;

/// A pipeline with an input, nodes, an output and further sections.
fn pipeline(nodes: &str, output: &str, more: &str) -> String {
    format!(r#"Pipeline(inputs: {{ "s": Color }}, nodes: {{ {nodes} }}, outputs: {{ "d": "{output}" }}, {more})"#)
}

#[test]
fn each_mistake_is_reported_once_where_it_is_and_with_what_helps() {
    let files = Files::of(&[("bloom.ron", BLOOM), ("pass.ron", PASS), ("deep.ron", DEEP), ("idle.ron", IDLE)]);
    let tint = |source: &str| pipeline(&format!(r#""a": Tint(source: "{source}")"#), "a", "");
    let with = |field: &str| pipeline(&format!(r#""a": Tint(source: "s", {field})"#), "a", "");
    let form = "a wire is `\"node\"`, `\"node.port\"`, `\"node@previous\"` or `\"node.port@previous:2\"`";
    let glow = |fields: &str, output: &str| {
        pipeline(&format!(r#""e": Exposure(source: "s"), "g": Pipeline(file: "bloom.ron", {fields})"#), output, "")
    };
    let wire = r#""s""#;
    let cases: Vec<(String, [&str; 4])> = vec![
        (tint(""), ["bad-wire", "\"\"", "the wire is empty", form]),
        (tint(".x"), ["bad-wire", "\".x\"", "a name is missing in `.x`", form]),
        (tint("s."), ["bad-wire", "\"s.\"", "a name is missing in `s.`", form]),
        (tint("@previous"), ["bad-wire", "\"@previous\"", "a name is missing in `@previous`", form]),
        (tint("g/up"), ["bad-wire", "\"g/up\"", "`g/up` looks into a pipeline: only its outputs can be read", form]),
        (tint("s@now"), ["bad-wire", "\"s@now\"", "unknown time `now`; only `previous` is supported", form]),
        (
            tint("a@previous:0"),
            ["bad-wire", "\"a@previous:0\"", "the number of frames in `a@previous:0` is not 1 to 16", form],
        ),
        (
            tint("a@previous:17"),
            ["bad-wire", "\"a@previous:17\"", "the number of frames in `a@previous:17` is not 1 to 16", form],
        ),
        (
            tint("a@previous:x"),
            ["bad-wire", "\"a@previous:x\"", "the number of frames in `a@previous:x` is not 1 to 16", form],
        ),
        (
            tint("s@previous"),
            [
                "bad-previous",
                "\"s@previous\"",
                "an input has no previous frame",
                "only what a node makes is kept: put a node between",
            ],
        ),
        (
            pipeline(
                r#""k": Pipeline(file: "deep.ron", in: "s"), "a": Composite(base: "s", bloom: "k.before@previous:7")"#,
                "a",
                "",
            ),
            [
                "bad-previous",
                "\"k.before@previous:7\"",
                "the wire reaches back more than 16 frames",
                "every frame that is kept costs a whole image; the limit is 16",
            ],
        ),
        (tint("s.x"), ["unknown-output", "\"s.x\"", "`s` is an input and has no output `x`", "write `\"s\"`"]),
        (
            pipeline(r#""m": Meter(source: "s"), "a": Exposure(source: "s", meter: "m.expose")"#, "a", ""),
            ["unknown-output", "\"m.expose\"", "`Meter` has no output `expose`", "did you mean `exposure`?"],
        ),
        (
            glow(r#"source: "e""#, "g.lihgt"),
            ["unknown-output", "\"g.lihgt\"", "the pipeline `g` has no output `lihgt`", "did you mean `light`?"],
        ),
        (
            glow(r#"source: "e", sourse: "e""#, "g"),
            ["unknown-field", "sourse", "the pipeline `bloom.ron` has no input `sourse`", "did you mean `source`?"],
        ),
        (
            glow(r#"source: "e""#, "g.zyx"),
            [
                "unknown-output",
                "\"g.zyx\"",
                "the pipeline `g` has no output `zyx`",
                "its outputs are `lit` and `light`",
            ],
        ),
        (
            pipeline(r#""m": Meter(source: "s"), "a": Exposure(source: "s", meter: "m.zyx")"#, "a", ""),
            [
                "unknown-output",
                "\"m.zyx\"",
                "`Meter` has no output `zyx`",
                "its outputs are `histogram`, `exposure` and `light`",
            ],
        ),
        (
            glow(r#"source: "e", zyx: "e""#, "g"),
            ["unknown-field", "zyx", "the pipeline `bloom.ron` has no input `zyx`", "its inputs are `source`"],
        ),
        (
            pipeline(r#""a": Tint(source: "s", when: "zyx")"#, "a", r#"facts: { "dark": "-", "wet": "-" }"#),
            ["unknown-fact", "zyx", "no fact is called `zyx`", "the section `facts` has `dark` and `wet`"],
        ),
        (
            glow("", "g"),
            [
                "missing-port",
                "\"g\"",
                "`g` has no `source`",
                "add `source: \"...\"`, or declare the input with `(optional: true)`",
            ],
        ),
        (
            glow(r#"source: "e", format: R16Float"#, "g"),
            [
                "unknown-field",
                "format",
                "a pipeline has no format of its own",
                "name a node inside: `set: { \"node.format\": ... }`",
            ],
        ),
        (
            glow(r#"source: "e", file: 3"#, "g"),
            ["doubled", "file", "the field `file` is given twice", "keep one of them"],
        ),
        (
            r#"Pipeline(nodes: {}, outputs: { "d": "x" })"#.to_owned(),
            ["unknown-name", "\"x\"", "no input or node is called `x`", "the pipeline has neither inputs nor nodes"],
        ),
        (
            pipeline("", "s", r#"set: { "x": Off }"#),
            ["unknown-node", "\"x\"", "no node is called `x`", "there are no nodes"],
        ),
        (
            pipeline("", "s", r#"set: { "s": Off }"#),
            ["unknown-node", "\"s\"", "`s` is an input, not a node", "there are no nodes"],
        ),
        (
            pipeline(r#""a": Tint(source: "s")"#, "a", r#"set: { "a/b": Off }"#),
            [
                "unknown-node",
                "\"a/b\"",
                "`a` is a node, not a pipeline: nothing is inside it",
                "a parameter of it is `a.parameter`",
            ],
        ),
        (
            pipeline(r#""a": Tint(source: "s")"#, "a", r#"set: { "a.source": 3 }"#),
            [
                "wrong-type",
                "3",
                "the port `source` takes the name of a node or an input in quotes",
                "write `source: \"name\"`",
            ],
        ),
        (
            pipeline(
                r#""e": Exposure(source: "s"), "g": Pipeline(file: "bloom.ron", source: "e")"#,
                "g",
                r#"set: { "g/bright.source": "s" }"#,
            ),
            [
                "unknown-field",
                "g/bright.source",
                "`source` is a port inside a pipeline, whose wires cannot be set",
                "wire the inputs of that pipeline, or write the node anew in a file that `extends` it",
            ],
        ),
        (
            pipeline(r#""a": Tint(source: "s", when: "dark")"#, "a", "facts: {}"),
            ["unknown-fact", "dark", "no fact is called `dark`", "the section `facts` is empty"],
        ),
        (
            pipeline(r#""a": Tint(source: "s", when: "wet and dank")"#, "a", r#"facts: { "dark": "-", "wet": "-" }"#),
            ["unknown-fact", "dank", "no fact is called `dank`", "did you mean `dark`?"],
        ),
        (
            with(r#"when: "a b""#),
            [
                "condition",
                "b",
                "expected `and`, `or` or the end of the condition, but there is `b`",
                "a condition looks like `emissive and illuminance < 10`",
            ],
        ),
        (
            with("when: 3"),
            [
                "wrong-type",
                "3",
                "`when` is a condition in quotes, not a whole number",
                "write it as `when: \"emissive and illuminance < 10\"`",
            ],
        ),
        (
            with("format: \"R16Float\""),
            ["wrong-type", "\"R16Float\"", "`format` is the bare name of a format", "write `R16Float` without quotes"],
        ),
        (with("label: 3"), ["wrong-type", "3", "`label` is a text in quotes", ""]),
        (
            with("bake: Atuo"),
            ["unknown-bake", "Atuo", "`bake` is `Off`, `Auto` or the size of a table", "did you mean `Auto`?"],
        ),
        (
            with("every: 17"),
            ["bad-every", "17", "`every` is a number from 1 to 16", "`every: 4` runs the node in each fourth frame"],
        ),
        (
            pipeline(&format!(r#""a": Tint(source: {wire}), "b": Tint(source: {wire})"#), "a", ""),
            ["unneeded-node", "\"b\"", "nobody reads `b`", "the node is left out of every plan"],
        ),
    ];
    let mut wrong = Vec::new();
    for (text, [code, underlined, message, help]) in cases {
        let told = files.told(&text);
        let plain = |text: &str| text.trim_matches('"').to_owned();
        let expected = [code.to_owned(), plain(underlined), message.to_owned(), help.to_owned()];
        let found =
            told.iter().map(|[code, at, message, help]| [code.clone(), plain(at), message.clone(), help.clone()]);
        let found: Vec<[String; 4]> = found.collect();
        if found != [expected.clone()] {
            wrong.push(format!("{text}\n  {found:?}\n  is not\n  {expected:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_list_in_a_hint_has_all_that_there_is() {
    let formats = Format::ALL.map(Format::name).to_vec();
    let bakes = vec!["Off", "Auto", "33", "48", "64"];
    for (field, names) in [("format: 3", &formats), ("format: Zyx", &formats), ("bake: 7", &bakes)] {
        let text = pipeline(&format!(r#""a": Tint(source: "s", {field})"#), "a", "");
        let told = Files::default().told(&text);
        let [[_, _, _, help]] = &told[..] else { panic!("{field}: {told:?}") };
        assert_eq!(&help.split('`').skip(1).step_by(2).collect::<Vec<_>>(), names, "{field}: {help}");
    }
}

/// What differs from a mistake in one thing only is none.
#[test]
fn what_is_nearly_wrong_is_right() {
    let files = Files::of(&[("bloom.ron", BLOOM), ("pass.ron", PASS), ("deep.ron", DEEP), ("idle.ron", IDLE)]);
    let loop_of = |wire: &str| pipeline(&format!(r#""a": Composite(base: "s", bloom: "{wire}")"#), "a", "");
    for text in [
        loop_of("a@previous"),
        loop_of("a@previous:1"),
        loop_of("a@previous:16"),
        loop_of("a.result@previous:2"),
        pipeline(
            r#""k": Pipeline(file: "deep.ron", in: "s"), "a": Composite(base: "s", bloom: "k.before@previous:6")"#,
            "a",
            "",
        ),
        pipeline(r#""a": Pipeline(file: "pass.ron", in: "s"), "b": Pipeline(file: "pass.ron", in: "a")"#, "b.out", ""),
        pipeline(r#""a": Pipeline(file: "idle.ron", in: "s")"#, "a", ""),
        r#"Pipeline(inputs: { "s": Color, "t": Color }, outputs: { "d": "a" },
            nodes: { "a": Pipeline(file: "idle.ron", in: "s", more: "t") })"#
            .to_owned(),
        pipeline(r#""a": Tint(source: "s", bake: 33, format: R16Float, when: "x < 1 or y")"#, "a", ""),
        pipeline(r#""a": Tint(source: "s", every: 16)"#, "a", r#"set: { "a.every": 1 }"#),
        pipeline(r#""a": Tint(source: "s", when: "dark")"#, "a", r#"facts: { "dark": "-" }"#),
        pipeline(r#""a": Tint(source: "s")"#, "a", r#"tiers: { "low": { "a": Off, "a.keep": false } }"#),
    ] {
        assert_eq!(files.told(&text), <[[String; 4]; 0]>::default(), "{text}");
    }
}

/// The codes that are reported.
fn codes(files: &Files, text: &str) -> Vec<String> {
    files.told(text).into_iter().map(|[code, ..]| code).collect()
}

/// One mistake is one error, also where others follow from it.
#[test]
fn a_mistake_has_no_errors_as_its_consequences() {
    let files = Files::of(&[("bloom.ron", BLOOM), ("broken.ron", "Pipeline("), ("unread.ron", UNREAD)]);
    let facts = r#"facts: { "dark": "-" }"#;
    for (nodes, output, more, wanted) in [
        // The same unknown fact, as a flag and as a number.
        (
            r#""a": Tint(source: "s", when: "zyx"), "b": Tint(source: "a", when: "zyx < 1")"#,
            "b",
            facts,
            &["unknown-fact"; 2][..],
        ),
        (r#""a": Zyx(source: "s", much: 3), "b": Tint(source: "a")"#, "b", "", &["unknown-kind"]),
        (r#""a": Zyx(source: "s")"#, "a", r#"set: { "a.much": 3 }"#, &["unknown-kind"]),
        (r#""a": Tint(source: "zyx"), "b": Tint(source: "a")"#, "b", "", &["unknown-name"]),
        (r#""a": Pipeline(file: "none.ron", source: "s"), "b": Tint(source: "a.glow")"#, "b", "", &["unreadable-file"]),
        (r#""a": Pipeline(file: "broken.ron", source: "s"), "b": Tint(source: "a.glow")"#, "b", "", &["syntax"]),
        (r#""a": Pipeline(file: "unread.ron", in: "s"), "b": Tint(source: "a.out")"#, "b", "", &["wrong-shape"; 2]),
        (r#""a": Exposure(source: "s", stops: "much"), "b": Tint(source: "a")"#, "b", "", &["wrong-type"]),
    ] {
        let text = pipeline(nodes, output, more);
        assert_eq!(codes(&files, &text), wanted, "{text}: {:?}", files.told(&text));
    }
}

#[test]
fn sections_names_and_conditions_are_as_long_as_they_may_be_and_no_longer() {
    let files = Files::of(&[("bloom.ron", BLOOM)]);
    let entries = |count: usize, value: &str| {
        (0..count).fold(String::new(), |mut all, at| {
            write!(all, "\"i{at}\": {value}, ").expect("a string grows");
            all
        })
    };
    let sections = [
        ("too-many-outputs", "i256", 256, "outputs"),
        ("too-many-tiers", "i64", 64, "tiers"),
        ("too-many-facts", "i256", 256, "facts"),
        ("too-many-usual", "i256", 256, "usual parameters"),
        ("too-many-inputs", "i256", 256, "inputs"),
    ];
    for (code, first, most, section) in sections {
        let text = |count: usize| match section {
            "outputs" => {
                let all = entries(count, "\"s\"");
                format!(r#"Pipeline(inputs: {{ "s": Color }}, nodes: {{}}, outputs: {{ {all} }})"#)
            }
            "inputs" => {
                format!(r#"Pipeline(inputs: {{ {} }}, nodes: {{}}, outputs: {{ "d": "i0" }})"#, entries(count, "Color"))
            }
            "tiers" => pipeline("", "s", &format!("tiers: {{ {} }}", entries(count, "{}"))),
            "usual parameters" => pipeline("", "s", &format!("usual: {{ {} }}", entries(count, "\"-\""))),
            _ => pipeline("", "s", &format!("facts: {{ {} }}", entries(count, "\"-\""))),
        };
        assert!(!codes(&files, &text(most)).contains(&code.to_owned()), "{most} {section}");
        let told: Vec<_> = files.told(&text(most + 1)).into_iter().filter(|[found, ..]| found == code).collect();
        assert_eq!(told.len(), 1, "{section}");
        assert_eq!(told[0][1].trim_matches('"'), first);
        assert_eq!(told[0][2], format!("the pipeline has more than {most} {section}"));
    }
    let named = |bytes: usize| {
        let name = "n".repeat(bytes);
        let nodes = format!(r#""e": Exposure(source: "s"), "{name}": Pipeline(file: "bloom.ron", source: "e")"#);
        files.told(&pipeline(&nodes, &name, ""))
    };
    assert!(named(249).is_empty(), "`bright` inside of it has 249 + 1 + 6 bytes");
    let told: Vec<_> = named(250).into_iter().filter(|[code, ..]| code == "long-name").collect();
    let underlined: Vec<&str> = told.iter().map(|[_, at, ..]| at.trim_matches('"')).collect();
    assert_eq!(underlined, ["source", "bright"]);
    for [_, _, message, help] in &told {
        assert_eq!(message, "the name has 257 bytes with those of the pipelines around it");
        assert_eq!(help, "a name has at most 256 bytes");
    }
    let labeled = |bytes: usize| {
        files.told(&pipeline(&format!(r#""a": Tint(source: "s", label: "{}")"#, "l".repeat(bytes)), "a", ""))
    };
    assert!(labeled(256).is_empty());
    let [code, _, message, help] = &labeled(257)[0];
    assert_eq!([code, message, help], ["long-name", "the label has 257 bytes", "a label has at most 256 bytes"]);
    let conditional = |outer: usize, inner: usize| {
        let [outer, inner] = [outer, inner].map(|bytes| "f".repeat(bytes));
        let set = format!(r#"set: {{ "up.when": "{inner}" }}"#);
        let glow = format!(r#""g": Pipeline(file: "bloom.ron", source: "e", when: "{outer}", {set})"#);
        files.told(&pipeline(&format!(r#""e": Exposure(source: "s"), {glow}"#), "g", ""))
    };
    assert!(conditional(1024, 1024).is_empty());
    let told = conditional(1024, 1025);
    assert_eq!(told.len(), 1, "{told:?}");
    assert_eq!(told[0][..3], ["long-condition", "Upsample", "the condition of a node has more than 2048 bytes"]);
}

/// Each file counts as often as it is used.
#[test]
fn the_bytes_of_files_are_counted() {
    let mut files = Files::of(&[("big.ron", &format!("{PASS} // {}", "x".repeat((4 << 20) - PASS.len() - 4)))]);
    files.0.insert("half.cube".into(), vec![b'1'; 32 << 20].into());
    files.0.insert("one.cube".into(), b"1".as_slice().into());
    assert_eq!(files.0["big.ron"].len(), 4 << 20);
    let used = |count: usize| {
        let nodes: String = (0..count).map(|at| format!(r#""n{at}": Pipeline(file: "big.ron", in: "s"), "#)).collect();
        files.told(&pipeline(&nodes, "n0", ""))
    };
    assert_eq!(used(2), <[[String; 4]; 0]>::default(), "8 MiB");
    let told: Vec<_> = used(4).into_iter().filter(|[code, ..]| code == "too-much-text").collect();
    assert_eq!(told.len(), 1, "told once: {told:?}");
    assert_eq!(told[0][2], "the files that the pipeline uses have more than 8388608 bytes of text");
    let graded = |last: &str| {
        let nodes = ["half.cube", "half.cube", last].map(|file| format!(r#"Grade(source: "s", table: "{file}")"#));
        let [a, b, c] = nodes;
        let text = format!(
            r#"Pipeline(inputs: {{ "s": Color }}, nodes: {{ "a": {a}, "b": {b}, "c": {c} }},
            outputs: {{ "a": "a", "b": "b", "c": "c" }})"#
        );
        files.told(&text)
    };
    assert!(graded("").is_empty(), "64 MiB");
    let told = &graded("one.cube")[0];
    assert_eq!(told[..2], ["too-large-files", "\"one.cube\""]);
    assert_eq!(told[2], "the files that the nodes use have more than 67108864 bytes");
    assert_eq!(told[3], "a file counts as often as it is named: use smaller tables");
}

/// A wire under an unknown name is meant for the port that is left, if one alone is.
#[test]
fn a_misnamed_wire_stands_for_a_port_if_no_other_is_missing() {
    let files = Files::default();
    let told = |fields: &str| codes(&files, &pipeline(&format!(r#""a": Composite({fields})"#), "a", ""));
    assert_eq!(told(r#"base: "s", zyx: "s""#), ["unknown-field"]);
    assert_eq!(told(r#"zyx: "s""#), ["missing-port", "missing-port", "unknown-field"]);
}

#[test]
fn files_of_one_name_in_two_folders_are_two_pipelines() {
    let twice =
        r#"Pipeline(inputs: { "in": Color }, nodes: { "kept": Tint(source: "in") }, outputs: { "out": "kept" })"#;
    let files = Files::of(&[("film/look.ron", PASS), ("game/look.ron", twice)]);
    let nodes = r#""a": Pipeline(file: "film/look.ron", in: "s"), "b": Pipeline(file: "game/look.ron", in: "a")"#;
    let (graph, _) = files.check(&pipeline(nodes, "b", ""), None, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    let names: Vec<&str> = graph.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["b/kept"]);
}

#[test]
fn files_may_be_nested_and_extended_sixteen_times() {
    let mut files = Files::default();
    for at in 1..=18 {
        let inner = format!(
            r#"Pipeline(inputs: {{ "in": Color }}, outputs: {{ "out": "n" }},
                nodes: {{ "n": Pipeline(file: "nested{}.ron", in: "in") }})"#,
            at + 1
        );
        files.0.insert(format!("nested{at}.ron"), inner.into_bytes().into());
        let base = format!(r#"Pipeline(extends: "base{}.ron")"#, at + 1);
        files.0.insert(format!("base{at}.ron"), base.into_bytes().into());
    }
    let ends_at = |files: &mut Files, name: &str, at: usize| {
        files.0.insert(format!("{name}{at}.ron"), PASS.as_bytes().into());
    };
    let nested = pipeline(r#""n": Pipeline(file: "nested1.ron", in: "s")"#, "n", "");
    let told = files.told(&nested);
    assert_eq!(
        (told[0][0].as_str(), told[0][2].as_str()),
        ("pipeline-cycle", "pipelines are nested more than 16 deep")
    );
    ends_at(&mut files, "nested", 17);
    assert!(!files.told(&nested).is_empty(), "17 files");
    ends_at(&mut files, "nested", 16);
    assert_eq!(files.told(&nested), <[[String; 4]; 0]>::default(), "16 files");
    let extending = r#"Pipeline(extends: "base1.ron", inputs: { "s": Color }, nodes: {}, outputs: { "d": "s" })"#;
    let told = files.told(extending);
    assert_eq!(
        (told[0][0].as_str(), told[0][2].as_str()),
        ("extends-cycle", "files extend each other more than 16 times")
    );
    assert_eq!(told[0][3], "let the shared part be a file that extends nothing");
    ends_at(&mut files, "base", 16);
    assert!(codes(&files, extending).contains(&"extends-cycle".to_owned()), "17 files with the own one");
    ends_at(&mut files, "base", 15);
    assert!(!codes(&files, extending).contains(&"extends-cycle".to_owned()), "16 files with the own one");
}

#[test]
fn a_long_cycle_is_told_by_its_ends() {
    let told = |count: usize| {
        let node = |at: usize| format!(r#""n{at:02}": Tint(source: "n{:02}"), "#, (at + count - 1) % count);
        let nodes: String = (0..count).map(node).collect();
        let text = format!(r#"Pipeline(nodes: {{ {nodes} }}, outputs: {{ "d": "n00" }})"#);
        let errors = Files::default().check(&text, None, &[]).expect_err("it is a cycle");
        let cycle = errors.iter().find(|one| one.code == "cycle").expect("it is reported").clone();
        (cycle.message, cycle.labels.len(), cycle.labels[0].text.clone(), cycle.help.unwrap_or_default())
    };
    let (message, labels, first, help) = told(3);
    assert_eq!(message, "the nodes run in a cycle: `n00` -> `n01` -> `n02` -> `n00`");
    assert_eq!((labels, first.as_str()), (3, "`n00` waits for `n02`"));
    assert_eq!(help, "read what one of them held in the frame before: `\"n02@previous\"`");
    let (message, labels, ..) = told(11);
    assert!(!message.contains("more") && message.ends_with("`n10` -> `n00`"), "{message}");
    assert_eq!(labels, 8);
    let (message, ..) = told(20);
    assert!(message.ends_with("`n06` -> `n07` -> ... (12 more) -> `n00`"), "{message}");
}

#[test]
fn tiers_change_pipelines_used_as_nodes_and_unknown_ones_are_listed() {
    let files = Files::of(&[("bloom.ron", BLOOM)]);
    let text = pipeline(
        r#""e": Exposure(source: "s"),
           "g": Pipeline(file: "bloom.ron", source: "e", when: "night", label: "Glow")"#,
        "g",
        r#"tiers: {
            "low": { "g.when": "dusk", "g.label": "Dim", "g": Off, "g/up.radius": 2.0 },
            "high": { "g/up.radius": 3.0 },
        }"#,
    );
    let state = |tier: Option<&str>, sets: &[(&str, &str)]| {
        let (graph, _) = files.check(&text, tier, sets).unwrap_or_else(|errors| panic!("{errors}"));
        let (_, up) = graph.node("g/up").expect("it is inside");
        let when = up.when.as_ref().map(ToString::to_string).unwrap_or_default();
        let radius = up.instance.value("radius").map(ToString::to_string).unwrap_or_default();
        (when, up.label.clone().unwrap_or_default(), up.off, radius)
    };
    let is = |when: &str, label: &str, off, radius: &str| (when.to_owned(), label.to_owned(), off, radius.to_owned());
    assert_eq!(state(None, &[]), is("night", "Glow/up", false, "0.85"));
    assert_eq!(state(Some("low"), &[]), is("dusk", "Dim/up", true, "2.0"));
    assert_eq!(state(Some("high"), &[]), is("night", "Glow/up", false, "3.0"));
    assert_eq!(state(Some("low"), &[("g", "On"), ("g.label", "\"Lit\"")]), is("dusk", "Lit/up", false, "2.0"));
    for (text, tier, help) in [
        (text.as_str(), "lo", "did you mean `low`? its tiers are `low` and `high`"),
        (&text, "zyx", "its tiers are `low` and `high`"),
        (&pipeline("", "s", ""), "low", "it has no tiers at all"),
    ] {
        let errors = files.check(text, Some(tier), &[]).expect_err("there is no such tier");
        let first = errors.iter().next().expect("it is reported");
        assert_eq!((first.code, first.message.clone()), ("unknown-tier", format!("the pipeline has no tier `{tier}`")));
        assert_eq!(first.help.as_deref(), Some(help));
    }
}

/// Each override of the command line is shown at its own place in the text that all of them make.
#[test]
fn overrides_of_the_command_line_are_underlined() {
    let text = pipeline(r#""a": Tint(source: "s"), "b": Exposure(source: "a")"#, "b", "");
    let sets = [("a.keep", "true"), ("b.stops", "99.0"), ("a.color", "(1.0, 2.0, 17.0)"), ("a.keep", "1 2")];
    let errors = Files::default().check(&text, None, &sets).expect_err("three are wrong");
    let underlined: Vec<(&str, String)> = errors
        .iter()
        .map(|one| {
            let location = &one.labels[0].location;
            let text = errors.sources.text(&location.file).expect("all of them are a text");
            (one.code, text[location.span()].to_owned())
        })
        .collect();
    for expected in [("out-of-domain", "99.0"), ("out-of-domain", "(1.0, 2.0, 17.0)")] {
        assert!(underlined.contains(&(expected.0, expected.1.to_owned())), "{underlined:?}");
    }
    assert!(underlined.iter().any(|(code, text)| *code == "set-syntax" && text.starts_with('2')), "{underlined:?}");
}
