//! Local tone mapping by a bilateral grid and a wide Gaussian (formula book, 5).
//!
//! The grid is that of Chen, Paris and Durand (2007).

use super::color::level_luminance;
use super::gaussian;
use super::image::{Image, center_uv, rgb};
use super::math::{Rgb, mix, smooth_step};
use super::resample::area_average;
use super::sanitize::MAX_HALF;

/// A range of log2 luminance, in stops.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Range {
    pub(crate) fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }

    /// The log2 luminance of a color, clamped to the range; black is the low end.
    pub(crate) fn log_luminance(&self, rgb: Rgb) -> f64 {
        level_luminance(rgb).log2().clamp(self.low, self.high)
    }
}

/// The multiplier for a pixel of log2 luminance `l` over its `base`: contrast scales the base
/// about `middle`, detail what is above it; limited to ±16 stops.
pub(crate) fn scale(l: f64, base: f64, middle: f64, contrast: f64, detail: f64) -> f64 {
    let result = middle + contrast * (base - middle) + detail * (l - base);
    (result - l).clamp(-16.0, 16.0).exp2()
}

/// The splatting of a pixel into the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Splat {
    /// Into the eight cells around it.
    Trilinear,
    /// Into the one it lies in.
    Nearest,
}

/// Cells over x, y and log2 luminance, each a weighted sum of `l − middle` and the weight.
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    pub(crate) size: [usize; 3],
    pub(crate) range: Range,
    pub(crate) cells: Vec<[f64; 2]>,
    /// The largest weight of a cell.
    pub(crate) peak: f64,
    /// The weight of a cell that all pixels around it fall into.
    full: f64,
}

/// Shares of a full cell: below the first a grid knows nothing, from the second on all that it can.
const EMPTY: f64 = 0.0025 / 512.0;
const KNOWN: f64 = 0.01 / 512.0;

impl Grid {
    fn new(size: [usize; 3], range: Range, cells: Vec<[f64; 2]>, full: f64) -> Grid {
        let peak = cells.iter().map(|cell| cell[1]).fold(0.0, f64::max);
        Grid { size, range, cells, peak, full }
    }

    /// The grid of an image's luminance.
    pub(crate) fn build(image: &Image, size: [usize; 3], range: Range, splat: Splat) -> Grid {
        let mut cells = vec![[0.0; 2]; size.iter().product()];
        for (i, &pixel) in image.pixels.iter().enumerate() {
            let l = range.log_luminance(rgb(pixel));
            let uv = center_uv(i % image.width, i / image.width, image.width, image.height);
            let at = grid_coordinate(uv, l, size, range);
            let shares = match splat {
                Splat::Trilinear => trilinear(at, size),
                Splat::Nearest => vec![(nearest(at, size), 1.0)],
            };
            for (cell, weight) in shares {
                let [sum, total] = &mut cells[index(cell, size)];
                *sum += weight * (l - range.middle());
                *total += weight;
            }
        }
        let full = image.width.div_ceil(size[0]) * image.height.div_ceil(size[1]);
        Grid::new(size, range, cells, full as f64)
    }

    /// Blurs along x, y and luminance with normalized Gaussians; outside the grid lies nothing.
    pub(crate) fn blurred(&self, sigmas: [f64; 3], radii: [usize; 3]) -> Grid {
        (0..3).fold(self.clone(), |grid, axis| grid.blurred_along(axis, &gaussian::taps(sigmas[axis], radii[axis])))
    }

    fn blurred_along(&self, axis: usize, half: &[f64]) -> Grid {
        let mut cells = vec![[0.0; 2]; self.cells.len()];
        let last = half.len() as i64 - 1;
        for (i, result) in cells.iter_mut().enumerate() {
            let cell = position(i, self.size);
            for offset in -last..=last {
                let moved = cell[axis] as i64 + offset;
                if (0..self.size[axis] as i64).contains(&moved) {
                    let mut from = cell;
                    from[axis] = moved as usize;
                    let weight = half[offset.unsigned_abs() as usize];
                    let value = self.cells[index(from, self.size)];
                    *result = [0, 1].map(|k| result[k] + weight * value[k]);
                }
            }
        }
        Grid::new(self.size, self.range, cells, self.full)
    }

    /// Limits the change of the means along luminance, in stops per stop: each becomes the middle of the lowest and the
    /// highest that its column allows. A factor of two between weights counts as half a stop of distance.
    pub(crate) fn sloped(&self, slope: f64) -> Grid {
        let depth = self.size[2];
        let step = slope * (self.range.high - self.range.low) / depth as f64;
        let limited = |i: usize| {
            let ([x, y, z], [sum, weight]) = (position(i, self.size), self.cells[i]);
            if weight == 0.0 {
                return [sum, weight];
            }
            let column = (0..depth).map(|other| (other, self.cells[index([x, y, other], self.size)]));
            let [mut low, mut high] = [sum / weight; 2];
            for (other, [sum, share]) in column.filter(|(_, cell)| cell[1] > 0.0) {
                let away = step * other.abs_diff(z) as f64 + 0.5 * (share / weight).log2().abs();
                low = low.min(sum / share + away);
                high = high.max(sum / share - away);
            }
            [0.5 * (low + high) * weight, weight]
        };
        Grid::new(self.size, self.range, (0..self.cells.len()).map(limited).collect(), self.full)
    }

    /// The interpolated sums at `uv` and log2 luminance `l`.
    pub(crate) fn slice(&self, uv: [f64; 2], l: f64) -> [f64; 2] {
        let at = grid_coordinate(uv, l, self.size, self.range);
        trilinear(at, self.size).into_iter().fold([0.0; 2], |sum, (cell, weight)| {
            let value = self.cells[index(cell, self.size)];
            [0, 1].map(|k| sum[k] + weight * value[k])
        })
    }

    /// The base at `uv` and `l`, or `otherwise` where the grid holds almost nothing, as the formula book has it.
    pub(crate) fn base(&self, uv: [f64; 2], l: f64, otherwise: f64) -> f64 {
        let [sum, weight] = self.slice(uv, l);
        if weight > 1e-4 * self.peak { self.range.middle() + sum / weight } else { otherwise }
    }

    /// The same without the jump where the grid begins to know something, and without the grid's peak, which a shader
    /// would have to find first: the node's rule.
    pub(crate) fn faded_base(&self, uv: [f64; 2], l: f64, otherwise: f64) -> f64 {
        let [sum, weight] = self.slice(uv, l);
        let known = smooth_step(EMPTY, KNOWN, weight / self.full);
        if known > 0.0 { mix(otherwise, self.range.middle() + sum / weight, known) } else { otherwise }
    }
}

/// The place of a pixel in the grid, in cells, 0 at the center of the first.
pub(crate) fn grid_coordinate(uv: [f64; 2], l: f64, size: [usize; 3], range: Range) -> [f64; 3] {
    let t = (l.clamp(range.low, range.high) - range.low) / (range.high - range.low);
    let along = [uv[0], uv[1], t];
    [0, 1, 2].map(|axis| along[axis] * size[axis] as f64 - 0.5)
}

/// The cells around a grid coordinate with their weights, clamped at the edges, ordered by x,
/// then y, then luminance; no cell twice, none with weight 0.
pub(crate) fn trilinear(at: [f64; 3], size: [usize; 3]) -> Vec<([usize; 3], f64)> {
    let [xs, ys, zs] = [0, 1, 2].map(|axis| linear(at[axis], size[axis]));
    let mut shares = Vec::new();
    for &(x, a) in &xs {
        for &(y, b) in &ys {
            shares.extend(zs.iter().map(|&(z, c)| ([x, y, z], a * b * c)));
        }
    }
    shares
}

/// The one or two cells of an axis around `at`, with their weights.
fn linear(at: f64, size: usize) -> Vec<(usize, f64)> {
    let at = at.clamp(0.0, (size - 1) as f64);
    let (cell, fraction) = (at.floor() as usize, at - at.floor());
    [(cell, 1.0 - fraction), (cell + 1, fraction)].into_iter().filter(|&(_, weight)| weight > 0.0).collect()
}

/// The cell that a grid coordinate lies in.
pub(crate) fn nearest(at: [f64; 3], size: [usize; 3]) -> [usize; 3] {
    [0, 1, 2].map(|axis| ((at[axis] + 0.5).floor().max(0.0) as usize).min(size[axis] - 1))
}

fn index([x, y, z]: [usize; 3], size: [usize; 3]) -> usize {
    x + size[0] * (y + size[1] * z)
}

fn position(i: usize, size: [usize; 3]) -> [usize; 3] {
    [i % size[0], i / size[0] % size[1], i / size[0] / size[1]]
}

/// The wide Gaussian: log2 luminance averaged to `size`, then blurred; all channels alike.
pub(crate) fn wide(image: &Image, range: Range, size: [usize; 2], sigma: f64) -> Image {
    let logs = image.map(|pixel| [range.log_luminance(rgb(pixel)); 4]);
    gaussian::blur(&area_average(&logs, size), sigma)
}

/// The controls of the whole operator.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalToneMap {
    /// The share of the grid in the base; the rest is the wide Gaussian.
    pub(crate) bilateral: f64,
    pub(crate) middle: f64,
    pub(crate) contrast: f64,
    pub(crate) detail: f64,
}

impl LocalToneMap {
    /// Applies the operator to an exposed image with its blurred grid and its wide Gaussian.
    pub(crate) fn apply(&self, image: &Image, grid: &Grid, wide: &Image) -> Image {
        Image::new(image.width, image.height, |x, y| {
            let uv = center_uv(x, y, image.width, image.height);
            let [r, g, b, a] = image.texel(x as i64, y as i64);
            let l = grid.range.log_luminance([r, g, b]);
            let around = wide.tap(uv)[0];
            // With the grid alone the Gaussian is not read.
            let otherwise = if self.bilateral == 1.0 { l } else { around };
            let base = mix(around, grid.faded_base(uv, l, otherwise), self.bilateral);
            let gain = scale(l, base, self.middle, self.contrast, self.detail);
            let [r, g, b] = [r, g, b].map(|x| (x * gain).min(MAX_HALF));
            [r, g, b, a]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::image::gray;

    const RANGE: Range = Range { low: -8.0, high: 8.0 };
    const SIZE: [usize; 3] = [4, 2, 8];

    fn mapped(image: &Image, splat: Splat, settings: &LocalToneMap) -> Image {
        let grid = Grid::build(image, SIZE, RANGE, splat).blurred([1.0, 0.5, 0.8], [2, 1, 2]);
        settings.apply(image, &grid, &wide(image, RANGE, [4, 2], 1.0))
    }

    #[test]
    fn equal_contrast_and_detail_need_no_base() {
        let image = Image::new(9, 5, |x, y| gray(((x * y) as f64 - 12.0).exp2()));
        let settings = LocalToneMap { bilateral: 0.4, middle: -2.5, contrast: 0.6, detail: 0.6 };
        for splat in [Splat::Trilinear, Splat::Nearest] {
            for (before, after) in image.pixels.iter().zip(mapped(&image, splat, &settings).pixels) {
                let l = RANGE.log_luminance(rgb(*before));
                let gain = ((0.6 - 1.0) * (l + 2.5)).exp2();
                let wanted = (before[0] * gain).min(MAX_HALF);
                assert!((after[0] / wanted - 1.0).abs() < 1e-12, "{after:?} {wanted}");
            }
        }
    }

    #[test]
    fn a_constant_image_is_its_own_base() {
        let settings = LocalToneMap { bilateral: 0.4, middle: -2.5, contrast: 0.5, detail: 2.0 };
        for (width, height) in [(1, 1), (9, 5)] {
            // The level lies at the center of a cell, where nearest and trilinear agree.
            let image = Image::new(width, height, |_, _| gray(2.0_f64.powi(3)));
            for splat in [Splat::Trilinear, Splat::Nearest] {
                let result = mapped(&image, splat, &settings).pixels[0][0];
                let wanted = (-2.5 + 0.5 * (3.0 + 2.5_f64)).exp2();
                assert!((result / wanted - 1.0).abs() < 1e-12, "{result} {wanted}");
            }
        }
    }

    #[test]
    fn black_stays_black_and_the_brightest_stays_finite() {
        let image = Image::new(6, 4, |x, _| gray(if x < 3 { 0.0 } else { 65504.0 }));
        let settings = LocalToneMap { bilateral: 1.0, middle: 8.0, contrast: 0.0, detail: 4.0 };
        let result = mapped(&image, Splat::Trilinear, &settings);
        assert_eq!(result.texel(0, 0)[0], 0.0);
        assert!(result.texel(5, 0)[0] > 1.0 && result.texel(5, 0)[0] <= MAX_HALF);
    }

    #[test]
    fn nearest_puts_a_pixel_in_the_cell_that_contains_it() {
        let at = grid_coordinate([7.5 / 16.0, 3.5 / 8.0], 0.5, SIZE, RANGE);
        assert_eq!(nearest(at, SIZE), [1, 0, 4]);
        assert_eq!(nearest([-0.5, 9.0, 7.6], SIZE), [0, 1, 7]);
    }
}
