//! Texts that are compared with files in `golden/`: reports of plans, and the code of each kind of pass.
//! `AFTERIMAGE_BLESS=1` writes the files again; then read the difference, and look at the pictures.

use std::fmt::Write as _;
use std::path::Path;

use afterimage_generators::Recipe;
use afterimage_graph::image::Size;
use afterimage_graph::node::PassKind;
use afterimage_plan::codegen::CodeOptions;
use afterimage_plan::{Alias, Caps, Options, Plan, When, diff, verify};

use super::fusion::planned_at;
use super::support::{FRAME, all_formats, plan_on};

/// Compares a text with its file.
pub fn assert_golden(name: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    if std::env::var_os("AFTERIMAGE_BLESS").is_some() {
        std::fs::write(&path, text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    let known = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let lines = || known.lines().zip(text.lines()).enumerate();
    if let Some((line, (old, new))) = lines().find(|(_, (old, new))| old != new) {
        panic!("{name}:{}: if this is meant, set AFTERIMAGE_BLESS=1\n- {old}\n+ {new}", line + 1);
    }
    assert_eq!(known.len(), text.len(), "{name} has another length: if this is meant, set AFTERIMAGE_BLESS=1");
}

const SMALL: Recipe = Recipe { seed: 5, nodes: 11, histories: 2, off: 15 };

fn example(options: Options, caps: Caps) -> Plan {
    let plan = plan_on(&SMALL.graph(), FRAME, options, caps).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(verify(&plan), Ok(()));
    plan
}

#[test]
fn the_reports_of_a_plan_are_as_known() {
    let plan = example(Options::default(), all_formats());
    assert_golden("placed.txt", &plan.to_text());
    assert_golden("placed.svg", &plan.to_svg());
    let pooled = example(Options { alias: Alias::Pool, fuse: false, ..Options::default() }, all_formats());
    assert_golden("pooled.txt", &pooled.to_text());
    assert_golden("pooled.svg", &pooled.to_svg());
    assert_golden("placed-to-pooled.txt", &diff(&plan, &pooled).to_string());
    let drawn = example(
        Options { alias: Alias::None, ..Options::default() },
        Caps { prefer_fragment: true, ..Caps::default() },
    );
    assert_golden("drawn.txt", &drawn.to_text());
    assert_golden("drawn.svg", &drawn.to_svg());
}

/// Nodes of built-in kinds with every kind of pass, and textures of the host that may hold any number.
const KINDS: &str = r#"
    "dim": Dim(source: "in"), "half": Downsample(source: "dim", levels: 3), "bloom": Upsample(source: "half"),
    "soft": Soft(source: "in"), "softer": Soft(source: "soft"), "far": Far(source: "softer"),
    "lit": Composite(base: "far", bloom: "bloom"), "past": Composite(base: "lit", bloom: "far@previous"),
    "bins": Histogram(source: "in"), "meter": AutoExposure(histogram: "bins"),
    "bright": Exposure(source: "past", meter: "meter"),
    "mean": LogGaussian(source: "in", width: 16, height: 8, sigma: 0.0),
    "wide": LogGaussian(source: "in", width: 32, height: 16, sigma: 0.1),
    "late": Late(source: "bright"),
"#;

fn kinds(size: Size, options: Options) -> Plan {
    planned_at(size, KINDS, r#""late": "late", "mean": "mean", "wide": "wide""#, options)
}

/// The part of a module that is generated: from its first item that is neither of a kernel nor of the library.
fn generated(source: &str) -> &str {
    let marks = ["struct PassUniform", "fn run", "fn point_at", "fn point_of_source", "@compute"];
    &source[marks.into_iter().filter_map(|mark| source.find(mark)).min().expect("an entry point")..]
}

#[test]
fn the_code_of_each_kind_of_pass_is_as_known() {
    let always = Options { row_downsample: When::Always, ..Options::default() };
    let mut seen = Vec::new();
    let mut text = String::new();
    for options in [always, Options { fuse: false, ..always }] {
        let plan = kinds(Size::new(1300, 724), options);
        for (index, planned) in plan.passes.iter().enumerate() {
            let composed = plan
                .compose(index, CodeOptions { immediates: index % 2 == 0, ..Default::default() })
                .unwrap_or_else(|error| panic!("{error}"));
            composed.validate().unwrap_or_else(|error| panic!("{}: {error}", planned.pass.label));
            let kind = std::mem::discriminant(&planned.pass.kind);
            let is_new = seen.iter().filter(|known| **known == kind).count() < 2;
            if is_new && planned.pass.kind != PassKind::Compute {
                seen.push(kind);
                writeln!(text, "// {} {:?}", planned.pass.label, planned.workgroups).expect("a string grows");
                writeln!(text, "{}\n", generated(&composed.source)).expect("a string grows");
            }
        }
    }
    assert_golden("code.txt", &text);
}
