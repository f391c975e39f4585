//! Film grain from a hash of the pixel's cell.

use super::color::luminance;
use super::math::{Rgb, mix, smooth_step};

/// The parameters that have no constant value in the tests.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grain {
    pub(crate) amount: f64,
    /// The diameter of a grain in pixels.
    pub(crate) size: f64,
    /// 0 for grey grain, 1 for grain of independent channels.
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

/// The sum of two uniform numbers in (-1/2, 1/2) for each lattice point.
fn point(x: u32, y: u32, seed: u32) -> f64 {
    let bits = hash(x ^ hash(y ^ hash(seed)));
    f64::from((bits >> 16) + (bits & 0xffff)) / 65536.0 - 1.0
}

/// The lattice, interpolated and scaled back to the variance of its points.
fn lattice([x, y]: [f64; 2], seed: u32) -> f64 {
    let (left, top) = (x.floor(), y.floor());
    let [u, v] = [x - left, y - top].map(|f| f * f * (3.0 - 2.0 * f));
    let (left, top) = (left as u32, top as u32);
    let low = mix(point(left, top, seed), point(left + 1, top, seed), u);
    let high = mix(point(left, top + 1, seed), point(left + 1, top + 1, seed), u);
    let power = (u * u + (1.0 - u) * (1.0 - u)) * (v * v + (1.0 - v) * (1.0 - v));
    (mix(low, high, v) / power.sqrt()).clamp(-1.0, 1.0)
}

impl Grain {
    /// The colour of a pixel with grain, for colours from 0 to 1.
    pub(crate) fn apply(&self, rgb: Rgb, pixel: [usize; 2]) -> Rgb {
        let at = pixel.map(|side| side as f64 / self.size);
        let grey = lattice(at, self.seed * 4);
        let y = luminance(rgb);
        let rising = mix(SHADOWS, 1.0, smooth_step(0.0, PIVOT, y));
        let strength = self.amount * mix(rising, HIGHLIGHTS, smooth_step(PIVOT, 1.0, y));
        [0, 1, 2].map(|channel| {
            let tinted = lattice(at, self.seed * 4 + 1 + channel as u32);
            rgb[channel] + strength * mix(grey, tinted, self.color) * rgb[channel] * (1.0 - rgb[channel])
        })
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
