//! Synthetic pictures whose errors are larger than those of photographs: they stress meters and downsampling.

use afterimage_gpu::Texels;

/// A synthetic picture.
struct Chart {
    name: &'static str,
    /// The color at a position, scene-linear; 0.18 is middle gray.
    color: fn(u32, u32) -> [f32; 3],
}

/// Width and height: neither is a multiple of the halvings. Glow has one level less than in a frame of 1080 lines.
const WIDTH: u32 = 963;
const HEIGHT: u32 = 541;
/// The brightest half float.
const SUN: f32 = 65504.0;
/// Luminance of a landscape under stars, beside 0.18 for a gray card in a room.
const NIGHT: f32 = 1e-3;

const CHARTS: [Chart; 11] = [
    Chart { name: "lines", color: |x, y| gray(if (if y < HEIGHT / 2 { x } else { y }) % 5 == 0 { 8.0 } else { 0.05 }) },
    Chart { name: "dots", color: |x, y| gray(if x % 17 == 0 && y % 17 == 0 { 200.0 } else { 0.05 }) },
    Chart { name: "dots shifted", color: |x, y| gray(if x % 17 == 1 && y % 17 == 1 { 200.0 } else { 0.05 }) },
    Chart { name: "one sun", color: |x, y| gray(if (x, y) == (397, 253) { SUN } else { 0.18 }) },
    Chart { name: "suns in the night", color: |x, y| gray(if x % 64 == 9 && y % 64 == 9 { SUN } else { NIGHT }) },
    Chart { name: "lamps", color: lamps },
    Chart { name: "steps", color: steps },
    Chart { name: "colors", color: colors },
    Chart { name: "white", color: |_, _| gray(1.0) },
    Chart { name: "black", color: |_, _| gray(0.0) },
    Chart { name: "night", color: |x, y| gray(NIGHT * (1.0 + (x * y) as f32 / (WIDTH * HEIGHT) as f32)) },
];

/// Those that a search of tiers sees; the others confirm what it finds.
const SEARCHED: [&str; 4] = ["lines", "suns in the night", "lamps", "colors"];

const fn gray(value: f32) -> [f32; 3] {
    [value; 3]
}

/// A street at night: lamps of one to eight pixels, from dim to blinding. Those of more than a pixel are not removed as
/// fireflies, so errors in downsampled images show when they are enlarged.
fn lamps(x: u32, y: u32) -> [f32; 3] {
    const CELL: u32 = 120;
    let (column, row) = (x / CELL, y / CELL);
    // Each lamp lies elsewhere in its cell, so that its edges meet those of halved images in all ways.
    let (left, top) = (50 + (column * 5 + row * 3) % 13, 50 + (column * 7 + row * 11) % 13);
    let side = 1 + column;
    let is_lamp = (left..left + side).contains(&(x % CELL)) && (top..top + side).contains(&(y % CELL));
    if is_lamp { gray(2.0_f32.powi(2 * row as i32 + 1)) } else { gray(0.01) }
}

/// Twenty-two grays, a stop from one to the next, with hard edges.
fn steps(x: u32, _: u32) -> [f32; 3] {
    gray(2.0_f32.powi((x / 44) as i32 - 12))
}

/// Patches of the primaries and their mixes, from dim to ten times white.
fn colors(x: u32, y: u32) -> [f32; 3] {
    const PATCHES: [[f32; 3]; 6] =
        [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    let brightness = [0.02, 0.18, 1.0, 10.0][(y / 136) as usize % 4];
    PATCHES[(x / 161) as usize % PATCHES.len()].map(|channel| channel * brightness)
}

/// The names of all pictures.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    CHARTS.iter().map(|chart| chart.name)
}

/// True for the pictures that a search of tiers sees.
pub(crate) fn is_searched(name: &str) -> bool {
    SEARCHED.contains(&name)
}

/// The picture of that name, opaque.
///
/// # Panics
/// There is none.
pub(crate) fn picture(name: &str) -> Texels {
    let chart = CHARTS.iter().find(|chart| chart.name == name).expect("the name is one of `names`");
    let mut pixels = Vec::with_capacity((WIDTH * HEIGHT) as usize);
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            let [red, green, blue] = (chart.color)(x, y);
            pixels.push([red, green, blue, 1.0]);
        }
    }
    Texels::from_floats_as_half(WIDTH, HEIGHT, &pixels)
}
