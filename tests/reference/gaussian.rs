//! The separable Gaussian blur, tap by tap and with linear-filtered pairs (formula book, 13).

use super::image::{Image, add_weighted};

/// The radius in pixels that a blur of `sigma` pixels needs.
pub(crate) fn radius(sigma: f64) -> usize {
    (3.0 * sigma).ceil() as usize
}

/// The weights of offsets 0..=radius; with both sides counted they sum to 1.
pub(crate) fn taps(sigma: f64, radius: usize) -> Vec<f64> {
    let raw: Vec<f64> = (0..=radius).map(|i| (-((i * i) as f64) / (2.0 * sigma * sigma)).exp()).collect();
    let total = raw[0] + 2.0 * raw[1..].iter().sum::<f64>();
    raw.iter().map(|weight| weight / total).collect()
}

/// The weights whose variance is this one, up to three standard deviations.
pub(crate) fn taps_of_variance(variance: f64) -> Vec<f64> {
    let radius = radius(variance.sqrt());
    let found = |sigma: f64| {
        let weights = taps(sigma, radius);
        2.0 * weights.iter().enumerate().map(|(i, weight)| (i * i) as f64 * weight).sum::<f64>()
    };
    let (mut narrow, mut wide) = (1e-3, 1e3);
    while wide - narrow > 1e-9 {
        let middle = 0.5 * (narrow + wide);
        *if found(middle) < variance { &mut narrow } else { &mut wide } = middle;
    }
    taps(wide, radius)
}

/// Half a kernel as `[offset, weight]` of bilinear taps: the center, then pairs, then what is
/// left over.
pub(crate) fn linear_pairs(half: &[f64]) -> Vec<[f64; 2]> {
    let mut pairs = vec![[0.0, half[0]]];
    for (i, pair) in half[1..].chunks(2).enumerate() {
        let weight: f64 = pair.iter().sum();
        let toward_next = pair.get(1).map_or(0.0, |next| next / weight);
        pairs.push([(2 * i + 1) as f64 + toward_next, weight]);
    }
    pairs
}

/// A blur along one axis, `step` = `[1, 0]` or `[0, 1]`, clamped to the edge.
pub(crate) fn blur_axis(image: &Image, half: &[f64], step: [i64; 2]) -> Image {
    Image::new(image.width, image.height, |x, y| {
        let at = |i: i64| image.texel(x as i64 + i * step[0], y as i64 + i * step[1]);
        let mut sum = [0.0; 4];
        for (i, &weight) in half.iter().enumerate() {
            sum = add_weighted(sum, at(i as i64), weight);
            if i > 0 {
                sum = add_weighted(sum, at(-(i as i64)), weight);
            }
        }
        sum
    })
}

/// A blur in x, then in y. A sigma of at most 0.2 pixels changes nothing.
pub(crate) fn blur(image: &Image, sigma: f64) -> Image {
    if sigma <= 0.2 {
        return image.clone();
    }
    let half = taps(sigma, radius(sigma));
    blur_axis(&blur_axis(image, &half, [1, 0]), &half, [0, 1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::image::gray;

    #[test]
    fn a_blur_keeps_a_constant_and_spreads_a_spike_by_sigma() {
        let constant = blur(&Image::new(5, 3, |_, _| gray(0.7)), 2.0);
        assert!(constant.pixels.iter().all(|pixel| (pixel[0] - 0.7).abs() < 1e-14));

        let spike = Image::new(33, 33, |x, y| gray(if (x, y) == (16, 16) { 1.0 } else { 0.0 }));
        let blurred = blur(&spike, 2.0);
        let variance: f64 = (0..33)
            .flat_map(|y| (0..33).map(move |x| (x, y)))
            .map(|(x, y)| (x as f64 - 16.0).powi(2) * blurred.texel(x, y)[0])
            .sum();
        assert!((variance - 4.0).abs() < 0.15, "{variance}");
    }

    #[test]
    fn linear_pairs_read_what_the_taps_read() {
        let image = Image::new(40, 1, |x, _| gray((x * x % 17) as f64));
        for radius in [4, 5] {
            let half = taps(1.7, radius);
            let direct = blur_axis(&image, &half, [1, 0]).texel(20, 0)[0];
            let tap = |offset: f64| image.tap_offset([20.5 / 40.0, 0.5], [offset, 0.0])[0];
            let paired: f64 = linear_pairs(&half)
                .iter()
                .map(|&[offset, weight]| match offset {
                    0.0 => weight * tap(0.0),
                    _ => weight * (tap(offset) + tap(-offset)),
                })
                .sum();
            assert!((direct - paired).abs() < 1e-12, "{radius}: {direct} {paired}");
        }
    }

    #[test]
    fn a_small_sigma_changes_nothing() {
        let image = Image::new(4, 1, |x, _| gray(x as f64));
        assert_eq!(blur(&image, 0.2), image);
    }
}
