//! Folders of node kinds.

use std::sync::OnceLock;

use afterimage_fuzz::hostile::bombs::bombs as shader_bombs;
use afterimage_fuzz::hostile::pair;
use afterimage_fuzz::{DECLARED_SHADER, SECOND_FILE, WORKGROUP_SHADERS};
use afterimage_media::{Encoding, Picture, Pixels, encode};

use crate::case::Case;
use crate::classes::Sources;

/// By how much bombs are divided.
const PARTS: [usize; 9] = [1, 2, 4, 8, 16, 32, 64, 128, 256];

/// Two nodes of the kind, one after the other.
fn pipeline(kind: &str, port: &str) -> String {
    format!(
        r#"Pipeline(
    inputs: {{ "scene": Color }},
    nodes: {{ "first": {kind}({port}: "scene"), "second": {kind}({port}: "first") }},
    outputs: {{ "out": "second" }},
)"#
    )
}

pub(crate) fn declaration(sources: &Sources, number: u64) -> Case {
    Case::new("check p.ron --plan --nodes tint")
        .with("p.ron", pipeline("Tint", "source"))
        .with("tint/tint.wgsl", DECLARED_SHADER)
        .with("tint/node.ron", sources.declarations.get(number))
}

/// A folder with a kind whose shader has a kernel function of one pixel.
fn folder(line: &str, shader: &str, shared: &str) -> Case {
    let (function, port) = last_function(shader);
    let declaration = format!(
        r#"Kind(
    name: "Kind", doc: "Attacks.",
    inputs: {{ "{port}": Image(doc: "The image.") }},
    outputs: {{ "result": Image(doc: "The result.", state: Same("{port}"), function: "{function}") }},
)"#
    );
    Case::new(line)
        .with("p.ron", pipeline("Kind", &port))
        .with("kind/node.ron", declaration)
        .with("kind/kind.wgsl", shader)
        .with("kind/shared.wgsl", shared)
}

/// The name of the last function of a shader, and of its argument.
fn last_function(shader: &str) -> (String, String) {
    // Comments of the generated shaders have functions, too.
    let code = SCATTERED.iter().fold(shader.replace('(', " ( "), |code, comment| code.replace(comment, " "));
    let after = code.rsplit_once(" fn ").map_or("", |(_, after)| after);
    let mut words = after.split(|c: char| c.is_whitespace() || c == ':').filter(|word| !matches!(*word, "" | "("));
    let mut word = |otherwise: &str| words.next().unwrap_or(otherwise).to_owned();
    (word("kind"), word("source"))
}

/// The tokens between words, with spaces around brackets.
const SCATTERED: [&str; 4] = ["/* fn helper ( ) { */", "// const gain = }\n", "/* /* nested */ } */", "\n"];

pub(crate) fn checked(sources: &Sources, number: u64) -> Case {
    of_text("check p.ron --plan --nodes kind", sources, number)
}

fn of_text(line: &str, sources: &Sources, number: u64) -> Case {
    let text = String::from_utf8(sources.shaders.get(number)).expect("mutated text is text");
    let (own, shared) = text.split_once(SECOND_FILE).unwrap_or((&text, ""));
    folder(line, own, shared)
}

const RENDER: &str = "render p.ron in.exr -o out.exr --nodes kind";

/// An image of 16x16 pixels.
pub(crate) fn scene() -> Vec<u8> {
    static SCENE: OnceLock<Vec<u8>> = OnceLock::new();
    let made = SCENE.get_or_init(|| {
        let numbers = (0..16 * 16 * 4).map(|i| (i * 37 % 251) as f32 * 0.03).collect();
        encode(&Picture::new(16, 16, Pixels::Float(numbers)), &Encoding::EXR).expect("a picture")
    });
    made.clone()
}

pub(crate) fn rendered(sources: &Sources, number: u64) -> Case {
    let case = match number % 2 {
        0 => of_text(RENDER, sources, number),
        _ => {
            let [kernel, _] = pair(sources.seed << 32 | number).hostile;
            folder(RENDER, &kernel.text, &kernel.shared)
        }
    };
    case.with("in.exr", scene())
}

/// A kind whose function shares memory of a workgroup: a shader as it is, mutated, or a bomb.
pub(crate) fn workgroup(sources: &Sources, number: u64) -> Case {
    let text = match WORKGROUP_SHADERS.get(number as usize) {
        Some(seed) => (*seed).to_owned(),
        None => String::from_utf8(sources.workgroups.get(number)).expect("mutated text is text"),
    };
    let bombs = workgroup_bombs();
    let text = match number as usize % 16 {
        15 => bombs[number as usize / 16 % bombs.len()].clone(),
        _ => text,
    };
    let sides = [(8, 8), (16, 16), (1, 1), (64, 4), (3, 5), (256, 1)][number as usize % 6];
    let declaration = format!(
        r#"Kind(
    name: "Kind", doc: "Attacks.",
    inputs: {{ "source": Image(doc: "The image.") }},
    outputs: {{ "result": Image(doc: "The result.", state: Same("source"), workgroup: {sides:?}) }},
)"#
    );
    Case::new(RENDER)
        .with("p.ron", pipeline("Kind", "source"))
        .with("kind/node.ron", declaration)
        .with("kind/kind.wgsl", text)
        .with("in.exr", scene())
}

/// Shaders that take a driver long or much memory, by what only a workgroup has.
fn workgroup_bombs() -> Vec<String> {
    let kind = |before: &str, body: &str| {
        format!(
            "import afterimage::workgroup::Invocation;\n{before}
fn kind(source: vec4f, at: Point, invocation: Invocation) -> vec4f {{ {body} return source; }}\n"
        )
    };
    let memory = |count: usize| {
        let body = "a[invocation.index] = source; workgroupBarrier();";
        kind(
            &format!("var<workgroup> a: array<vec4f, {count}>;"),
            &format!("{body} if a[0].x > 9.0 {{ return a[1]; }}"),
        )
    };
    let barriers = |count: usize| {
        let step = "a[invocation.index % 64u] += source; workgroupBarrier();";
        kind(
            "var<workgroup> a: array<vec4f, 64>;",
            &format!("{} if a[0].x > 9.0 {{ return a[1]; }}", step.repeat(count)),
        )
    };
    let loops = "loop { if atomicAdd(&n, 1u) == 0xffffffffu { break; } }";
    let spin = "loop { if atomicLoad(&n) != 0u { break; } }";
    let counter = "var<workgroup> n: atomic<u32>;";
    let deep = (0..64).map(|i| format!("fn f{}() {{ f{i}(); f{i}(); }}\n", i + 1)).collect::<String>();
    let trees = |depth: usize| kind(&format!("fn f0() {{ workgroupBarrier(); }}\n{deep}"), &format!("f{depth}();"));
    let copies = kind("struct S { a: array<vec4f, 512> }\nvar<workgroup> s: S;\nvar<workgroup> t: S;", "t = s; s = t;");
    let sums = "let s = workgroup_sum(invocation, 256u, source.xy); if s.x > 9.0 { return s.xyxy; }";
    vec![
        memory(1),
        memory(1023),
        memory(1024),
        memory(1025),
        memory(1 << 20),
        memory(1 << 28),
        barriers(16),
        barriers(17),
        barriers(2000),
        kind(counter, loops),
        kind(counter, spin),
        kind(counter, &loops.repeat(10)),
        trees(4),
        trees(5),
        trees(64),
        copies,
        kind("", sums),
    ]
}

pub(crate) fn bombs() -> u64 {
    (shader_bombs(1).len() * PARTS.len()) as u64
}

pub(crate) fn bomb(_: &Sources, number: u64) -> Case {
    let part = PARTS[number as usize % PARTS.len()];
    let (_, text) = shader_bombs(part).swap_remove(number as usize / PARTS.len());
    folder(RENDER, &text, "").with("in.exr", scene())
}
