//! Kinds in folders whose shaders attack the program: errors at the author's line, and loops that end.

use std::fs;

use afterimage_media::{Picture, Pixels, Source, read};

use super::{Folder, save};

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
        ("barrier", "", "workgroupBarrier(); return source;", "cannot wait for others", "2:38"),
        ("wide", "", "return source * f32(f64(source.x));", "numbers have 32 bits", "2:58"),
        ("sum", "", &format!("return {}source;", "source + ".repeat(50_000)), "512", "2:"),
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

/// Both nodes run in one pass. Each counts the steps of its own calls, and those of each pixel anew.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_loop_that_never_ends_ends_after_the_steps_that_the_manual_states() {
    let shader = "
fn attack(source: vec4f) -> vec4f {
    var steps = 0u;
    while source.x >= 0.0 {
        for (; steps % 4u < 3u;) { steps++; }
        steps++;
    }
    return source + vec4f(f32(steps) / 1048576.0, 1.0, 0.0, 0.0);
}
";
    let folder = folder("endless", shader);
    save(&folder.file("in.exr"), &Picture::new(2, 1, Pixels::Float(vec![0.0, 0.0, 0.5, 1.0, 1.0, 0.0, 0.5, 1.0])));
    folder.run("render pipeline.ron in.exr -o out.exr --nodes attack").good();
    let picture = read(&Source::file(folder.file("out.exr"))).expect("the picture was written");
    // A step of the outer loop and three of the inner one add four to `steps`.
    assert_eq!(picture.pixels.to_f32(), [2.0, 2.0, 0.5, 1.0, 3.0, 2.0, 0.5, 1.0]);
}
