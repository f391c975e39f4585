//! Color corrections.

use afterimage_color::lut::{ColorCorrection, parse_correction};
use afterimage_color::process::Process;

#[test]
fn corrections_are_found_in_every_kind_of_file() {
    let warm = parse_correction(include_str!("files/warm.cc"), "").expect("a correction");
    let expected = ColorCorrection {
        slope: [1.1, 1.0, 0.9],
        offset: [0.01, 0.0, -0.02],
        power: [1.2, 1.0, 0.8],
        saturation: 1.25,
    };
    assert_eq!(warm, expected);
    let shots = include_str!("files/shots.ccc");
    assert_eq!(parse_correction(shots, "sh010").expect("a correction").slope, [1.2, 1.1, 1.0]);
    let gray = ColorCorrection { saturation: 0.5, ..ColorCorrection::NEUTRAL };
    assert_eq!(parse_correction(shots, "sh020").expect("a correction"), gray);
    let edit = parse_correction(include_str!("files/edit.cdl"), "").expect("the only correction");
    assert_eq!((edit.offset, edit.power, edit.saturation), ([0.1, 0.0, 0.0], [2.0, 1.0, 1.0], 0.8));
    let other_names = include_str!("files/edit.cdl").replace("SOPNode", "ASC_SOP").replace("SatNode", "ASC_SAT");
    assert_eq!(parse_correction(&other_names, "a").expect("the other names of the standard"), edit);
}

#[test]
fn a_correction_computes_what_the_standard_states() {
    let edit = parse_correction(include_str!("files/edit.cdl"), "a").expect("a correction");
    // Slope, offset and power: (0.9 * 0.5 + 0.1)^2 = 0.3025, 0.18 and 0.9. Their luminance is 0.25802750.
    let found = Process::from(edit).apply([0.5, 0.2, 1.0]);
    for (found, expected) in found.into_iter().zip([0.2936055, 0.1956055, 0.7716055]) {
        assert!((found - expected).abs() < 1e-6, "{found} instead of {expected}");
    }
}

#[test]
fn a_malformed_correction_is_reported() {
    let shots = include_str!("files/shots.ccc");
    let list = |body: &str| format!("<ColorDecisionList>\n{body}\n</ColorDecisionList>");
    let correction = |body: &str| format!("<ColorCorrection>\n{body}\n</ColorCorrection>");
    let sop =
        |slope: &str| format!("<SOPNode>\n<Slope>{slope}</Slope><Offset>0 0 0</Offset><Power>1 1 1</Power></SOPNode>");
    let table = [
        (shots.to_owned(), "", "the file has 2 corrections: set `id`; the ids are `sh010`, `sh020`"),
        (shots.to_owned(), "sh030", "no correction has the id `sh030`; the ids are `sh010`, `sh020`"),
        (shots.replace("sh020", "sh010"), "sh010", "line 10: the id `sh010` is there twice"),
        ("<ProcessList/>".into(), "", "line 1: `ProcessList` is no element of a color correction"),
        ("<ColorCorrectionCollection/>".into(), "", "line 1: the file has no `ColorCorrection`"),
        (
            list("<ColorDecision><ColorCorrectionRef ref=\"z\"/></ColorDecision>"),
            "",
            "line 2: no correction of the file has the id `z`",
        ),
        (correction(&sop("1 1")), "", "line 3: `Slope` has 3 numbers, not 2"),
        (correction(&sop("1 1 -1")), "", "line 3: a slope is 0 or more"),
        (correction(&sop("1 inf 1")), "", "line 3: `inf` is not finite"),
        (correction("<SOPNode><Slope>1 1 1</Slope></SOPNode>"), "", "line 2: `SOPNode` has no `Offset`"),
        (correction("<SopNode/>"), "", "line 2: a correction has no element `SopNode`"),
        (correction("<SatNode/><SatNode/>"), "", "line 2: `SatNode` is there twice"),
        ("<ColorCorrection>".into(), "", "line 1: the XML cannot be read"),
    ];
    for (text, id, expected) in table {
        let error = parse_correction(&text, id).expect_err(&text).to_string();
        assert!(error.starts_with(expected), "{text}\n{error}");
    }
}
