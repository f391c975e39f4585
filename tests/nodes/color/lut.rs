//! ColorLut.

use super::{OneFile, Tolerance, compare_with, light, tolerance, unit};
use crate::reference::lut::{Cube, lookup, shape_log2};
use crate::reference::math::{Rgb, mix};
use crate::reference::transfer::srgb_encode;
use afterimage_media::{Encoding, Samples, encode};
use afterimage_nodes::PngLayout;

/// The class `lut` of the test vectors.
pub(in crate::nodes) const LUT: Tolerance = tolerance(1e-5, 0.0, "interpolation in f32");
const FAST: Tolerance =
    tolerance(4e-3, 0.0, "half floats, and weights of 8 bits over cells whose ends differ by up to 0.5");

/// A strong look: channels bleed into each other, contrast, a hue.
pub(in crate::nodes) fn look([r, g, b]: Rgb) -> Rgb {
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
fn colors_outside_of_the_domain_end_at_its_border() {
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

/// The judge is the format: a color outside of the domain has the border's entry, and the border of a neutral table is
/// the end of its domain.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_neutral_table_limits_colors_as_one_that_is_nearly_neutral() {
    for (head, low, high) in [("", 0.0, 1.0), ("DOMAIN_MIN 0.25 0.25 0.25\nDOMAIN_MAX 2 2 2\n", 0.25, 2.0)] {
        let within = |share: f64| low + share * (high - low);
        let wanted = |rgb: Rgb| rgb.map(|x| x.clamp(low, high));
        let near = tolerance(3e-4, 0.0, "the table differs by as much from a neutral one");
        for (bend, tolerance) in [(0.0, LUT), (1e-4, near)] {
            let bent = |x: f64| within(x) + bend * x * (1.0 - x);
            let cube = Cube::new(17, |rgb| rgb.map(bent)).text().replacen('\n', &format!("\n{head}"), 1);
            let level = |i: u32| bent(f64::from(i) / 16.0);
            let lines: String = (0..17).map(|i| format!("{0:.9} {0:.9} {0:.9}\n", level(i))).collect();
            let curve = format!("LUT_1D_SIZE 17\n{head}{lines}");
            for text in [cube, curve] {
                for picture in [unit, light] {
                    let loader = OneFile(text.clone().into_bytes());
                    compare_with("Exposed", "ColorLut(file: \"look.cube\")", &loader, picture, tolerance, wanted);
                }
            }
        }
        // Codes of 8 bits are exact where they are those of a neutral table.
        let loader = OneFile(picture(PngLayout::Tiles, |rgb| rgb));
        compare_with("Exposed", "ColorLut(file: \"look.png\")", &loader, light, LUT, |rgb| {
            rgb.map(|x| x.clamp(0.0, 1.0))
        });
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn shapers_place_light_of_any_range() {
    let cube = Cube::new(9, look);
    let node = |shaper: &str| format!("ColorLut(file: \"look.cube\", shaper: {shaper}, high: 8.0)");
    let shaped = tolerance(3e-5, 0.0, "the logarithm of the shaper in f32, times the slope of the table");
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
    let mut pixels = vec![[0; 4]; 512 * 512];
    for (index, entry) in cube.entries.iter().enumerate() {
        let (r, g, b) = (index % 64, index / 64 % 64, index / 4096);
        let place = match layout {
            PngLayout::Tiles => (b / 8 * 64 + g) * 512 + b % 8 * 64 + r,
            PngLayout::TilesUp => (b / 8 * 64 + 63 - g) * 512 + b % 8 * 64 + r,
            PngLayout::Hald => index,
        };
        let [r, g, b] = entry.map(|x| (x * 255.0).round() as u8);
        pixels[place] = [r, g, b, 255];
    }
    let pixels = Samples::Byte(pixels.as_flattened());
    encode(((512, 512), pixels), &Encoding::PNG).expect("a picture in memory")
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn tables_drawn_as_pictures_match() {
    let cube = Cube::new(64, |rgb| look(rgb).map(|x| (x * 255.0).round() / 255.0));
    for layout in [PngLayout::Tiles, PngLayout::TilesUp, PngLayout::Hald] {
        let node = format!("ColorLut(file: \"look.png\", layout: {}, interpolation: Trilinear)", layout.name());
        compare_with("Encoded", &node, &OneFile(picture(layout, look)), unit, LUT, |rgb| cube.trilinear(rgb));
    }
}
