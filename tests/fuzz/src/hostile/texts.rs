//! Pipelines and color files.

use std::path::Path;
use std::sync::OnceLock;

use afterimage_generators::{BOMBS, Rng};

use crate::case::Case;
use crate::classes::Sources;

/// Sizes of bombs: below the limits, at them, and beyond.
pub(crate) const SIZES: [usize; 6] = [100, 1000, 4000, 10_000, 16_384, 40_000];

/// A table that any pipeline may name.
const CUBE: &str = "LUT_3D_SIZE 2\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 0.9 1\n";

/// The names and texts of the shipped pipelines.
pub(crate) fn shipped() -> &'static [(String, Vec<u8>)] {
    static SHIPPED: OnceLock<Vec<(String, Vec<u8>)>> = OnceLock::new();
    SHIPPED.get_or_init(|| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines");
        let entries = std::fs::read_dir(folder).expect("the shipped pipelines").flatten().map(|entry| entry.path());
        let files = entries.filter(|path| path.extension().is_some_and(|extension| extension == "ron"));
        let named = files.map(|path| {
            let name = path.file_name().expect("a file has a name").to_string_lossy().into_owned();
            (name, std::fs::read(&path).expect("a pipeline"))
        });
        named.collect()
    })
}

pub(crate) fn pipeline(sources: &Sources, number: u64) -> Case {
    let case = Case::new("check self.ron --plan").with("table.cube", CUBE);
    let case = shipped().iter().fold(case, |case, (name, text)| case.with(name, text.clone()));
    case.with("self.ron", sources.documents.get(number))
}

pub(crate) fn bomb(_: &Sources, number: u64) -> Case {
    let (_, make) = BOMBS[number as usize / SIZES.len()];
    let bomb = make(SIZES[number as usize % SIZES.len()]);
    let case = Case::new("plan bomb.ron --size 3840x2160").with("bomb.ron", bomb.text);
    bomb.files.into_iter().fold(case, |case, (name, text)| case.with(&name, text))
}

/// A pipeline file that no editor writes.
pub(crate) fn odd(sources: &Sources, number: u64) -> Case {
    let mut rng = Rng::new(sources.seed << 32 | number);
    let times = [1, 30, 40, 1000, 100_000, 2_000_000][rng.below(6)];
    let (_, whole) = &shipped()[rng.below(shipped().len())];
    let pieces: [&str; 12] =
        ["(", "[", "{", "((", "{\"a\":", "Pipeline(", "/*", "\"", "r#\"", "-", "Some(", "nodes: { \"a\": Blur("];
    let piece = pieces[rng.below(pieces.len())];
    let bytes = match rng.below(8) {
        0 => piece.repeat(times.min(4_000_000 / piece.len())).into_bytes(),
        1 => [piece.repeat(times.min(100_000)).into_bytes(), whole.clone()].concat(),
        2 => (0..times.min(100_000)).map(|_| rng.below(256) as u8).collect(),
        3 => whole.iter().flat_map(|byte| [*byte, 0]).collect(),
        4 => [&[0xef, 0xbb, 0xbf][..], &whole[..rng.below(whole.len())]].concat(),
        5 => {
            let at = rng.below(whole.len());
            [&whole[..at], &[[0x00, 0x1b, 0x7f, 0x9b, 0xff, 0xc2][rng.below(6)]], &whole[at..]].concat()
        }
        6 => format!("Pipeline(inputs: {{\"{}\": Color}})", "\u{1b}[2J\u{9b}".repeat(1 + times.min(5000))).into_bytes(),
        _ => vec![[b' ', b'\n', 0, b'/'][rng.below(4)]; times * 2],
    };
    Case::new("check odd.ron").with("odd.ron", bytes)
}

/// A color file where the kinds that read one have it.
pub(crate) fn table(sources: &Sources, number: u64) -> Case {
    let source = if number.is_multiple_of(2) { &sources.cubes } else { &sources.color_files };
    let node = match number % 4 {
        3 => r#"Cdl(source: "scene", file: "table")"#,
        _ => r#"ColorLut(source: "scene", file: "table")"#,
    };
    let text =
        format!(r#"Pipeline(inputs: {{ "scene": Encoded }}, nodes: {{ "a": {node} }}, outputs: {{ "out": "a" }})"#);
    Case::new("check table.ron --plan").with("table.ron", text).with("table", source.get(number))
}
