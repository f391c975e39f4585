//! Common LUT Format: each process node by values that follow from the specification, and files that are refused.

use afterimage_color::lut::PngLayout;
use afterimage_color::lut_file::{LutFile, parse_lut_file};
use afterimage_color::parse_clf;
use afterimage_color::process::Process;

fn list(nodes: &str) -> String {
    format!("<ProcessList id=\"test\" compCLFversion=\"3.0\">\n{nodes}\n</ProcessList>")
}

fn process(nodes: &str) -> Process {
    parse_clf(&list(nodes)).unwrap_or_else(|error| panic!("{nodes}: {error}"))
}

/// A process node with 32-bit numbers.
fn node(name: &str, attributes: &str, body: &str) -> String {
    format!("<{name} inBitDepth=\"32f\" outBitDepth=\"32f\" {attributes}>{body}</{name}>")
}

fn assert_maps(nodes: &str, from: [f64; 3], to: [f64; 3]) {
    let found = process(nodes).apply(from);
    let is_close = (0..3).all(|channel| (found[channel] - to[channel]).abs() <= 2e-7 * to[channel].abs().max(1.0));
    assert!(is_close, "{nodes}\n{from:?} became {found:?} instead of {to:?}");
}

/// The result of the red channel, for functions that treat all channels alike.
fn assert_red(nodes: &str, from: f64, to: f64) {
    assert_maps(nodes, [from; 3], [to; 3]);
}

#[test]
fn a_matrix_includes_the_bit_depths() {
    let plain = "<Array dim=\"3 3\">1 2 3\n4 5 6\n7 8 9</Array>";
    assert_maps(&node("Matrix", "", plain), [1.0, 10.0, -1.0], [18.0, 48.0, 78.0]);
    // 10 to 12 bits: the coefficients of the identity are 4095/1023, and 409.5 of 4095 is a tenth.
    let scaled =
        "<Array dim=\"3 4\">4.002932551319648 0 0 409.5  0 4.002932551319648 0 0  0 0 4.002932551319648 -4095</Array>";
    let nodes = format!("<Matrix inBitDepth=\"10i\" outBitDepth=\"12i\">{scaled}</Matrix>");
    assert_maps(&nodes, [0.5, 0.25, 1.0], [0.6, 0.25, 0.0]);
    let of_version_2 = plain.replace("3 3", "3 3 3");
    assert_maps(&node("Matrix", "", &of_version_2), [1.0, 0.0, 0.0], [1.0, 4.0, 7.0]);
}

#[test]
fn a_range_scales_and_limits() {
    let values = "<minInValue>0</minInValue><maxInValue>1023</maxInValue>\
                  <minOutValue>64</minOutValue><maxOutValue>940</maxOutValue>";
    let range = |style: &str| format!("<Range inBitDepth=\"10i\" outBitDepth=\"10i\" {style}>{values}</Range>");
    for style in ["", "style=\"Clamp\""] {
        assert_maps(&range(style), [0.0, 1.0, 2.0], [64.0 / 1023.0, 940.0 / 1023.0, 940.0 / 1023.0]);
        assert_red(&range(style), -1.0, 64.0 / 1023.0);
    }
    assert_red(&range("style=\"noClamp\""), 2.0, 1816.0 / 1023.0);
    assert_red(&range("style=\"noClamp\""), -1.0, -812.0 / 1023.0);
    let low = "<minInValue>102.3</minInValue><minOutValue>409.5</minOutValue>";
    let low = format!("<Range inBitDepth=\"10i\" outBitDepth=\"12i\">{low}</Range>");
    assert_maps(&low, [0.05, 0.5, 70.0], [0.1, 0.5, 70.0]);
    let high = node("Range", "", "<maxInValue>0.75</maxInValue><maxOutValue>0.75</maxOutValue>");
    assert_maps(&high, [-9.0, 0.5, 1.0], [-9.0, 0.5, 0.75]);
}

#[test]
fn logarithms_follow_their_styles() {
    let log = |style: &str, params: &str| node("Log", &format!("style=\"{style}\""), params);
    assert_maps(&log("log10", ""), [100.0, 1.0, 0.001], [2.0, 0.0, -3.0]);
    assert_maps(&log("log2", ""), [8.0, 0.25, 1.0], [3.0, -2.0, 0.0]);
    // Light of 0 counts as the smallest normal number of 32 bits.
    assert_red(&log("log2", ""), -1.0, -126.0);
    assert_red(&log("log10", ""), 0.0, -37.92977945366162);
    assert_maps(&log("antiLog10", ""), [2.0, 0.0, -3.0], [100.0, 1.0, 0.001]);
    assert_maps(&log("antiLog2", ""), [3.0, -2.0, 0.0], [8.0, 0.25, 1.0]);
    let params = "<LogParams base=\"10\" logSideSlope=\"0.5\" logSideOffset=\"0.1\" linSideSlope=\"2\" \
                  linSideOffset=\"3\"/>";
    // 0.5 * log10(2 * 48.5 + 3) + 0.1
    assert_red(&log("linToLog", params), 48.5, 1.1);
    assert_red(&log("logToLin", params), 1.1, 48.5);
}

#[test]
fn logarithms_of_cameras_have_a_line_near_black() {
    let log = |style: &str, params: &str| node("Log", &format!("style=\"{style}\""), params);
    // ACEScct (Academy S-2016-001): its published slope and offset are those of the tangent.
    let cct = "<LogParams logSideSlope=\"0.0570776255707763\" logSideOffset=\"0.554794520547945\" \
               linSideBreak=\"0.0078125\"/>";
    assert_maps(&log("cameraLinToLog", cct), [0.0, 0.0078125, 1.0], [0.0729055, 0.1552511, 0.5547945]);
    assert_red(&log("cameraLinToLog", cct), -0.01, 0.0729055341958355 - 0.105402377416545);
    assert_maps(&log("cameraLogToLin", cct), [0.0729055342, 0.155251142, 0.554794521], [0.0, 0.0078125, 1.0]);
    // DJI D-Log, of which the specification states the slope.
    let dlog = "<LogParams base=\"10\" logSideSlope=\"0.256663\" logSideOffset=\"0.584555\" linSideSlope=\"0.9892\" \
                linSideOffset=\"0.0108\" linSideBreak=\"0.0078\" linearSlope=\"6.025\"/>";
    // The line passes through the curve at the break: 0.256663 * log10(0.01851576) + 0.584555 = 0.1399027.
    let at_break = 0.256663 * 0.01851576_f64.log10() + 0.584555;
    assert_maps(&log("cameraLinToLog", dlog), [0.0078, 0.0, 1.0], [at_break, at_break - 6.025 * 0.0078, 0.584555]);
    assert_red(&log("cameraLogToLin", dlog), at_break - 6.025 * 0.0078, 0.0);
    let one = "<LogParams channel=\"R\" linSideSlope=\"2\"/><LogParams channel=\"G\"/><LogParams channel=\"B\"/>";
    assert_maps(&log("linToLog", one), [4.0, 4.0, 8.0], [3.0, 2.0, 3.0]);
}

#[test]
fn exponents_follow_their_styles() {
    let power = |style: &str, params: &str| {
        node("Exponent", &format!("style=\"{style}\""), &format!("<ExponentParams {params}/>"))
    };
    let square = "exponent=\"2\"";
    assert_maps(&power("basicFwd", square), [-2.0, 3.0, 0.5], [0.0, 9.0, 0.25]);
    assert_maps(&power("basicRev", square), [-4.0, 9.0, 0.25], [0.0, 3.0, 0.5]);
    assert_maps(&power("basicMirrorFwd", square), [-2.0, 3.0, 0.0], [-4.0, 9.0, 0.0]);
    assert_maps(&power("basicMirrorRev", square), [-4.0, 9.0, 0.0], [-2.0, 3.0, 0.0]);
    assert_maps(&power("basicPassThruFwd", square), [-2.0, 3.0, 0.5], [-2.0, 9.0, 0.25]);
    assert_maps(&power("basicPassThruRev", square), [-4.0, 9.0, 0.25], [-4.0, 3.0, 0.5]);
    // sRGB: ((0.5 + 0.055) / 1.055)^2.4, and the line of slope 1/12.9232 below 0.0393.
    let srgb = "exponent=\"2.4\" offset=\"0.055\"";
    assert_maps(&power("monCurveFwd", srgb), [0.5, 0.02, -0.02], [0.214041140, 0.00154760, -0.00154760]);
    assert_maps(&power("monCurveRev", srgb), [0.214041140, 0.00154760, -0.00154760], [0.5, 0.02, -0.02]);
    assert_maps(&power("monCurveMirrorFwd", srgb), [-0.5, 0.5, -0.02], [-0.214041140, 0.214041140, -0.00154760]);
    assert_maps(&power("monCurveMirrorRev", srgb), [-0.214041140, 0.214041140, 0.0], [-0.5, 0.5, 0.0]);
    // An exponent of 1 and an offset of 0 divide by 0 in the formula.
    assert_maps(&power("monCurveFwd", "exponent=\"1\" offset=\"0\""), [0.5, -1.0, 2.0], [0.5, -1.0, 2.0]);
    let red = node("Exponent", "style=\"basicFwd\"", "<ExponentParams channel=\"R\" exponent=\"2\"/>");
    assert_maps(&red, [3.0, 3.0, -3.0], [9.0, 3.0, 0.0]);
}

#[test]
fn color_decision_lists_follow_their_styles() {
    let cdl = |style: &str| {
        let sop = "<Slope>2 2 2</Slope><Offset>-0.1 -0.1 -0.1</Offset><Power>2 2 2</Power>";
        let sat = "<SatNode><Saturation>0.5</Saturation></SatNode>";
        node("ASC_CDL", style, &format!("<SOPNode>{sop}</SOPNode>{sat}"))
    };
    // Squares: 0.25, 0.09 and the limited 1. Their luminance is 0.189718.
    let limited = [0.219859, 0.139859, 0.594859];
    assert_maps(&cdl(""), [0.3, 0.2, 0.6], limited);
    assert_maps(&cdl("style=\"Fwd\""), [0.3, 0.2, 0.6], limited);
    assert_maps(&cdl("style=\"Rev\""), limited, [0.3, 0.2, 0.55]);
    // Without limits blue is 1.21, and the luminance 0.20488.
    let free = [0.22744, 0.14744, 0.70744];
    assert_maps(&cdl("style=\"FwdNoClamp\""), [0.3, 0.2, 0.6], free);
    assert_maps(&cdl("style=\"RevNoClamp\""), free, [0.3, 0.2, 0.6]);
    // Values below 0 skip the power: 2 * -0.2 - 0.1.
    assert_red(&cdl("style=\"FwdNoClamp\""), -0.2, -0.5);
    assert_red(&cdl("style=\"RevNoClamp\""), -0.5, -0.2);
    assert_red(&cdl("style=\"Fwd\""), -0.2, 0.0);
}

#[test]
fn one_dimensional_tables_are_linear_between_entries() {
    let inverse = "<Array dim=\"4 1\">\n3\n2\n1\n0\n</Array>";
    let lut = format!("<LUT1D inBitDepth=\"12i\" outBitDepth=\"12i\">{inverse}</LUT1D>");
    assert_maps(&lut, [0.0, 1.0 / 6.0, 1.0], [3.0 / 4095.0, 2.5 / 4095.0, 0.0]);
    assert_maps(&lut, [-1.0, 2.0, 0.5], [3.0 / 4095.0, 0.0, 1.5 / 4095.0]);
    let three =
        node("LUT1D", "interpolation=\"linear\"", "<Array dim=\"2 3\">0 1 -2 1 0.5 2 <!-- two rows --></Array>");
    assert_maps(&three, [0.25, 0.25, 0.25], [0.25, 0.875, -1.0]);
}

#[test]
fn a_half_domain_has_an_entry_for_each_half_float() {
    // The negative of each half float, as raw codes, and the sum of both neighbors between two halves.
    let codes: Vec<String> = (0..65536_u32)
        .map(|code| if code & 0x7c00 == 0x7c00 { "0".into() } else { (code ^ 0x8000).to_string() })
        .collect();
    let table = format!("<Array dim=\"65536 1\">{}</Array>", codes.join(" "));
    let negative = node("LUT1D", "halfDomain=\"true\" rawHalfs=\"true\"", &table);
    assert_maps(&negative, [0.1, -1234.5, 1e-7], [-0.1, 1234.5, -1e-7]);
    assert_maps(&negative, [65504.0, 1e6, -1e6], [-65504.0, -65504.0, 65504.0]);
    // The square of each half: the middle between 1 and 1.0009765625 is the mean of their squares.
    let squares: Vec<String> = (0..65536_u32).map(|code| format!("{:e}", (half(code).powi(2)).min(1e4))).collect();
    let table = format!("<Array dim=\"65536 1\">{}</Array>", squares.join(" "));
    let square = node("LUT1D", "halfDomain=\"true\"", &table);
    assert_maps(&square, [1.0, -0.5, 1.00048828125], [1.0, 0.25, (1.0 + 1.0009765625_f64.powi(2)) / 2.0]);
}

/// A half float by its definition; 0 for those that are not finite.
fn half(code: u32) -> f64 {
    let (exponent, mantissa) = ((code >> 10 & 31) as i32, f64::from(code & 1023) / 1024.0);
    let sign = if code < 0x8000 { 1.0 } else { -1.0 };
    match exponent {
        0 => sign * mantissa * (-14.0_f64).exp2(),
        31 => 0.0,
        _ => sign * (1.0 + mantissa) * f64::from(exponent - 15).exp2(),
    }
}

#[test]
fn three_dimensional_tables_have_blue_fastest() {
    // The corners hold 4 * red + 2 * green + blue in red, and the product of all in green.
    let corners: Vec<String> = (0..8).map(|i| format!("{i} {} 0", i32::from(i == 7))).collect();
    let table = format!("<Array dim=\"2 2 2 3\">{}</Array>", corners.join("\n"));
    let trilinear = node("LUT3D", "", &table);
    assert_maps(&trilinear, [1.0, 0.0, 0.0], [4.0, 0.0, 0.0]);
    assert_maps(&trilinear, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
    assert_maps(&trilinear, [0.5, 0.25, 0.75], [3.25, 0.09375, 0.0]);
    // In a tetrahedron the last corner has the smallest of the three distances as its weight.
    let tetrahedral = node("LUT3D", "interpolation=\"tetrahedral\"", &table);
    assert_maps(&tetrahedral, [0.5, 0.25, 0.75], [3.25, 0.25, 0.0]);
    assert_maps(&tetrahedral, [2.0, -1.0, 1.0], [5.0, 0.0, 0.0]);
}

#[test]
fn nodes_apply_in_the_order_of_the_file() {
    let double = node("Matrix", "", "<Array dim=\"3 3\">2 0 0 0 2 0 0 0 2</Array>");
    let limit = node("Range", "", "<maxInValue>1</maxInValue><maxOutValue>1</maxOutValue>");
    assert_red(&format!("{double}{limit}"), 0.75, 1.0);
    assert_red(&format!("{limit}{double}"), 0.75, 1.5);
    assert_red(&format!("<Description>as a comment</Description>{limit}<Info><Copyright/></Info>{double}"), 3.0, 2.0);
}

#[test]
fn the_namespace_of_smpte_states_the_version() {
    let double = node("Matrix", "", "<Array dim=\"3 3\">2 0 0 0 2 0 0 0 2</Array>");
    let text = format!(
        "<ProcessList xmlns=\"http://www.smpte-ra.org/ns/2136-1/2024\"><Id>urn:uuid:1</Id>{double}</ProcessList>"
    );
    let named = text.replace("<ProcessList", "<ProcessList compCLFversion=\"ST2136-1:2024\"");
    for text in [text, named] {
        assert_eq!(parse_clf(&text).expect("a file of SMPTE").apply([1.0; 3]), [2.0; 3]);
    }
}

#[test]
fn the_kind_of_a_file_is_seen_in_its_content() {
    let kind = |bytes: &[u8]| parse_lut_file(bytes, PngLayout::Tiles);
    let clf = include_bytes!("files/display.clf");
    assert!(matches!(kind(clf), Ok(LutFile::Process(_))));
    assert!(matches!(kind(&[b"\xef\xbb\xbf", &clf[..]].concat()), Ok(LutFile::Process(_))));
    assert!(matches!(kind(b"LUT_1D_SIZE 2\n0 0 0\n1 1 1"), Ok(LutFile::Table(_))));
    let correction = kind(include_bytes!("files/warm.cc")).expect_err("a correction").to_string();
    assert_eq!(correction, "line 2: the file is a color correction: use a node `Cdl`");
}

/// Wrong files: the process nodes, and the error.
fn malformed() -> Vec<(String, &'static str)> {
    let matrix = |dim: &str, body: &str| node("Matrix", "", &format!("\n<Array dim=\"{dim}\">{body}</Array>"));
    let unit = matrix("3 3", "1 0 0 0 1 0 0 0 1");
    vec![
        (String::new(), "line 1: there is no process node: there are"),
        ("<Gamma inBitDepth=\"32f\" outBitDepth=\"32f\"/>".into(), "line 2: `Gamma` is no process node"),
        ("<Matrix inBitDepth=\"32f\"/>".into(), "line 2: `Matrix` has no attribute `outBitDepth`"),
        ("<Matrix inBitDepth=\"32f\" outBitDepth=\"9i\"/>".into(), "line 2: `outBitDepth` is `8i`, `10i`"),
        (node("Matrix", "", ""), "line 2: `Matrix` has no `Array`"),
        (matrix("2 2", "1 0 0 1"), "line 3: `dim` of a matrix is `3 3` or `3 4`, not `2 2`"),
        (matrix("3 3", "1 0 0\n0 1"), "line 3: `Array` has 9 numbers, not 5"),
        (matrix("3 3", "1 0 0\n0 1 0\n0 0 1 0"), "line 5: there are more than the 9 numbers of `Array`"),
        (matrix("3 3", "1 0 0\n0 one 0\n0 0 1"), "line 4: `one` is not a number"),
        (matrix("3 3", "1 0 0\n0 nan 0\n0 0 1"), "line 4: `nan` is not finite"),
        (matrix("3 3", "1 0 0\n0 1e300 0\n0 0 1"), "line 4: `1e300` is larger than 1e9"),
        (
            format!("{unit}\n{}", unit.replace("inBitDepth=\"32f\"", "inBitDepth=\"10i\"")),
            "line 4: `inBitDepth` is `10i`, but the node before has `32f`",
        ),
        (node("Matrix", "style=\"x\"", ""), "line 2: `Matrix` has no attribute `style`"),
        (node("Range", "", ""), "line 2: `Range` has neither a minimum nor a maximum"),
        (node("Range", "", "<minInValue>1</minInValue>"), "line 2: `minInValue` and `minOutValue` need each other"),
        (node("Log", "style=\"ln\"", ""), "line 2: `ln` is no style of `Log`"),
        (node("Log", "style=\"linToLog\"", ""), "line 2: `Log` has no `LogParams`"),
        (node("Log", "style=\"linToLog\"", "<LogParams base=\"1\"/>"), "line 2: `base` is above 0 and not 1"),
        (node("Log", "style=\"cameraLinToLog\"", "<LogParams/>"), "line 2: the style needs `linSideBreak`"),
        (
            node("Exponent", "style=\"monCurveFwd\"", "<ExponentParams exponent=\"2\"/>"),
            "line 2: `ExponentParams` has no attribute `offset`",
        ),
        (
            node("Exponent", "style=\"basicFwd\"", "<ExponentParams exponent=\"-1\"/>"),
            "line 2: `exponent` is 0.01 to 100",
        ),
        (
            node("Exponent", "style=\"basicFwd\"", "<ExponentParams exponent=\"2\"/><ExponentParams exponent=\"2\"/>"),
            "line 2: a channel has several `ExponentParams`",
        ),
        (
            node("ASC_CDL", "style=\"Rev\"", "<SatNode><Saturation>0</Saturation></SatNode>"),
            "line 2: a slope or a saturation of 0 has no reverse",
        ),
        (node("LUT1D", "", "<IndexMap dim=\"2\"/>"), "line 2: version 3 has no `IndexMap`"),
        (
            node("LUT1D", "", "<Array dim=\"70000 1\"/>"),
            "line 2: `dim` of a 1-D table is `N 1` or `N 3`, with N from 2 to 65536, not `70000 1`",
        ),
        (node("LUT1D", "", "<Array dim=\"2 1\">0 70000</Array>"), "line 2: the entry 7e4 is beyond 65504"),
        (
            node("LUT1D", "halfDomain=\"true\"", "<Array dim=\"2 1\">0 1</Array>"),
            "line 2: a table with `halfDomain` has 65536 entries, not 2",
        ),
        (
            node("LUT3D", "", "<Array dim=\"2 2 3 3\"/>"),
            "line 2: `dim` of a 3-D table is `N N N 3`, with N from 2 to 256, not `2 2 3 3`",
        ),
        (
            node("LUT3D", "", "<Array dim=\"256 256 256 3\">0 0 0</Array>"),
            "line 2: `Array` has 50331648 numbers, not 3",
        ),
    ]
}

#[test]
fn a_malformed_file_is_reported_with_its_line() {
    for (nodes, expected) in malformed() {
        let error = parse_clf(&list(&nodes)).expect_err(&nodes).to_string();
        assert!(error.starts_with(expected), "{nodes}\n{error}");
    }
    let version = "<ProcessList id=\"a\" compCLFversion=\"4\"/>";
    assert_eq!(
        parse_clf(version).expect_err(version).to_string(),
        "line 1: the version is 2.0, 3.0 or ST2136-1:2024, not `4`"
    );
    let other = parse_clf("<svg/>").expect_err("no list").to_string();
    assert_eq!(other, "line 1: the file is no `ProcessList`, but a `svg`");
}

#[test]
fn hostile_files_are_refused_at_once() {
    let message = |text: &str| parse_clf(text).expect_err("a hostile file").to_string();
    let unit = node("Matrix", "", "<Array dim=\"3 3\">1 0 0 0 1 0 0 0 1</Array>");
    assert_eq!(message(&list(&unit.repeat(65))), "line 2: there are more than 64 process nodes");
    assert_eq!(message(&list(&"<Range/>".repeat(1_000_000))), "the file has more than 250000 elements");
    assert_eq!(message(&list(&unit.repeat(100_000))), "the file has more than 5000 attributes");
    let deep = format!("{}{}", "<a>".repeat(200_000), "</a>".repeat(200_000));
    assert_eq!(message(&deep), "line 1: the file is no `ProcessList`, but a `a`");
    let bomb = "<!DOCTYPE a [<!ENTITY b \"bbbbbbbbbb\"><!ENTITY c \"&b;&b;&b;\">]>\n<a>&c;</a>";
    assert_eq!(message(bomb), "line 1: a document type definition is not accepted");
    let whole = include_str!("files/display.clf");
    for length in (0..whole.len() - 1).step_by(7) {
        parse_clf(&whole[..length]).expect_err("a truncated file");
    }
    assert!(message(&whole[..400]).starts_with("line "), "{}", message(&whole[..400]));
}

#[test]
fn results_stay_finite() {
    let steep = "<LogParams base=\"10\" logSideSlope=\"0.001\" linSideSlope=\"0.000001\"/>";
    let nodes = [
        node("Log", "style=\"logToLin\"", steep),
        node("Exponent", "style=\"basicFwd\"", "<ExponentParams exponent=\"100\"/>"),
        node("Matrix", "", "<Array dim=\"3 3\">1e9 1e9 1e9 1e9 -1e9 1e9 0 0 -1e9</Array>"),
    ];
    let process = process(&nodes.concat());
    for x in [0.0, 1.0, -1.0, 65504.0, -65504.0, 1e-30] {
        let result = process.apply([x, 0.5, -x]);
        assert!(result.iter().all(|value| value.abs() <= 1e12), "{x}: {result:?}");
    }
}
