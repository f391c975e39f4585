//! Kinds in folders whose shaders attack the program: errors at the author's line.

use std::fs;

use afterimage_media::{Picture, Pixels};

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

/// The framework replaces such numbers and ends such loops, so that pixels do not show them.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn numbers_that_are_not_finite_and_loops_that_are_ended_are_counted_and_said_once() {
    let shader = "// Divides.
fn attack(source: vec4f) -> vec4f {
    var steps = 0.0;
    while source.b > 0.5 { steps += 1.0; }
    return vec4f(source.r / source.g, source.g, min(source.b, steps), source.a);
}
";
    let folder = folder("counted", shader);
    // llvmpipe itself ends loops after 65,535 steps. With a workgroup the framework ends them before that.
    let node = NODE.replace(r#"Same("source")"#, r#"Same("source"), workgroup: (8, 8)"#);
    folder.with("attack/node.ron", node.as_bytes());
    let colors: [[f32; 4]; 3] = [[0.5, 0.0, 0.0, 1.0], [0.5, 0.0, 0.25, 1.0], [0.5, 0.5, 0.75, 1.0]];
    for frame in 1..3 {
        let picture = Picture::new(3, 1, Pixels::Float(colors.as_flattened().to_vec()));
        save(&folder.file(&format!("in.{frame}.exr")), &picture);
    }
    let run = folder.run("render pipeline.ron in.#.exr -o out.#.exr --nodes attack");
    let notes = run.notes();
    let of = |node: &str, loops: &str| {
        format!(
            "attack.wgsl:2: `attack` of the kind `Attack` (node `{node}`) gives NaN or infinity for 2 of 3 pixels, \
             which is replaced{loops}"
        )
    };
    let loops = "; it has loops that take too long for 1 of 3 pixels, and are ended";
    for sentence in [of("first", loops), of("second", loops)] {
        assert_eq!(notes.matches(&sentence).count(), 1, "{notes}");
    }
    let shader = "fn attack(source: vec4f) -> vec4f { return source; }";
    folder.with("attack/attack.wgsl", shader.as_bytes());
    let notes = folder.run("render pipeline.ron in.#.exr -o plain.#.exr --nodes attack").notes();
    assert!(!notes.contains("attack"), "{notes}");
    let stress = "// Divides.\nfn attack(source: vec4f) -> vec4f { return source / (source.a - 1.0); }";
    folder.with("attack/attack.wgsl", stress.as_bytes());
    let run = folder.run("stress pipeline.ron --case ramp --size 5x3 --defaults --nodes attack");
    let said = format!("{}{}", run.out, run.err);
    let sentence =
        "attack.wgsl:2: `attack` of the kind `Attack` (node `first`) gives NaN or infinity for 15 of 15 pixels";
    assert_eq!(said.matches(sentence).count(), 1, "{said}");
}
