//! Color corrections, and tables of Imageworks.

use afterimage_color::lut::{ColorCorrection, Interpolation, parse_correction, parse_spi1d, parse_spi3d};
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

#[test]
fn tables_of_imageworks_are_read() {
    let toe =
        Process::of_table(&parse_spi1d(include_str!("files/toe.spi1d")).expect("a table"), Interpolation::Trilinear);
    // Entries 4 and 29 are those of 0.03125 and 1.0078125.
    let found = toe.apply([0.03125, 1.0078125, -1.0]);
    for (found, expected) in found.into_iter().zip([0.07432544, 1.00585364, -0.21022410]) {
        assert!((found - expected).abs() < 1e-6, "{found} instead of {expected}");
    }
    let channels = parse_spi1d("Version 1\nFrom 0 2\nLength 2\nComponents 3\n{\n0 1 2\n3 4 5\n}\n").expect("a table");
    let found = Process::of_table(&channels, Interpolation::Trilinear).apply([1.0; 3]);
    assert_eq!(found, [1.5, 2.5, 3.5]);
    // The entries may come in any order.
    let text = "SPILUT 1.0\n3 3\n2 2 2\n1 0 0 4 0 0\n0 0 0 0 0 0\n0 1 0 2 0 0\n0 0 1 1 0 0\n1 1 0 6 0 0\n1 0 1 5 0 0\n\
                0 1 1 3 0 0\n1 1 1 7 0 0\n";
    let cube = Process::of_table(&parse_spi3d(text).expect("a table"), Interpolation::Trilinear);
    assert_eq!(cube.apply([1.0, 0.0, 0.0]), [4.0, 0.0, 0.0]);
    assert_eq!(cube.apply([0.5, 0.25, 0.75]), [3.25, 0.0, 0.0]);
}

#[test]
fn malformed_tables_of_imageworks_are_reported() {
    let head = "Version 1\nFrom 0 1\nLength 2\nComponents 1\n";
    let curves = [
        ("Version 2\n".to_owned(), "line 1: the version is 1, not `2`"),
        ("Version 1\nLength 1\n".into(), "line 2: the length must be a whole number from 2 to 65536, not `1`"),
        ("Version 1\nComponents 4\n".into(), "line 2: the number of components is 1, 2 or 3, not `4`"),
        ("Version 1\nFrom 1 0\n".into(), "line 2: the domain must end above its beginning"),
        ("Version 1\nSize 2\n".into(), "line 2: `Size` is no keyword of a .spi1d file"),
        ("Version 1\nLength 2\n{\n".into(), "line 3: `Length` and `Components` must stand before `{`"),
        (format!("{head}{{\n0\n"), "line 6: the table ends after 1 of 2 entries"),
        (format!("{head}{{\n0\n1\n2\n}}\n"), "line 8: there are more than the 2 entries of the table"),
        (format!("{head}{{\n0\nnan\n}}\n"), "line 7: `nan` is not finite"),
        (format!("{head}{{\n0\n1e9\n}}\n"), "line 7: the entry 1e9 is beyond 65504"),
    ];
    for (text, expected) in curves {
        let error = parse_spi1d(&text).expect_err(&text).to_string();
        assert!(error.starts_with(expected), "{text}\n{error}");
    }
    let cubes = [
        ("LUT\n", "line 1: the first line is `SPILUT 1.0`, not `LUT`"),
        ("SPILUT 1.0\n3 4\n", "line 2: the components are `3 3`, not `3 4`"),
        ("SPILUT 1.0\n3 3\n2 2 3\n", "line 3: the table has three equal sides, not `2 2 3`"),
        ("SPILUT 1.0\n3 3\n256 256 256\n0 0 0 0 0 0\n", "line 4: the file ends after 1 of 16777216 entries"),
        ("SPILUT 1.0\n3 3\n", "line 1: the file ends before the sides of the table"),
    ];
    for (text, expected) in cubes {
        let error = parse_spi3d(text).expect_err(text).to_string();
        assert!(error.starts_with(expected), "{text}\n{error}");
    }
    let twice = format!("SPILUT 1.0\n3 3\n2 2 2\n{}", "0 0 1 0 0 0\n".repeat(8));
    assert_eq!(parse_spi3d(&twice).expect_err("twice").to_string(), "line 5: the entry 0 0 1 is there twice");
    let outside = format!("SPILUT 1.0\n3 3\n2 2 2\n{}", "0 0 2 0 0 0\n".repeat(8));
    let error = parse_spi3d(&outside).expect_err("outside").to_string();
    assert_eq!(error, "line 4: a place in the table is three whole numbers below 2");
}
