//! Multisampled images become images of one sample in each pixel.

use std::f64::consts::PI;

use super::image::Image;

/// Places of samples in a pixel, in sixteenths: the standard places of Vulkan and Direct3D.
fn places(count: usize) -> &'static [[f64; 2]] {
    match count {
        1 => &[[8.0, 8.0]],
        2 => &[[12.0, 12.0], [4.0, 4.0]],
        4 => &[[6.0, 2.0], [14.0, 6.0], [2.0, 10.0], [10.0, 14.0]],
        other => panic!("{other} samples have no places here"),
    }
}

fn window(distance: f64) -> f64 {
    let turn = |times: f64| (times * PI * distance).cos();
    if distance < 1.0 { 0.35875 + 0.48829 * turn(1.0) + 0.14128 * turn(2.0) + 0.01168 * turn(3.0) } else { 0.0 }
}

/// The color of samples that are weighted by 1 / (1 + gain * the largest component).
pub(crate) fn weighted(samples: &[[f64; 3]], gain: f64) -> [f64; 3] {
    let weight = |sample: &[f64; 3]| 1.0 / (1.0 + gain * sample.iter().copied().fold(0.0, f64::max));
    let total: f64 = samples.iter().map(weight).sum();
    std::array::from_fn(|c| samples.iter().map(|sample| weight(sample) * sample[c]).sum::<f64>() / total)
}

/// The images of the first samples, of the second ones, and so on, that lie one below the other.
pub(crate) struct Samples<'a> {
    pub(crate) all: &'a Image,
    pub(crate) count: usize,
}

impl Samples<'_> {
    fn height(&self) -> usize {
        self.all.height / self.count
    }

    fn sample(&self, x: usize, y: usize, index: usize) -> [f64; 4] {
        self.all.pixels[(y + index * self.height()) * self.all.width + x]
    }

    fn image(&self, pixel: impl Fn(usize, usize) -> [f64; 4]) -> Image {
        Image::new(self.all.width, self.height(), pixel)
    }

    /// The weighted mean in a window of this radius; over the samples of a pixel for the radius 0.
    pub(crate) fn resolved(&self, radius: f64, gain: f64) -> Image {
        let reach = radius.ceil() as i64;
        self.image(|x, y| {
            let (mut light, mut alpha, mut total) = ([0.0; 3], [0.0; 2], 0.0);
            for (i, j) in (-reach..=reach).flat_map(|j| (-reach..=reach).map(move |i| (i, j))) {
                let (px, py) = (x as i64 + i, y as i64 + j);
                if !(0..self.all.width as i64).contains(&px) || !(0..self.height() as i64).contains(&py) {
                    continue;
                }
                for (index, [left, top]) in places(self.count).iter().enumerate() {
                    let apart = (i as f64 + left / 16.0 - 0.5).hypot(j as f64 + top / 16.0 - 0.5);
                    let share = if radius > 0.0 { window(apart / radius) } else { 1.0 };
                    let one = self.sample(px as usize, py as usize, index);
                    let weight = share / (1.0 + gain * one[..3].iter().copied().fold(0.0, f64::max));
                    (0..3).for_each(|c| light[c] += weight * one[c]);
                    total += weight;
                    alpha = [alpha[0] + share * one[3], alpha[1] + share];
                }
            }
            let [r, g, b] = light.map(|sum| sum / total);
            [r, g, b, alpha[0] / alpha[1]]
        })
    }

    /// The sample of each pixel whose x is the smallest, or the largest.
    pub(crate) fn chosen(&self, is_largest: bool) -> Image {
        let sign = if is_largest { -1.0 } else { 1.0 };
        self.image(|x, y| {
            let samples = (0..self.count).map(|index| self.sample(x, y, index));
            samples.min_by(|a, b| (sign * a[0]).total_cmp(&(sign * b[0]))).expect("a pixel has samples")
        })
    }
}

#[test]
fn a_window_keeps_a_constant_and_a_ramp_that_is_sampled_where_samples_lie() {
    let at = |x: f64, y: f64| 3.0 + 0.5 * x - 0.25 * y;
    let (width, height) = (9, 8);
    let all = Image::new(width, 4 * height, |x, y| {
        let [left, top] = places(4)[y / height];
        let light = at(x as f64 + left / 16.0, (y % height) as f64 + top / 16.0);
        [light, 2.0, 0.0, light]
    });
    let samples = Samples { all: &all, count: 4 };
    for radius in [0.0, 1.5, 2.0] {
        let found = samples.resolved(radius, 0.0).texel(4, 4);
        // The window is round and the places are not symmetric to each axis, but each has its opposite.
        assert!((found[0] - at(4.5, 4.5)).abs() < 1e-12 && (found[3] - found[0]).abs() < 1e-12, "{radius}: {found:?}");
        assert!((found[1] - 2.0).abs() < 1e-12);
    }
}

#[test]
fn an_edge_against_a_lamp_has_the_light_that_tone_mapped_samples_have() {
    let reinhard = |light: f64| light / (1.0 + light);
    for lit in 0..=4 {
        let samples: Vec<[f64; 3]> = (0..4).map(|i| [if i < lit { 50.0 } else { 0.0 }; 3]).collect();
        let ideal = samples.iter().map(|s| reinhard(s[0])).sum::<f64>() / 4.0;
        assert!((reinhard(weighted(&samples, 1.0)[0]) - ideal).abs() < 1e-12);
    }
    let half = [[50.0; 3], [50.0; 3], [0.0; 3], [0.0; 3]];
    assert!(reinhard(weighted(&half, 0.0)[0]) > 0.96, "the plain mean hides the edge");
}
