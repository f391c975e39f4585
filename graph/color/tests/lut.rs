//! The readers of `.cube` files and of pictures that hold tables.

use afterimage_color::lut::{Lut, PngLayout, parse_cube, parse_png};

fn encoded(pixels: &[u8], [width, height]: [u32; 2], color: png::ColorType) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(pixels)).expect("a picture in memory");
    bytes
}

/// The identity of 64 entries a side as a picture.
fn identity(layout: PngLayout) -> Vec<u8> {
    let mut pixels = vec![0_u8; 512 * 512 * 3];
    for index in 0..64 * 64 * 64 {
        let (r, g, b) = (index % 64, index / 64 % 64, index / 4096);
        let pixel = match layout {
            PngLayout::Tiles => (b / 8 * 64 + g) * 512 + b % 8 * 64 + r,
            PngLayout::TilesUp => (b / 8 * 64 + 63 - g) * 512 + b % 8 * 64 + r,
            PngLayout::Hald => index,
        };
        let codes = [r, g, b].map(|level| (level as f64 / 63.0 * 255.0).round() as u8);
        pixels[3 * pixel..3 * pixel + 3].copy_from_slice(&codes);
    }
    encoded(&pixels, [512; 2], png::ColorType::Rgb)
}

/// The identity as the text of a `.cube` file.
fn identity_text(side: usize) -> String {
    let level = |index: usize| index as f64 / (side - 1) as f64;
    let place = |index: usize| [index % side, index / side % side, index / (side * side)].map(level);
    let lines = (0..side.pow(3)).map(place).map(|[r, g, b]| format!("{r:.9} {g:.9} {b:.9}\n"));
    format!("LUT_3D_SIZE {side}\n{}", lines.collect::<String>())
}

#[test]
fn a_table_that_changes_nothing_is_an_identity() {
    for side in [2, 33] {
        assert!(parse_cube(&identity_text(side)).expect("a table").is_identity(), "{side}");
    }
    let nearly = identity_text(3).replacen("0.500000000", "0.500010000", 1);
    assert!(!parse_cube(&nearly).expect("a table").is_identity());
    for layout in [PngLayout::Tiles, PngLayout::TilesUp, PngLayout::Hald] {
        let table = parse_png(&identity(layout), layout).expect("a table");
        assert!(table.is_identity(), "{}", layout.name());
        assert_eq!(table.ends().cube, Lut::identity().cube);
    }
    let curve = parse_cube("LUT_1D_SIZE 3\nLUT_1D_INPUT_RANGE -1 3\n-1 -1 -1\n1 1 1\n3 3 3\n").expect("a table");
    let ends = curve.ends().curve.expect("a curve");
    assert!(curve.is_identity() && (ends.size, &ends.entries[..]) == (2, &[[-1.0; 3], [3.0; 3]][..]));
}

#[test]
fn a_malformed_table_is_reported_with_its_line() {
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
fn a_picture_that_holds_no_table_is_reported() {
    let message = |bytes: &[u8]| parse_png(bytes, PngLayout::Tiles).expect_err("an error").to_string();
    // No table; as many pixels as one of 4 entries a side, but no tiles; tiles that are not as many as they are wide.
    for size in [[100, 100], [2, 32], [256, 32], [15 * 16, 16]] {
        let sides = message(&encoded(&vec![0; 3 * (size[0] * size[1]) as usize], size, png::ColorType::Rgb));
        assert!(sides.contains(&format!("not {}x{}", size[0], size[1])), "{sides}");
    }
    let strip = parse_png(&encoded(&[0; 3 * 4096], [256, 16], png::ColorType::Rgb), PngLayout::Hald);
    assert!(strip.expect_err("an error").message.starts_with("a HALD table is a square of 8, 27, 64"));
    let gray = message(&encoded(&[0; 64 * 64], [64; 2], png::ColorType::Grayscale));
    assert!(gray.contains("has no colors"), "{gray}");
    let whole = identity(PngLayout::Tiles);
    let cut = message(&whole[..whole.len() / 2]);
    assert!(cut.starts_with("the PNG cannot be read"), "{cut}");
    let flipped = message(b"\x89PNG\r\n\x1a\n and no more");
    assert!(flipped.starts_with("the PNG cannot be read"), "{flipped}");
}

/// The judge is what the programs document: in a tile red rises to the right, and blue from tile to tile.
#[test]
fn strips_and_other_rows_of_tiles_are_tables() {
    // Unreal, Unity, a strip from top to bottom, two rows, one tile in each corner.
    for (side, across) in [(16, 16), (32, 32), (64, 64), (16, 1), (32, 8), (4, 2), (2, 2), (2, 1)] {
        for layout in [PngLayout::Tiles, PngLayout::TilesUp] {
            let [width, height] = [side * across, side * side / across];
            let mut pixels = Vec::new();
            for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
                let green = if layout == PngLayout::Tiles { y % side } else { side - 1 - y % side };
                pixels.extend([x % side, green, y / side * across + x / side].map(|level| (200 / side * level) as u8));
            }
            let bytes = encoded(&pixels, [width as u32, height as u32], png::ColorType::Rgb);
            let found = parse_png(&bytes, layout).unwrap_or_else(|error| panic!("{width}x{height}: {error}"));
            let code = |level: usize| (200 / side * level) as f32 / 255.0;
            let wanted = Lut::of(side, |steps| steps.map(code));
            assert_eq!(found.cube, wanted.cube, "{width}x{height} {}", layout.name());
        }
    }
}

#[test]
fn old_line_ends_and_byte_order_marks_are_read() {
    let plain: Lut = parse_cube("LUT_1D_SIZE 2\n0 0 0\n1 1 0.5\n").expect("a table");
    for text in [
        "\u{feff}LUT_1D_SIZE 2\r\n0 0 0\r\n1 1 0.5",
        "LUT_1D_SIZE 2\r0 0 0\r1 1 0.5\r",
        "LUT_1D_SIZE\t2 # two\n 0\t0 0\n+1 1e0 5e-1",
    ] {
        assert_eq!(parse_cube(text).expect(text), plain, "{text:?}");
    }
}
