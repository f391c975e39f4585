//! Light that lenses and film spread: halation, streaks, flares, dirt.

use super::gaussian::{blur_axis, taps_of_variance};
use super::image::{Image, add_weighted, center_uv};
use super::math::{Rgb, largest, smooth_step};
use super::resample::{Down, Up, downsample, half_size, upsample};

/// Halation: `share` of each channel is spread by a Gaussian of `sigma` pixels, at half the resolution as long as it is
/// wider than four texels along y. Its variance is less by that of the halvings, 7/4 of the texels of each source, and
/// of the tent, 2/3 of the texels and a twelfth of the pixels.
pub(crate) fn halation(image: &Image, share: Rgb, sigma: f64) -> Image {
    let mut small = image.clone();
    while sigma * small.height as f64 / image.height as f64 > 4.0 && small.width.max(small.height) > 1 {
        small = downsample(&small, half_size(small.width, small.height), Down::ThirteenTap);
    }
    let [across, down] = [(small.width, image.width), (small.height, image.height)].map(|(side, whole)| {
        let scale = side as f64 / whole as f64;
        let filters = if side < whole { 1.25 - 0.5 * scale * scale } else { 0.0 };
        taps_of_variance((sigma * scale).powi(2) - filters)
    });
    let glow = blur_axis(&blur_axis(&small, &across, [1, 0]), &down, [0, 1]);
    let is_whole = (glow.width, glow.height) == (image.width, image.height);
    let glow = if is_whole { glow } else { upsample(&glow, [image.width, image.height], Up::Tent, 1.0) };
    Image::new(image.width, image.height, |x, y| {
        let [base, glow] = [image, &glow].map(|image| image.texel(x as i64, y as i64));
        let [r, g, b] = share;
        let shares = [r, g, b, (r + g + b) / 3.0];
        [0, 1, 2, 3].map(|c| base[c] * (1.0 - shares[c]) + glow[c] * shares[c])
    })
}

/// Horizontal streaks: to each side a sum of `count` texels with the weights exp(-k / length), which sum to 1; the mean
/// of both sides, times `tint`. There is no light outside of the image.
pub(crate) fn streaks(image: &Image, length: f64, count: i64, tint: Rgb) -> Image {
    let weights: Vec<f64> = (0..count).map(|k| (-(k as f64) / length).exp()).collect();
    let total: f64 = weights.iter().sum();
    Image::new(image.width, image.height, |x, y| {
        let mut sum = [0.0; 4];
        for (k, weight) in weights.iter().enumerate() {
            for at in [x as i64 - k as i64, x as i64 + k as i64] {
                let is_inside = (0..image.width as i64).contains(&at);
                let light = if is_inside { image.texel(at, y as i64) } else { [0.0; 4] };
                sum = add_weighted(sum, light, 0.5 * weight / total);
            }
        }
        let [r, g, b] = [0, 1, 2].map(|c| sum[c] * tint[c]);
        [r, g, b, image.texel(x as i64, y as i64)[3]]
    })
}

/// The parameters of a flare.
pub(crate) struct Flare {
    pub(crate) threshold: f64,
    pub(crate) limit: f64,
    pub(crate) ghosts: usize,
    pub(crate) spacing: f64,
    pub(crate) ghost_strength: f64,
    pub(crate) halo_radius: f64,
    pub(crate) halo_strength: f64,
    pub(crate) dispersion: f64,
}

/// The colors of ghosts, one after the other.
const TINTS: [Rgb; 4] = [[0.6, 1.0785, 1.4], [1.6, 0.8418, 0.8], [0.8, 1.1099, 0.5], [1.1, 0.8996, 1.7]];

impl Flare {
    /// Light at a place relative to the center, faded at the border.
    fn light(&self, image: &Image, [x, y]: [f64; 2], dispersion: f64) -> Rgb {
        let places = [-1.0, 0.0, 1.0].map(|step| [x, y].map(|t| 0.5 + t * (1.0 + dispersion * step)));
        let light = [0, 1, 2].map(|channel| (image.tap(places[channel])[channel] - self.threshold).max(0.0));
        let most = largest(light);
        let kept = if most > 0.5 * self.limit { self.limit - 0.25 * self.limit.powi(2) / most } else { most };
        let fade = |t: f64| smooth_step(0.0, 0.1, t.min(1.0 - t));
        [0, 1, 2].map(|channel| {
            let [u, v] = places[channel];
            if most > 0.0 { fade(u) * fade(v) * light[channel] * kept / most } else { 0.0 }
        })
    }

    pub(crate) fn apply(&self, image: &Image) -> Image {
        let aspect = image.width as f64 / image.height as f64;
        Image::new(image.width, image.height, |x, y| {
            let [u, v] = center_uv(x, y, image.width, image.height).map(|t| t - 0.5);
            let mut sum = [0.0; 3];
            for i in 0..self.ghosts {
                let size = self.spacing * (i + 1) as f64 * if i % 2 == 0 { -1.0 } else { 1.0 };
                let light = self.light(image, [u / size, v / size], self.dispersion);
                sum = [0, 1, 2].map(|c| sum[c] + self.ghost_strength / self.ghosts as f64 * TINTS[i % 4][c] * light[c]);
            }
            let length = (u * aspect).hypot(v).max(1e-6);
            let reach = self.halo_radius / length - 1.0;
            let halo = self.light(image, [u * reach, v * reach], 4.0 * self.dispersion);
            let [r, g, b] = [0, 1, 2].map(|c| sum[c] + self.halo_strength * halo[c]);
            [r, g, b, 0.0]
        })
    }
}

/// PCG output permutation over one LCG step, and PCG3D (Jarzynski and Olano, 2020).
fn hash(v: u32) -> u32 {
    let state = v.wrapping_mul(747796405).wrapping_add(2891336453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277803737);
    (word >> 22) ^ word
}

fn hash3(seed: [u32; 3]) -> [u32; 3] {
    let [mut x, mut y, mut z] = seed.map(|part| part.wrapping_mul(1664525).wrapping_add(1013904223));
    let stir = |[x, y, z]: [&mut u32; 3]| {
        *x = x.wrapping_add(y.wrapping_mul(*z));
        *y = y.wrapping_add(z.wrapping_mul(*x));
        *z = z.wrapping_add(x.wrapping_mul(*y));
    };
    stir([&mut x, &mut y, &mut z]);
    [x, y, z] = [x, y, z].map(|part| part ^ part >> 16);
    stir([&mut x, &mut y, &mut z]);
    [x, y, z]
}

fn unit(hashed: u32) -> f64 {
    f64::from(hashed >> 8) / 16777216.0
}

fn smudges([x, y]: [f64; 2], seed: u32) -> f64 {
    let cells = (-1..=1).flat_map(|j| (-1..=1).map(move |i| [x.floor() as i32 + i, y.floor() as i32 + j]));
    let smudge = |cell: [i32; 2]| {
        let [u, v, size] = hash3([cell[0] as u32, cell[1] as u32, seed]).map(unit);
        let weight = unit(hash(seed ^ hash(cell[0] as u32 ^ hash(cell[1] as u32))));
        let radius = 0.1 + 0.4 * size * size;
        let distance = (f64::from(cell[0]) + u - x).hypot(f64::from(cell[1]) + v - y);
        weight * weight * (1.0 - smooth_step(0.5 * radius, radius, distance))
    };
    cells.map(smudge).sum()
}

/// The dirt at a place: three layers of smudges, each of half the size and half the weight.
pub(crate) fn dirt([u, v]: [f64; 2], aspect: f64, scale: f64, seed: u32) -> f64 {
    let at = |factor: f64| [u * aspect * scale * factor, v * scale * factor];
    smudges(at(1.0), seed) + 0.5 * smudges(at(2.0), seed + 1) + 0.25 * smudges(at(4.0), seed + 2)
}

#[test]
fn halation_keeps_the_sum_of_light_and_moves_red_most() {
    let dot = Image::new(65, 65, |x, y| if (x, y) == (32, 32) { [1000.0; 4] } else { [0.0; 4] });
    let spread = halation(&dot, [0.2, 0.1, 0.0], 3.0);
    let sum = |channel: usize| spread.pixels.iter().map(|pixel| pixel[channel]).sum::<f64>();
    assert!((0..3).all(|channel| (sum(channel) - 1000.0).abs() < 1e-9));
    let beside = spread.texel(35, 32);
    assert!((beside[0] / beside[1] - 2.0).abs() < 1e-12 && beside[1] > 0.5 && beside[2] == 0.0, "{beside:?}");
}

#[test]
fn a_ghost_of_a_light_is_on_the_other_side_of_the_center() {
    let light = Image::new(101, 101, |x, y| if (x, y) == (80, 50) { [1.0; 4] } else { [0.0; 4] });
    let mut flare = Flare {
        threshold: 0.0,
        limit: 65504.0,
        ghosts: 1,
        spacing: 0.5,
        ghost_strength: 1.0,
        halo_radius: 0.4,
        halo_strength: 0.0,
        dispersion: 0.0,
    };
    let ghost = flare.apply(&light);
    // 30 pixels to the right of the center becomes 15 to the left.
    assert!((ghost.texel(35, 50)[1] - TINTS[0][1]).abs() < 1e-12, "{:?}", ghost.texel(35, 50));
    flare.threshold = 1.0;
    assert!(flare.apply(&light).pixels.iter().all(|pixel| *pixel == [0.0; 4]), "a lamp that is no sun");
}
