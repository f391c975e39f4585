//! Look-up tables: one dimension, three dimensions, and the picture of 8×8 tiles (formula
//! book, 8).

use super::math::{Rgb, mix};

/// Linear interpolation in a table over [0, 1], clamped.
pub(crate) fn lookup(table: &[f64], x: f64) -> f64 {
    let (i, fraction) = cell(x, table.len());
    mix(table[i], table[i + 1], fraction)
}

/// The texture coordinate that makes a linear filter read entry `c · (n − 1)` of `n`.
pub(crate) fn coordinate(c: f64, n: usize) -> f64 {
    let n = n as f64;
    c * (n - 1.0) / n + 0.5 / n
}

/// The lower entry around a clamped x in [0, 1], and how far x lies toward the next.
fn cell(x: f64, n: usize) -> (usize, f64) {
    let p = x.clamp(0.0, 1.0) * (n - 1) as f64;
    let i = (p.floor() as usize).min(n - 2);
    (i, p - i as f64)
}

/// A table over the unit cube; red varies fastest.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cube {
    pub(crate) size: usize,
    pub(crate) entries: Vec<Rgb>,
}

impl Cube {
    /// The table of a function of color, `size` entries a side.
    pub(crate) fn new(size: usize, color: impl Fn(Rgb) -> Rgb) -> Cube {
        let level = |i: usize| (i % size) as f64 / (size - 1) as f64;
        let at = |i: usize| color([level(i), level(i / size), level(i / size / size)]);
        Cube { size, entries: (0..size.pow(3)).map(at).collect() }
    }

    fn entry(&self, [r, g, b]: [usize; 3]) -> Rgb {
        self.entries[r + self.size * (g + self.size * b)]
    }

    /// Interpolation between the eight entries around a color.
    pub(crate) fn trilinear(&self, rgb: Rgb) -> Rgb {
        let cells = rgb.map(|x| cell(x, self.size));
        let mut sum = [0.0; 3];
        for corner in 0..8 {
            let far = [0, 1, 2].map(|axis| (corner >> axis) & 1);
            let weight: f64 =
                (0..3).map(|axis| if far[axis] == 1 { cells[axis].1 } else { 1.0 - cells[axis].1 }).product();
            let entry = self.entry([0, 1, 2].map(|axis| cells[axis].0 + far[axis]));
            sum = [0, 1, 2].map(|channel| sum[channel] + weight * entry[channel]);
        }
        sum
    }

    /// Interpolation along the four corners of a tetrahedron, the largest fraction first.
    pub(crate) fn tetrahedral(&self, rgb: Rgb) -> Rgb {
        let cells = rgb.map(|x| cell(x, self.size));
        let mut axes = [0, 1, 2];
        axes.sort_by(|&a, &b| cells[b].1.total_cmp(&cells[a].1));
        let fractions = axes.map(|axis| cells[axis].1);
        let weights = [1.0 - fractions[0], fractions[0] - fractions[1], fractions[1] - fractions[2], fractions[2]];
        let mut corner = cells.map(|(i, _)| i);
        let mut sum = [0.0; 3];
        for (step, weight) in weights.into_iter().enumerate() {
            let entry = self.entry(corner);
            sum = [0, 1, 2].map(|channel| sum[channel] + weight * entry[channel]);
            if let Some(&axis) = axes.get(step) {
                corner[axis] += 1;
            }
        }
        sum
    }

    /// The table as the text of a `.cube` file.
    pub(crate) fn text(&self) -> String {
        let line = |[r, g, b]: &Rgb| format!("{r:.9} {g:.9} {b:.9}\n");
        let lines: String = self.entries.iter().map(line).collect();
        format!("LUT_3D_SIZE {}\n{lines}", self.size)
    }
}

/// The text of a `.cube` file that changes nothing.
pub(crate) fn identity_text(size: usize) -> String {
    Cube::new(size, |rgb| rgb).text()
}

/// Where a table drawn as 8×8 tiles of 64×64 pixels is read: two texture coordinates, and how far
/// blue lies from the first tile to the second.
pub(crate) fn tiled_coordinates(rgb: Rgb) -> ([f64; 2], [f64; 2], f64) {
    let [r, g, b] = rgb.map(|x| x.clamp(0.0, 1.0));
    let first = (63.0 * b).floor();
    let second = (first + 1.0).min(63.0);
    let place = |tile: f64| {
        let corner = [(tile % 8.0) * 64.0, (tile / 8.0).floor() * 64.0];
        [(corner[0] + 0.5 + 63.0 * r) / 512.0, (corner[1] + 0.5 + 63.0 * g) / 512.0]
    };
    (place(first), place(second), 63.0 * b - first)
}

/// The log2 shaper: [2^low, 2^high] to [0, 1].
pub(crate) fn shape_log2(x: f64, low: f64, high: f64) -> f64 {
    ((x.max(low.exp2()).log2() - low) / (high - low)).min(1.0)
}

#[test]
fn both_interpolations_reproduce_a_linear_table() {
    let linear = |[r, g, b]: Rgb| [0.2 * r + 0.5 * g, 0.9 * b - 0.1 * r, 0.3 + 0.7 * g];
    for size in [2, 5, 33] {
        let cube = Cube::new(size, linear);
        for rgb in [[0.1, 0.7, 0.33], [0.0, 1.0, 0.5], [0.42, 0.42, 0.42]] {
            for result in [cube.trilinear(rgb), cube.tetrahedral(rgb)] {
                let error = super::math::zip(result, linear(rgb), |a, b| (a - b).abs());
                assert!(super::math::largest(error) < 1e-14, "{size}: {result:?}");
            }
        }
    }
}

#[test]
fn the_identity_text_lists_red_fastest() {
    let text = identity_text(2);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 9);
    assert_eq!(lines[0], "LUT_3D_SIZE 2");
    assert_eq!(lines[2], "1.000000000 0.000000000 0.000000000");
    assert_eq!(lines[5], "0.000000000 0.000000000 1.000000000");
}

#[test]
fn the_shaper_spans_its_range() {
    assert_eq!(shape_log2(0.0, -8.0, 8.0), 0.0);
    assert_eq!(shape_log2(1.0, -8.0, 8.0), 0.5);
    assert_eq!(shape_log2(65504.0, -8.0, 8.0), 1.0);
}
