//! Film grain from a hash of the pixel's cell.

use super::color::luminance;
use super::math::{Rgb, mix, smooth_step};

/// The parameters that have no constant value in the tests.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grain {
    pub(crate) amount: f64,
    /// The diameter of a grain in pixels.
    pub(crate) size: f64,
    /// 0 for gray grain, 1 for grain of independent channels.
    pub(crate) color: f64,
    pub(crate) seed: u32,
}

/// The strength in shadows, in highlights, and the luminance of midtones: the kind's defaults.
const SHADOWS: f64 = 0.8;
const HIGHLIGHTS: f64 = 0.4;
const PIVOT: f64 = 0.5;

/// PCG output permutation over one LCG step (Jarzynski and Olano, "Hash Functions for GPU Rendering", 2020).
fn hash(v: u32) -> u32 {
    let state = v.wrapping_mul(747796405).wrapping_add(2891336453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277803737);
    (word >> 22) ^ word
}

/// Four independent sums over grains at random places, each a round shape with a random weight; scaled to the variance
/// 1/8. The same cells follow each other after `period` ones.
fn grains([x, y]: [f64; 2], period: Option<i64>, seed: u32) -> [f64; 4] {
    let mut sums = [0.0; 4];
    for (i, j) in (-1..=1).flat_map(|j| (-1..=1).map(move |i| (i, j))) {
        let cell = [x.floor() as i64 + i, y.floor() as i64 + j];
        let own = cell.map(|at| period.map_or(at, |period| at.rem_euclid(period)));
        let place = hash(own[0] as u32 ^ hash(own[1] as u32 ^ hash(seed)));
        let at = [f64::from(place & 0xffff), f64::from(place >> 16)].map(|part| part / 65536.0);
        let squared = (cell[0] as f64 + at[0] - x).powi(2) + (cell[1] as f64 + at[1] - y).powi(2);
        let shape = (1.0 - squared).max(0.0).powi(2);
        let weights = hash(place ^ 0x9e37_79b9).to_le_bytes().map(|byte| (f64::from(byte) + 0.5) / 128.0 - 1.0);
        sums = [0, 1, 2, 3].map(|k| sums[k] + weights[k] * shape);
    }
    let variance = std::f64::consts::PI / 5.0 / 3.0;
    sums.map(|sum| sum / (8.0 * variance).sqrt())
}

impl Grain {
    /// The color of a pixel with grain, for colors from 0 to 1.
    pub(crate) fn apply(&self, rgb: Rgb, pixel: [usize; 2]) -> Rgb {
        Self::added(rgb, self.strength(rgb), self.density(pixel))
    }

    /// The same with the grain of two periodic tiles, whose mixture turns once around in 360 rows from a tile of the
    /// first to the next.
    pub(crate) fn apply_tiles(&self, rgb: Rgb, pixel: [usize; 2], size: [u32; 2]) -> Rgb {
        let offset = [hash(self.seed), hash(self.seed ^ 0x9e37_79b9)];
        let sums = [(256, [0, 1].map(|k| offset[k] & 0xffff), 0), (239, [0, 1].map(|k| offset[k] >> 16), 1)].map(
            |(side, offset, seed)| {
                let cells = (side as f64 / self.size).round();
                let at = [0, 1].map(|k| ((pixel[k] + offset[k] as usize) % side) as f64 * cells / side as f64);
                grains(at, Some(cells as i64), seed)
            },
        );
        let [across, down] = [0, 1].map(|k| pixel[k] as f64 + 0.5 - 0.5 * f64::from(size[k]));
        let angle = std::f64::consts::TAU * (across * down / (360.0 * 256.0) - 0.5);
        let sum = [0, 1, 2, 3].map(|k| sums[0][k] * angle.cos() + sums[1][k] * angle.sin());
        Self::added(rgb, self.strength(rgb), self.mixed(sum))
    }

    fn strength(&self, rgb: Rgb) -> f64 {
        let y = luminance(rgb);
        let rising = mix(SHADOWS, 1.0, smooth_step(0.0, PIVOT, y));
        self.amount * mix(rising, HIGHLIGHTS, smooth_step(PIVOT, 1.0, y))
    }

    fn added(rgb: Rgb, strength: f64, density: Rgb) -> Rgb {
        [0, 1, 2].map(|channel| rgb[channel] + strength * density[channel] * rgb[channel] * (1.0 - rgb[channel]))
    }

    /// The random number of each channel of a pixel.
    fn density(&self, pixel: [usize; 2]) -> Rgb {
        self.mixed(grains(pixel.map(|side| side as f64 / self.size), None, self.seed))
    }

    fn mixed(&self, grains: [f64; 4]) -> Rgb {
        let (gray, tinted) = ((1.0 - self.color).sqrt(), self.color.sqrt());
        [0, 1, 2].map(|channel| (gray * grains[3] + tinted * grains[channel]).clamp(-1.0, 1.0))
    }
}

/// The mean product of pixels at this distance, over the mean square.
fn correlation(field: &[f64], side: usize, [dx, dy]: [i64; 2]) -> f64 {
    let wrap = |at: usize, by: i64| (at as i64 + by).rem_euclid(side as i64) as usize;
    let products = (0..side * side).map(|i| field[i] * field[wrap(i % side, dx) + side * wrap(i / side, dy)]);
    products.sum::<f64>() / field.iter().map(|x| x * x).sum::<f64>()
}

#[test]
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/color.md")]
fn the_variance_of_grain_depends_neither_on_color_nor_on_size() {
    for size in [1.0, 1.5, 3.0] {
        for color in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let grain = Grain { amount: 1.0, size, color, seed: 5 };
            let all: Vec<Rgb> = (0..500 * 500).map(|i| grain.density([i % 500, i / 500])).collect();
            let variance = all.iter().flatten().map(|x| x * x).sum::<f64>() / (3 * all.len()) as f64;
            println!("size {size}, color {color}: variance {variance:.4}");
            assert!((variance * 8.0 - 0.98).abs() < 0.04, "{size} {color}: {variance}");
        }
    }
}

#[test]
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/color.md")]
fn grain_has_no_direction_and_no_grid() {
    let (side, size) = (600, 6.0);
    let grain = Grain { amount: 1.0, size, color: 0.0, seed: 2 };
    let field: Vec<f64> = (0..side * side).map(|i| grain.density([i % side, i / side])[0]).collect();
    // Offsets of five pixels along the axes and between them.
    let along = correlation(&field, side, [5, 0]) + correlation(&field, side, [0, 5]);
    let across = correlation(&field, side, [3, 4]) + correlation(&field, side, [4, -3]);
    println!("correlation at 5 px: {:.4} along the axes, {:.4} between", along / 2.0, across / 2.0);
    assert!(along > 0.2 && (along - across).abs() < 0.04, "{along} {across}");
    // The variance at each place within a cell.
    let place = |i: usize| (i % side) % 6 + 6 * ((i / side) % 6);
    for at in 0..36 {
        let here = (0..field.len()).filter(|i| place(*i) == at).map(|i| field[i] * field[i]);
        let variance = here.sum::<f64>() * 36.0 / field.len() as f64;
        assert!((variance * 8.0 - 0.98).abs() < 0.12, "{at}: {variance}");
    }
}

#[test]
fn grain_never_leaves_the_range_from_black_to_white() {
    let grain = Grain { amount: 1.0, size: 1.5, color: 1.0, seed: 9 };
    for pixel in 0..2000 {
        let value = (pixel % 11) as f64 / 10.0;
        let found = grain.apply([value; 3], [pixel % 41, pixel / 41]);
        assert!(found.iter().all(|x| (0.0..=1.0).contains(x)), "{value} at {pixel}: {found:?}");
    }
}
