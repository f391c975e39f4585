//! ColorLut.

use super::{OneFile, Tolerance, compare_with, is_left_out, light, unit};
use crate::reference::color::luminance;
use crate::reference::lut::{Cube, identity_text, lookup, shape_log2};
use crate::reference::math::{Rgb, mix};
use crate::reference::transfer::srgb_encode;
use afterimage_nodes::{Lut, PngLayout, parse_cube, parse_png};

/// The class `lut` of the test vectors.
const LUT: Tolerance = Tolerance { absolute: 1e-5, relative: 0.0 };
/// Half floats, and weights of 8 bits over cells whose ends differ by up to a half.
const FAST: Tolerance = Tolerance { absolute: 4e-3, relative: 0.0 };

/// A strong look: channels bleed into each other, contrast, a hue.
fn look([r, g, b]: Rgb) -> Rgb {
    let s = |x: f64| x * x * (3.0 - 2.0 * x);
    [0.9 * s(r) + 0.1 * g * b, 0.05 + 0.8 * s(g) + 0.15 * r * (1.0 - b), (0.3 + 0.7 * b) * (1.0 - 0.4 * r * g)]
}

fn file(cube: &Cube) -> OneFile {
    OneFile(cube.text().into_bytes())
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn cubes_of_every_size_match_in_both_interpolations() {
    for size in [2, 3, 17, 32] {
        let cube = Cube::new(size, look);
        let loader = file(&cube);
        let node = |rest: &str| format!("ColorLut(file: \"look.cube\", {rest})");
        compare_with("Encoded", &node(""), &loader, unit, LUT, |rgb| cube.tetrahedral(rgb));
        compare_with("Encoded", &node("interpolation: Trilinear"), &loader, unit, LUT, |rgb| cube.trilinear(rgb));
        let half = node("interpolation: Trilinear, strength: 0.25");
        compare_with("Encoded", &half, &loader, unit, LUT, |rgb| {
            let looked = cube.trilinear(rgb);
            [0, 1, 2].map(|channel| mix(rgb[channel], looked[channel], 0.25))
        });
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_fast_way_stays_close() {
    let cube = Cube::new(17, look);
    let node = "ColorLut(file: \"look.cube\", precision: Fast, interpolation: Trilinear)";
    compare_with("Encoded", node, &file(&cube), unit, FAST, |rgb| cube.trilinear(rgb));
    let node = "ColorLut(file: \"look.cube\", precision: Fast)";
    compare_with("Encoded", node, &file(&cube), unit, FAST, |rgb| cube.tetrahedral(rgb));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn colours_outside_of_the_domain_end_at_its_border() {
    let cube = Cube::new(5, look);
    let text = cube.text().replacen('\n', "\nDOMAIN_MIN 0.1 0 -1\nDOMAIN_MAX 0.9 2 1\n", 1);
    let place = |[r, g, b]: Rgb| [(r - 0.1) / 0.8, g / 2.0, (b + 1.0) / 2.0];
    let loader = OneFile(text.into_bytes());
    for picture in [unit, light] {
        compare_with("Exposed", "ColorLut(file: \"look.cube\")", &loader, picture, LUT, |rgb| {
            cube.tetrahedral(place(rgb))
        });
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn shapers_place_light_of_any_range() {
    let cube = Cube::new(9, look);
    let node = |shaper: &str| format!("ColorLut(file: \"look.cube\", shaper: {shaper}, high: 8.0)");
    let shaped = Tolerance { absolute: 3e-5, relative: 0.0 };
    compare_with("Exposed", &node("Log2, low: -8.0"), &file(&cube), light, shaped, |rgb| {
        cube.tetrahedral(rgb.map(|x| shape_log2(x, -8.0, 8.0)))
    });
    compare_with("Exposed", &node("Srgb"), &file(&cube), light, shaped, |rgb| {
        cube.tetrahedral(rgb.map(|x| srgb_encode(x.min(1.0))))
    });
    compare_with("Exposed", &node("LogC"), &file(&cube), light, shaped, |rgb| {
        cube.tetrahedral(rgb.map(|x| log_c(x, 256.0)))
    });
}

/// The camera's logarithm with its published foot, scaled to 0 at black and 1 at `high`.
fn log_c(x: f64, high: f64) -> f64 {
    let raw = |x: f64| {
        if x > 0.011361 { 0.244161 * (5.555556 * x + 0.047996).log10() + 0.386036 } else { 5.301883 * x + 0.092814 }
    };
    (raw(x) - raw(0.0)) / (raw(high) - raw(0.0))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn one_dimensional_tables_match_alone_and_before_a_cube() {
    let entries = 5000;
    let level = |i: usize| i as f64 / (entries - 1) as f64;
    let table = |power: f64| (0..entries).map(|i| level(i).powf(power)).collect::<Vec<_>>();
    let [red, green, blue] = [table(0.5), table(1.0), table(2.0)];
    let lines: String = (0..entries).map(|i| format!("{:.9} {:.9} {:.9}\n", red[i], green[i], blue[i])).collect();
    let curve = |[r, g, b]: Rgb| [lookup(&red, r), lookup(&green, g), lookup(&blue, b)];
    let text = format!("# a comment\nTITLE \"three # curves\"\nLUT_1D_SIZE {entries}\n{lines}");
    compare_with("Encoded", "ColorLut(file: \"a.cube\")", &OneFile(text.into_bytes()), unit, LUT, curve);

    let cube = Cube::new(7, look);
    let text = format!(
        "LUT_1D_SIZE {entries}\nLUT_1D_INPUT_RANGE 0 4\nLUT_3D_SIZE 7\n{lines}{}",
        cube.text().split_once('\n').expect("two lines").1
    );
    let loader = OneFile(text.into_bytes());
    for interpolation in ["Tetrahedral", "Trilinear"] {
        let node = format!("ColorLut(file: \"a.cube\", interpolation: {interpolation})");
        compare_with("Exposed", &node, &loader, unit, LUT, |rgb| {
            let placed = curve(rgb.map(|x| x / 4.0));
            if interpolation == "Trilinear" { cube.trilinear(placed) } else { cube.tetrahedral(placed) }
        });
    }
}

/// A table of 64 as a picture of 8 by 8 tiles, or as HALD.
fn picture(layout: PngLayout, color: impl Fn(Rgb) -> Rgb) -> Vec<u8> {
    let cube = Cube::new(64, color);
    let mut pixels = vec![0_u8; 512 * 512 * 3];
    for (index, entry) in cube.entries.iter().enumerate() {
        let (r, g, b) = (index % 64, index / 64 % 64, index / 4096);
        let place = match layout {
            PngLayout::Tiles => (b / 8 * 64 + g) * 512 + b % 8 * 64 + r,
            PngLayout::Hald => index,
        };
        let codes = entry.map(|x| (x * 255.0).round() as u8);
        pixels[3 * place..3 * place + 3].copy_from_slice(&codes);
    }
    encoded(&pixels, 512, png::ColorType::Rgb)
}

fn encoded(pixels: &[u8], side: u32, color: png::ColorType) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side, side);
    encoder.set_color(color);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(pixels)).expect("a picture in memory");
    bytes
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn tables_drawn_as_pictures_match() {
    let cube = Cube::new(64, |rgb| look(rgb).map(|x| (x * 255.0).round() / 255.0));
    for layout in [PngLayout::Tiles, PngLayout::Hald] {
        let node = format!("ColorLut(file: \"look.png\", layout: {}, interpolation: Trilinear)", layout.name());
        compare_with("Encoded", &node, &OneFile(picture(layout, look)), unit, LUT, |rgb| cube.trilinear(rgb));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn tables_that_change_nothing_are_left_out() {
    let files = [
        ("cube", identity_text(2).into_bytes()),
        ("cube", identity_text(33).into_bytes()),
        ("cube", b"LUT_1D_SIZE 2\nDOMAIN_MIN -1 -1 -1\n-1 -1 -1\n1 1 1\n".to_vec()),
        ("png", picture(PngLayout::Tiles, |rgb| rgb)),
    ];
    for (kind, bytes) in files {
        assert!(is_left_out("Encoded", &format!("ColorLut(file: \"a.{kind}\")"), &OneFile(bytes)));
    }
    let nearly = identity_text(3).replacen("0.500000000", "0.500010000", 1);
    assert!(!is_left_out("Encoded", "ColorLut(file: \"a.cube\")", &OneFile(nearly.into_bytes())));
    // With a shaper, the same table has a meaning: it shows the shaper.
    let shaped = "ColorLut(file: \"a.cube\", shaper: Log2)";
    assert!(!is_left_out("Encoded", shaped, &OneFile(identity_text(2).into_bytes())));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn broken_tables_are_told_with_their_line() {
    let two = "0 0 0\n1 1 1\n";
    let table = [
        (String::new(), "line 1: neither `LUT_3D_SIZE` nor `LUT_1D_SIZE` is there"),
        ("0 0 0\n".into(), "line 1: an entry comes before `LUT_3D_SIZE` or `LUT_1D_SIZE`"),
        ("\nLUT_3D_SIZE 1\n".into(), "line 2: the size must be a whole number from 2 to 256, not `1`"),
        ("LUT_3D_SIZE 257\n".into(), "line 1: the size must be a whole number from 2 to 256, not `257`"),
        ("LUT_1D_SIZE many\n".into(), "line 1: the size must be a whole number from 2 to 65536, not `many`"),
        ("LUT_1D_SIZE 2\nLUT_1D_SIZE 2\n".into(), "line 2: `LUT_1D_SIZE` is there twice"),
        (format!("LUT_1D_SIZE 3\n{two}"), "line 3: the file ends after 2 of 3 entries"),
        (format!("LUT_1D_SIZE 2\n# fine\n{two}\n0 0 0\n"), "line 6: there are more than the 2 entries of the table"),
        ("LUT_1D_SIZE 2\n0 0\n".into(), "line 2: an entry has 3 numbers, not 2"),
        ("LUT_1D_SIZE 2\n0 0 0 0\n".into(), "line 2: an entry has 3 numbers, not 4"),
        ("LUT_1D_SIZE 2\r\n0 0 zero\r\n".into(), "line 2: `zero` is not a number"),
        ("LUT_1D_SIZE 2\n0 nan 0\n".into(), "line 2: `nan` is not finite"),
        ("LUT_1D_SIZE 2\nnan 0 0\n".into(), "line 2: `nan` is not finite"),
        ("LUT_1D_SIZE 2\ninf 0 0\n".into(), "line 2: `inf` is not finite"),
        (
            format!("LUT_1D_SIZE 2\nDOMAIN_MIN 0 1 0\n{two}"),
            "line 2: the domain must end above its beginning in every channel",
        ),
        ("DOMAIN_MAX 1 1\n".into(), "line 1: DOMAIN_MAX has 3 numbers, not 2"),
        (
            format!("LUT_1D_SIZE 2\n{two}TITLE \"late\"\n"),
            "line 4: `TITLE` comes after the first entry: keywords go before",
        ),
    ];
    for (text, expected) in table {
        assert_eq!(parse_cube(&text).expect_err(&text).to_string(), expected, "{text:?}");
    }
    let unknown = parse_cube("LUT_4D_SIZE 2\n").expect_err("an unknown keyword");
    assert!(unknown.message.starts_with("`LUT_4D_SIZE` is no keyword of a .cube file; there are `TITLE`"), "{unknown}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn broken_pictures_are_told() {
    let complaint = |bytes: &[u8]| parse_png(bytes, PngLayout::Tiles).expect_err("a mistake").to_string();
    let sides = complaint(&encoded(&[0; 100 * 100 * 3], 100, png::ColorType::Rgb));
    assert!(sides.contains("not 100x100"), "{sides}");
    let grey = complaint(&encoded(&[0; 64 * 64], 64, png::ColorType::Grayscale));
    assert!(grey.contains("has no colours"), "{grey}");
    let whole = picture(PngLayout::Tiles, look);
    let cut = complaint(&whole[..whole.len() / 2]);
    assert!(cut.starts_with("the PNG cannot be read"), "{cut}");
    let flipped = complaint(b"\x89PNG\r\n\x1a\n and no more");
    assert!(flipped.starts_with("the PNG cannot be read"), "{flipped}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pipeline_with_a_broken_table_names_the_file_and_its_line() {
    use afterimage_graph::check::{CheckOptions, check};
    let text = super::pipeline("Encoded", "ColorLut(file: \"broken.cube\")");
    let document = afterimage_graph::document::parse("test.ron", &text).expect("a document");
    let loader = OneFile(b"LUT_3D_SIZE 2\n0 0 0\nx\n".to_vec());
    let options = CheckOptions { loader: &loader, ..CheckOptions::default() };
    let problems = check(&document, &crate::support::gpu::registry(), &options).expect_err("a broken table");
    let told = format!("{problems:?}");
    assert!(told.contains("`broken.cube`: line 3: `x` is not a number"), "{told}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn old_line_ends_and_marks_are_read() {
    let plain: Lut = parse_cube("LUT_1D_SIZE 2\n0 0 0\n1 1 0.5\n").expect("a table");
    for text in [
        "\u{feff}LUT_1D_SIZE 2\r\n0 0 0\r\n1 1 0.5",
        "LUT_1D_SIZE 2\r0 0 0\r1 1 0.5\r",
        "LUT_1D_SIZE\t2 # two\n 0\t0 0\n+1 1e0 5e-1",
    ] {
        assert_eq!(parse_cube(text).expect(text), plain, "{text:?}");
    }
}

/// The look that is shipped, by the formula that made it: cool shadows, warm lights, soft contrast, less saturation.
fn dusk(rgb: Rgb) -> Rgb {
    let y = luminance(rgb);
    let (cool, warm) = (4.0 * y * (1.0 - y) * (1.0 - y), 4.0 * y * y * (1.0 - y));
    let (shadows, lights) = ([-0.03, 0.008, 0.035], [0.04, 0.012, -0.045]);
    [0, 1, 2].map(|channel| {
        let held: f64 = (y + 0.9 * (rgb[channel] - y)).clamp(0.0, 1.0);
        let curved = held + 0.25 * (held * held * (3.0 - 2.0 * held) - held);
        (curved + cool * shadows[channel] + warm * lights[channel]).clamp(0.0, 1.0)
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_shipped_look_is_its_formula() {
    let text = include_str!("../../../pipelines/looks/dusk.cube");
    let table = parse_cube(text).expect("a good table").cube.expect("a cube");
    let expected = Cube::new(9, dusk);
    assert_eq!(table.entries.len(), expected.entries.len());
    for (found, expected) in table.entries.iter().zip(&expected.entries) {
        assert!(
            (0..3).all(|channel| (f64::from(found[channel]) - expected[channel]).abs() < 6e-5),
            "{found:?}, {expected:?}"
        );
    }
    assert_eq!((table.entries[0], table.entries[728]), ([0.0; 3], [1.0; 3]));
}
