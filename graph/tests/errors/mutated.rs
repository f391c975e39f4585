//! Many wrong files, compared with what is known of them: each case of this folder, a good pipeline and a folder kind,
//! with words and signs removed, doubled, exchanged and replaced. `mutated.tsv` has a line for each file: how many of
//! its texts are accepted, how many errors and warnings the others have, and a hash of all that is reported and of the
//! graphs. `folders.tsv` has the same for folder kinds of many images, with what the accepted ones record.
//!
//! `AFTERIMAGE_BLESS=1 cargo test -p afterimage-graph errors` writes it anew. A change of a message changes many lines;
//! what each text is reported is asserted nowhere, only that nothing changes by accident.

use std::fmt::Write as _;

use afterimage_generators::{FNV_START, fnv1a, mutated};
use afterimage_graph::check::Graph;
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::node::{NodeKind, folder_kind, folder_kind_sharing, for_each_recording};

use super::accepted::LYNX;
use super::folder::{DECLARATION, SHADER};
use super::{checked, folder};

/// Texts that are made of each file.
const TEXTS: u64 = 40;

/// What texts get that they do not have.
const OTHERS: [&str; 22] = [
    "(", ")", "[", "]", "{", "}", ",", ":", "\"", ".", "-", "0", "1e9", "4.5", "true", "None", "//", "/*", "@",
    "previous", "not", "<",
];

/// The text with changes behind the lines of options.
fn changed(text: &str, seed: u64) -> String {
    let begin = text.split_inclusive('\n').take_while(|line| line.starts_with("//!")).map(str::len).sum();
    let (head, body) = text.split_at(begin);
    head.to_owned() + &mutated(body, seed, &OTHERS)
}

/// All of a graph that a pipeline says.
fn described(graph: &Graph) -> String {
    let mut text = format!("{:?} {:?}\n", graph.inputs, graph.outputs);
    for node in &graph.nodes {
        let values: Vec<String> = node.instance.values().iter().map(ToString::to_string).collect();
        let (kind, when) = (node.instance.kind().name(), node.when.as_ref().map(ToString::to_string));
        let rest = (&node.wires, when, node.off, node.format, &node.label, &node.states);
        writeln!(text, "{} {kind} {values:?} {rest:?}", node.name).expect("a string grows");
    }
    text
}

fn described_kind(kind: &NodeKind) -> String {
    let (params, inputs, outputs) = (kind.params(), kind.inputs(), kind.outputs());
    format!("{} {} {params:?} {inputs:?} {outputs:?}", kind.name(), kind.doc())
}

/// A line of the table.
#[derive(Default)]
struct Row {
    accepted: usize,
    problems: usize,
    hash: u64,
}

impl Row {
    fn add(&mut self, result: Result<(String, usize), Diagnostics>) {
        let text = match result {
            Ok((described, warnings)) => {
                self.accepted += 1;
                self.problems += warnings;
                described
            }
            Err(errors) => {
                self.problems += errors.len();
                errors.to_string()
            }
        };
        self.hash = fnv1a(&text, self.hash);
    }

    fn of(text: &str, report: impl Fn(&str) -> Result<(String, usize), Diagnostics>) -> Self {
        let mut row = Self { hash: FNV_START, ..Self::default() };
        (0..TEXTS).for_each(|seed| row.add(report(&changed(text, seed))));
        row
    }

    fn line(&self, name: &str) -> String {
        format!("{name}\t{}\t{}\t{:016x}\n", self.accepted, self.problems, self.hash)
    }
}

fn pipeline(text: &str) -> Result<(String, usize), Diagnostics> {
    checked("case.ron", text).map(|(graph, warnings)| (format!("{}{warnings}", described(&graph)), warnings.len()))
}

#[test]
fn what_many_wrong_files_are_reported_changes_only_where_it_is_meant_to() {
    let files = std::fs::read_dir(folder()).expect("the folder of cases").map(|entry| entry.expect("an entry").path());
    let mut cases: Vec<_> = files.filter(|path| path.extension().is_some_and(|end| end == "ron")).collect();
    cases.sort();
    let mut table = Row::of(LYNX, pipeline).line("a good pipeline");
    for case in cases {
        let text = std::fs::read_to_string(&case).expect("a case is text");
        let name = case.file_stem().expect("a file has a name").to_string_lossy().into_owned();
        table += &Row::of(&text, pipeline).line(&name);
    }
    let kind = |declaration: &str, shader: &str| {
        folder_kind(("node.ron", declaration), ("posterize.wgsl", shader)).map(|kind| (described_kind(&kind), 0))
    };
    table += &Row::of(DECLARATION, |text| kind(text, SHADER)).line("a declaration");
    table += &Row::of(SHADER, |text| kind(DECLARATION, text)).line("a shader");
    assert_known("mutated.tsv", &table);
}

#[track_caller]
fn assert_known(file: &str, table: &str) {
    let path = folder().join(file);
    if std::env::var_os("AFTERIMAGE_BLESS").is_some() {
        std::fs::write(&path, table).expect("the folder of cases can be written");
    }
    let known = std::fs::read_to_string(&path).unwrap_or_default();
    let changed: Vec<(&str, &str)> = known.lines().zip(table.lines()).filter(|(old, new)| old != new).collect();
    assert!(changed.is_empty(), "if this is meant, set AFTERIMAGE_BLESS=1: {changed:#?}");
    assert_eq!(known.lines().count(), table.lines().count());
}

/// A kind with a field of each name that a declaration may have.
const TINT: &str = r#"Kind(
    name: "Tint",
    doc: "Tints.",
    inputs: {
        "source": Image(doc: "The image.", accepts: [Scene, Exposed, DisplayLinear, Encoded]),
        "mask": Image(doc: "Where.", optional: true),
        "table": Table(doc: "A table.", optional: true),
        "level": Value(doc: "A value.", optional: true),
        "eye": Camera(doc: "The camera."),
    },
    images: {
        "levels": Pyramid(down: "source", levels: 4),
        "soft": Pyramid(each: "levels", reads: { "low": Level("levels", 0) }),
        "wide": Image(up: "levels", reads: { "high": Level("soft", 2) }),
        "small": Image(format: R32Float, size: Fixed(64, 32)),
    },
    outputs: {
        "result": Image(doc: "The result.", state: Same("source"), fallback: "source"),
        "other": Image(doc: "Another.", state: Encoded, function: "tint_over", size: Half, fallback: Zero),
        "none": Image(doc: "A third.", state: Same("source"), function: "tint_over", fallback: Absent),
        "pile": Pyramid(doc: "Levels.", state: Same("source"), each: "soft", function: "tint_pile"),
    },
    parameters: {
        "gain": Float(doc: "Gain.", default: 4.0, within: (2.0, 256.0), usually: (2.0, 16.0), unit: "1", neutral: 2.0),
        "count": Int(doc: "A number.", default: 3, within: (1, 9)),
        "strong": Bool(doc: "Whether it is strong.", default: false),
        "place": Vector2(doc: "A place.", default: (0.5, 0.5), within: (0.0, 1.0)),
        "color": Vector3(doc: "A color.", default: (0.5, 0.5, 1.0), within: (0.0, 1.0)),
    },
)
"#;

const TINT_SHADER: &str = "#import camera
#import table
struct Tint { gain: f32, count: i32, strong: u32, place: vec2f, color: vec3f }

fn tint_levels(source: texture_2d<f32>, at: Point) -> vec4f { return texel(source, 2 * at.pixel); }
fn tint_soft(levels: vec4f, low: texture_2d<f32>, at: Point, frame: Frame) -> vec4f {
    return levels * frame.time + texel(low, at.pixel);
}
fn tint_wide(levels: vec4f, coarser: texture_2d<f32>, high: texture_2d<f32>, at: Point) -> vec4f {
    return levels + texel(coarser, at.pixel / 2) + texel(high, at.pixel);
}
fn tint_small(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    return tap(source, source_sampler, at.uv);
}
fn tint(source: vec4f, mask: texture_2d<f32>, mask_sampler: sampler, wide: texture_2d<f32>, small: texture_2d<f32>,
        level: f32, eye: Camera, at: Point, params: Tint) -> vec4f {
    let far = camera_distance(eye, at.uv, level) * params.gain;
    return source * tap(mask, mask_sampler, at.uv).x + texel(wide, at.pixel) + far * texel(small, at.pixel);
}
fn tint_over(source: texture_2d<f32>, table: texture_2d<f32>, at: Point) -> vec4f {
    return texel(source, at.pixel) * texel(table, at.pixel);
}
fn tint_pile(soft: vec4f, params: Tint) -> vec4f { return soft * vec4f(params.color, params.place.x); }
";

/// All that a folder kind declares and records, without what its shader computes.
fn described_folder(kind: &NodeKind) -> String {
    let mut text = described_kind(kind);
    for_each_recording(kind, &mut |recording| {
        let (images, buffers, passes) = (&recording.images, &recording.buffers, &recording.passes);
        write!(text, "{images:?}{buffers:?}{passes:?}").expect("a string grows");
    });
    text
}

/// The texts of a kind in the folder `tests/folders`, and those that it shares.
fn texts_of(name: &str) -> (String, String, String) {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/folders");
    let read = |file: &str| {
        let path = root.join(file);
        std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    };
    (read(&format!("{name}/node.ron")), read(&format!("{name}/{name}.wgsl")), read("lib/gauss.wgsl"))
}

#[test]
fn what_many_wrong_folders_are_reported_changes_only_where_it_is_meant_to() {
    let mut table = String::new();
    let (_, _, shared) = texts_of("crt");
    let haze = (super::folder_images::DECLARATION, super::folder_images::SHADER);
    let crt = texts_of("crt");
    let blur = texts_of("soft_blur");
    for (name, declaration, shader) in [
        ("tint", TINT, TINT_SHADER),
        ("haze", haze.0, haze.1),
        ("crt", crt.0.as_str(), crt.1.as_str()),
        ("soft_blur", blur.0.as_str(), blur.1.as_str()),
    ] {
        let file = format!("{name}.wgsl");
        let kind = |declaration: &str, shader: &str| {
            let own = [(file.as_str(), shader)];
            let kind = folder_kind_sharing(("node.ron", declaration), &own, &[("gauss.wgsl", shared.as_str())]);
            kind.map(|kind| (described_folder(&kind), 0))
        };
        let whole = kind(declaration, shader);
        assert!(whole.is_ok(), "{name}: {}", whole.expect_err("it is no kind"));
        for part in 0..6 {
            let texts = |text: &str, seed: u64| changed(text, 1000 * part + seed);
            let mut row = Row { hash: FNV_START, ..Row::default() };
            (0..TEXTS).for_each(|seed| row.add(kind(&texts(declaration, seed), shader)));
            (0..TEXTS / 4).for_each(|seed| row.add(kind(declaration, &texts(shader, seed))));
            table += &row.line(&format!("{name} {part}"));
        }
    }
    assert_known("folders.tsv", &table);
}
