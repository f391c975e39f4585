//! Bloom: what glows, the chain of levels and the composite (formula book, 12); glare (14).

use super::color::luminance;
use super::gaussian::blur_axis;
use super::image::{Image, mix4, rgb};
use super::math::{Rgb, largest, mix, smooth_step};
use super::resample::{Down, Firefly, Up, downsample, downsample_karis, half_size, upsample};

/// The factor of a color of `brightness` under a threshold with a quadratic knee, which begins at black at the lowest.
pub(crate) fn knee_weight(brightness: f64, threshold: f64, knee: f64) -> f64 {
    let threshold = threshold.max(0.0);
    let knee = knee.clamp(0.0, threshold);
    let hard = (brightness - threshold).max(0.0);
    let soft = if knee > 0.0 {
        let s = (brightness - threshold + knee).clamp(0.0, 2.0 * knee);
        s * s / (4.0 * knee)
    } else {
        0.0
    };
    hard.max(soft) / brightness.max(1e-5)
}

/// The factor of a gate that opens from `threshold − knee` to `threshold + knee`; without a knee
/// a jump, which a brightness of 0 never passes.
pub(crate) fn gate_weight(brightness: f64, threshold: f64, knee: f64) -> f64 {
    if brightness <= 0.0 {
        return 0.0;
    }
    let knee = knee.min(threshold);
    smooth_step(threshold - knee, threshold + knee, brightness)
}

/// The glow of a pixel whose alpha is its emissive intensity, up to 1: nothing below `threshold`.
pub(crate) fn select_emissive([r, g, b, a]: [f64; 4], threshold: f64, intensity: f64) -> Rgb {
    if a >= threshold { [r, g, b].map(|x| x * a.min(1.0) * intensity) } else { [0.0; 3] }
}

/// The sizes of `count` levels, the first half of the image.
pub(crate) fn level_sizes(width: usize, height: usize, count: usize) -> Vec<[usize; 2]> {
    let next = |&[width, height]: &[usize; 2]| Some(half_size(width, height));
    std::iter::successors(next(&[width, height]), next).take(count).collect()
}

/// The levels of a chain, the first half of the image; the firefly weighting acts on the first
/// step alone. Images are open at their borders.
pub(crate) fn levels(image: &Image, count: usize, filter: Down, firefly: Firefly) -> Vec<Image> {
    let mut levels: Vec<Image> = Vec::new();
    for size in level_sizes(image.width, image.height, count) {
        let level = match levels.last() {
            None => downsample_karis(&image.with_open_beyond(), size, filter, firefly),
            Some(above) => downsample(&above.with_open_beyond(), size, filter),
        };
        levels.push(level);
    }
    levels
}

/// Joins levels from the smallest up by `mix(level, upsampled, spread)`; the result has the size
/// of the first level. Images are open at their borders.
pub(crate) fn lerp_chain(levels: &[Image], spread: f64, filter: Up, radius: f64) -> Image {
    join(levels, filter, radius, |level, above| mix4(level, above, spread))
}

/// Joins levels from the smallest up by addition and divides by their number.
pub(crate) fn additive_chain(levels: &[Image], filter: Up, radius: f64) -> Image {
    let sum = join(levels, filter, radius, |a, b| [0, 1, 2, 3].map(|i| a[i] + b[i]));
    sum.map(|pixel| pixel.map(|x| x / levels.len() as f64))
}

/// Joins levels from the smallest up by addition, each times its weight.
pub(crate) fn weighted_chain(levels: &[Image], weights: &[f64], filter: Up, radius: f64) -> Image {
    let weighted = |(level, weight): (&Image, &f64)| level.map(|pixel| pixel.map(|x| weight * x));
    let weighted: Vec<Image> = levels.iter().zip(weights).map(weighted).collect();
    join(&weighted, filter, radius, |a, b| [0, 1, 2, 3].map(|i| a[i] + b[i]))
}

/// The smoothing of `Upsample`: weights of 1/11, 8/33, 1/3, 8/33 and 1/11 along each axis.
pub(crate) fn smoothed(bloom: &Image) -> Image {
    let half = [1.0 / 3.0, 8.0 / 33.0, 1.0 / 11.0];
    let across = blur_axis(&bloom.with_open_beyond(), &half, [1, 0]);
    blur_axis(&across.with_open_beyond(), &half, [0, 1])
}

fn join(levels: &[Image], filter: Up, radius: f64, combine: impl Fn([f64; 4], [f64; 4]) -> [f64; 4]) -> Image {
    let (smallest, finer) = levels.split_last().expect("a chain has a level");
    finer.iter().rev().fold(smallest.clone(), |result, level| {
        let wide = upsample(&result.with_open_beyond(), [level.width, level.height], filter, radius);
        let pixels = level.pixels.iter().zip(&wide.pixels);
        Image { pixels: pixels.map(|(&a, &b)| combine(a, b)).collect(), ..*level }
    })
}

/// The share of each level in [`lerp_chain`], finest first.
pub(crate) fn lerp_weights(spread: f64, count: usize) -> Vec<f64> {
    let share = |i: usize| {
        let own = if i + 1 == count { 1.0 } else { 1.0 - spread };
        own * spread.powi(i as i32)
    };
    (0..count).map(share).collect()
}

/// The five weights of the Unreal-style bloom of three.js.
pub(crate) fn unreal_weights(radius: f64) -> [f64; 5] {
    [1.0, 0.8, 0.6, 0.4, 0.2].map(|factor| mix(factor, 1.2 - factor, radius))
}

/// The settings of the energy-conserving blend of Bevy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conserving {
    pub(crate) intensity: f64,
    pub(crate) low_boost: f64,
    pub(crate) low_curvature: f64,
    pub(crate) high_pass: f64,
}

/// The blend factor of level `mip` of 0..=`last` in the energy-conserving blend of Bevy.
pub(crate) fn conserving_factor(mip: f64, last: f64, settings: &Conserving) -> f64 {
    let &Conserving { intensity, low_boost, low_curvature, high_pass } = settings;
    let t = mip / last;
    let boost = (1.0 - (1.0 - t).powf(1.0 / (1.0 - low_curvature))) * low_boost;
    let passed = 1.0 - ((t - high_pass) / high_pass).clamp(0.0, 1.0);
    (intensity + boost * (1.0 - intensity)) * passed
}

/// Replaces a share of the scene by its bloom; energy stays.
pub(crate) fn composite_lerp(scene: Rgb, bloom: Rgb, strength: f64) -> Rgb {
    [0, 1, 2].map(|i| mix(scene[i], bloom[i], strength))
}

/// Adds bloom to the scene.
pub(crate) fn composite_add(scene: Rgb, bloom: Rgb, strength: f64) -> Rgb {
    [0, 1, 2].map(|i| scene[i] + strength * bloom[i])
}

/// Adds bloom in the distance to white; never above it.
pub(crate) fn composite_screen(scene: Rgb, bloom: Rgb, strength: f64) -> Rgb {
    [0, 1, 2].map(|i| scene[i] + (strength * bloom[i]).clamp(0.0, 1.0) * (1.0 - scene[i]).max(0.0))
}

/// The result of `fireflies: Limit` for an image, with the frame before if there is one, or by its neighbors alone.
pub(crate) fn without_fireflies(image: &Image, before: Option<&Image>) -> Image {
    let bright = |image: &Image, x: i64, y: i64| largest(rgb(image.texel(x, y)));
    Image::new(image.width, image.height, |x, y| {
        let (x, y) = (x as i64, y as i64);
        let inside = |i: i64, j: i64| (0..image.width as i64).contains(&i) && (0..image.height as i64).contains(&j);
        let around = (-1..=1).flat_map(|j| (-1..=1).map(move |i| (x + i, y + j)));
        let near = around.filter(|&(i, j)| (i, j) != (x, y) && inside(i, j)).map(|(i, j)| bright(image, i, j));
        let past = before.map_or(0.0, |before| {
            // Whole squares of 2x2 pixels.
            let near = |at: i64| (at - 7).div_euclid(2) * 2..(at - 7).div_euclid(2) * 2 + 16;
            let places = near(y).flat_map(|j| near(x).map(move |i| (i, j)));
            places.filter(|&(i, j)| inside(i, j)).map(|(i, j)| bright(before, i, j)).fold(0.0, f64::max)
        });
        let (limit, own) = ((4.0 * near.fold(0.0, f64::max)).max(2.0 * past), bright(image, x, y));
        let [r, g, b, a] = image.texel(x, y);
        let factor = if own <= limit || image.pixels.len() == 1 { 1.0 } else { limit / own };
        [r * factor, g * factor, b * factor, a]
    })
}

/// The glare of a color that the exponential curve has mapped.
pub(crate) fn glare(rgb: Rgb, exposure: f64) -> Rgb {
    let mapped = rgb.map(|x| super::curves::exponential(x, exposure));
    let gate = smooth_step(0.8, 1.0, luminance(mapped));
    mapped.map(|x| x * gate * 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::image::gray;

    #[test]
    fn chains_keep_a_constant_away_from_the_border() {
        let image = Image::new(208, 97, |_, _| gray(3.0));
        let levels = levels(&image, 2, Down::ThirteenTap, Firefly::Groups);
        assert_eq!(levels.len(), 2);
        for result in [lerp_chain(&levels, 0.85, Up::Tent, 1.0), additive_chain(&levels, Up::Bilinear, 1.0)] {
            assert_eq!((result.width, result.height), (104, 48));
            assert!((result.texel(52, 24)[0] - 3.0).abs() < 1e-12);
            assert!(result.texel(0, 24)[0] < 2.5 && result.texel(0, 0)[0] < 2.0);
        }
    }

    #[test]
    fn a_chain_gives_each_level_its_weight() {
        let sizes = level_sizes(256, 256, 4);
        for (wanted, weight) in lerp_weights(0.7, 4).into_iter().enumerate() {
            let levels: Vec<Image> = sizes
                .iter()
                .enumerate()
                .map(|(i, &[w, h])| Image::new(w, h, |_, _| gray(f64::from(i == wanted))))
                .collect();
            let value = lerp_chain(&levels, 0.7, Up::Tent, 1.0).texel(64, 64)[0];
            assert!((value - weight).abs() < 1e-14, "{wanted}: {value} {weight}");
            let value = additive_chain(&levels, Up::Tent, 1.0).texel(64, 64)[0];
            assert!((value - 0.25).abs() < 1e-14, "{wanted}: {value}");
        }
    }

    #[test]
    fn black_never_glows() {
        assert_eq!(gate_weight(0.0, 0.0, 0.0), 0.0);
        assert_eq!(gate_weight(1e-6, 0.0, 0.0), 1.0);
        assert_eq!(knee_weight(0.0, 0.0, 0.0), 0.0);
    }
}
