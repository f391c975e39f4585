//! `explain`: every code has a page, and every example on it is what it says.

use std::collections::BTreeSet;
use std::path::Path;

use afterimage_graph::check::{CheckOptions, NoFiles, check};
use afterimage_graph::diagnostic::Diagnostics;
use afterimage_graph::document::parse;
use afterimage_graph::node::{Registry, folder_kind};

use super::Folder;

/// The files of a kind that the examples about kinds in folders change.
const DECLARATION: &str = r#"Kind(
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
const SHADER: &str = "struct Posterize { levels: f32 }
fn posterize(source: vec4f, mask: texture_2d<f32>, mask_sampler: sampler, at: Point, params: Posterize) -> vec4f {
    let steps = params.levels - 1.0;
    let levels = round(source.rgb * steps) / steps;
    return vec4f(mix(levels, source.rgb, tap(mask, mask_sampler, at.uv).x), source.a);
}
";

fn codes() -> Vec<String> {
    let list = Folder::new("codes").run("explain").good();
    let lines = list.lines().filter(|line| !line.starts_with(' '));
    lines.filter_map(|line| line.split_whitespace().next()).map(str::to_owned).collect()
}

/// The example of a page before and after it is mended; `None` if it has none.
fn example(page: &str) -> Option<[String; 2]> {
    let (_, lines) = page.split_once("\n\n")?;
    let with = |sign: &str| {
        let lines = lines.lines().filter_map(|line| line.strip_prefix(sign).or_else(|| line.strip_prefix("  ")));
        lines.collect::<Vec<_>>().join("\n")
    };
    Some([with("- "), with("+ ")])
}

/// All errors and warnings of an example: a whole pipeline, the nodes of one, or lines of a kind in a folder.
fn found(example: &str, mended: &str) -> Diagnostics {
    if DECLARATION.contains(mended) || SHADER.contains(mended) {
        let [declaration, shader] = [DECLARATION, SHADER].map(|text| text.replacen(mended, example, 1));
        let kind = folder_kind(("posterize/node.ron", &declaration), ("posterize/posterize.wgsl", &shader));
        return kind.err().unwrap_or_default();
    }
    let framed = format!(
        "Pipeline(inputs: {{ \"scene\": Color }}, nodes: {{ {example} }}, outputs: {{ \"picture\": \"result\" }})"
    );
    let text = if mended.starts_with("Pipeline(") { example } else { &framed };
    let registry = Registry::new(&[afterimage_nodes::ALL]).expect("names are unique");
    let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
    let checked = parse("example.ron", text).and_then(|document| check(&document, &registry, &options));
    checked.map_or_else(|errors| errors, |(_, warnings)| warnings)
}

#[test]
fn every_example_has_its_error_and_is_mended() {
    let folder = Folder::new("explain");
    let (mut wrong, mut examples) = (Vec::new(), 0);
    for code in codes() {
        let page = folder.run(&format!("explain {code}")).good();
        let Some([before, after]) = example(&page) else { continue };
        examples += 1;
        let told = found(&before, &after);
        if told.is_empty() || told.iter().any(|one| one.code != code) {
            wrong.push(format!("{code}: the example tells\n{told}"));
        }
        let left = found(&after, &after);
        if !left.is_empty() {
            wrong.push(format!("{code}: mended, the example still tells\n{left}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(examples >= 39, "{examples}");
}

/// The codes that the sources of the product give to diagnostics.
fn codes_of(folder: &Path, codes: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() && path.file_name().is_some_and(|name| name != "target" && name != "tests") {
            codes_of(&path, codes);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let text = std::fs::read_to_string(&path).expect("a source is text");
            for start in ["Diagnostic::error(", "Diagnostic::warning(", "Self::error(", "unknown("] {
                let after = text.split(start).skip(1).filter_map(|rest| rest.trim_start().strip_prefix('"'));
                codes.extend(after.filter_map(|rest| rest.split('"').next()).map(str::to_owned));
            }
        }
    }
}

#[test]
fn every_code_has_a_page() {
    let mut given = BTreeSet::new();
    codes_of(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../graph"), &mut given);
    let explained: BTreeSet<String> = codes().into_iter().collect();
    let missing: Vec<&String> = given.difference(&explained).collect();
    assert!(missing.is_empty(), "no page: {missing:?}");
    assert!(given.len() > 60, "{given:?}");
}

#[test]
fn a_code_is_found_as_it_is_printed() {
    let folder = Folder::new("printed");
    let page = folder.run("explain cycle").good();
    assert_eq!(folder.run("explain error[cycle]").good(), page);
    folder.run("explain cicle").fails_saying(1, &["no error or warning has the code `cicle`", "did you mean `cycle`?"]);
}
