//! Kinds in folders whose shaders attack the program: errors at the author's line.

use std::fs;

use super::Folder;

const NODE: &str = r#"Kind(
    name: "Attack",
    doc: "Attacks.",
    inputs: { "source": Image(doc: "The image.") },
    outputs: { "result": Image(doc: "The result.", state: Same("source")) },
)"#;

const PIPELINE: &str = r#"Pipeline(
    inputs: { "scene": Color },
    nodes: { "first": Attack(source: "scene"), "second": Attack(source: "first") },
    outputs: { "out": "second" },
)"#;

fn folder(test: &str, shader: &str) -> Folder {
    let folder = Folder::new(test);
    fs::create_dir_all(folder.file("attack")).expect("a temporary folder");
    folder.with("pipeline.ron", PIPELINE.as_bytes());
    folder.with("attack/node.ron", NODE.as_bytes());
    folder.with("attack/attack.wgsl", shader.as_bytes());
    folder
}

#[test]
fn what_crashed_a_driver_or_a_parser_is_an_error_of_the_author() {
    let function = |body: &str| format!("\nfn attack(source: vec4f) -> vec4f {{ {body} }}\n");
    for (test, before, body, message, place) in [
        ("workgroup", "var<workgroup> w: f32;", "w = 1.0; return source * w;", "memory of a workgroup", "1:16"),
        ("immediate", "var<immediate> f: f32;", "return source * f;", "which the framework makes by itself", "1:16"),
        ("override", "override gain: f32;", "return source * gain;", "nothing sets this `override`", "1:1"),
        ("barrier", "", "workgroupBarrier(); return source;", "cannot wait for others", "2:37"),
        ("wide", "", "return source * f32(f64(source.x));", "numbers have 32 bits", "2:57"),
        ("sum", "", &format!("return {}source;", "source + ".repeat(5000)), "the limit is 256", "2:"),
        ("signs", "", &format!("return {}source;", "- ".repeat(3800)), "64", "2:"),
        (
            "array",
            "",
            "var z: array<f32, 16777216>; return source * z[u32(source.x)];",
            "too many bytes in a value",
            "2:",
        ),
    ] {
        let folder = folder(test, &(before.to_owned() + &function(body)));
        let place = format!("attack.wgsl:{place}");
        folder.run("check pipeline.ron --plan --nodes attack").fails_saying(1, &[message, &place]);
    }
}
