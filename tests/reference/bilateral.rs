//! A separated bilateral blur by depth and normals.

use super::image::{Image, add_weighted, rgb};
use super::math::dot;
use super::view::distance_of;

#[derive(Clone, Copy)]
pub(crate) struct Bilateral {
    pub(crate) radius: i64,
    pub(crate) depth_threshold: f64,
    pub(crate) normal_threshold: f64,
}

fn inverse(depth: &Image, x: i64, y: i64) -> f64 {
    1.0 / distance_of(depth.texel(x, y)[0])
}

/// The change of the inverse from a texel to the next: the smaller difference.
fn slope(depth: &Image, [x, y]: [i64; 2], [dx, dy]: [i64; 2]) -> f64 {
    let has = |x: i64, y: i64| (0..depth.width as i64).contains(&x) && (0..depth.height as i64).contains(&y);
    let middle = inverse(depth, x, y);
    let after = has(x + dx, y + dy).then(|| inverse(depth, x + dx, y + dy) - middle);
    let before = has(x - dx, y - dy).then(|| middle - inverse(depth, x - dx, y - dy));
    match (after, before) {
        (Some(after), Some(before)) if after.abs() < before.abs() => after,
        (after, before) => before.or(after).unwrap_or(0.0),
    }
}

impl Bilateral {
    pub(crate) fn apply(&self, image: &Image, depth: &Image, normal: Option<&Image>) -> Image {
        self.along(&self.along(image, depth, normal, [1, 0]), depth, normal, [0, 1])
    }

    fn along(&self, image: &Image, depth: &Image, normal: Option<&Image>, step: [i64; 2]) -> Image {
        let sharpness = 2.0 / (self.radius * self.radius) as f64;
        Image::new(image.width, image.height, |x, y| {
            let (x, y) = (x as i64, y as i64);
            let (middle, slope) = (inverse(depth, x, y), slope(depth, [x, y], step));
            let (mut sum, mut total) = ([0.0; 4], 0.0);
            for i in -self.radius..=self.radius {
                let (i_x, i_y) = (x + i * step[0], y + i * step[1]);
                if !(0..image.width as i64).contains(&i_x) || !(0..image.height as i64).contains(&i_y) {
                    continue;
                }
                let expected = middle + slope * i as f64;
                let off = (inverse(depth, i_x, i_y) - expected).abs() / (middle * self.depth_threshold);
                let facing = normal.map_or(1.0, |normal| self.facing(normal, [x, y], [i_x, i_y]));
                let gauss = (-sharpness * (i * i) as f64).exp();
                let weight = if i == 0 { 1.0 } else { (1.0 - off.min(1.0).powi(2)) * facing * gauss };
                let color = image.texel(i_x, i_y);
                sum = add_weighted(sum, color, weight);
                total += weight;
            }
            sum.map(|channel| channel / total)
        })
    }

    fn facing(&self, normal: &Image, a: [i64; 2], b: [i64; 2]) -> f64 {
        let unit = |[x, y]: [i64; 2]| {
            let v = rgb(normal.texel(x, y));
            v.map(|part| part / dot(v, v).sqrt().max(1e-3))
        };
        (1.0 - (1.0 - dot(unit(a), unit(b))) / self.normal_threshold).clamp(0.0, 1.0)
    }
}

#[test]
fn a_sloping_plane_is_blurred_as_a_whole_and_a_step_is_not() {
    let noise = Image::new(33, 9, |x, y| [f64::from(u8::from((x + y) % 2 == 0)), 0.0, 0.0, 1.0]);
    let blur = Bilateral { radius: 6, depth_threshold: 0.01, normal_threshold: 0.3 };
    let plane = Image::new(33, 9, |x, y| [1.0 / (0.05 + 0.01 * x as f64 + 0.004 * y as f64), 0.0, 0.0, 1.0]);
    let flat = Image::new(33, 9, |_, _| [3.0, 0.0, 0.0, 1.0]);
    let (sloping, level) = (blur.apply(&noise, &plane, None), blur.apply(&noise, &flat, None));
    for (a, b) in sloping.pixels.iter().zip(&level.pixels) {
        assert!((a[0] - b[0]).abs() < 1e-9 && (a[0] - 0.5).abs() < 0.1, "{a:?} and {b:?}");
    }
    let step = Image::new(33, 9, |x, _| [if x < 16 { 2.0 } else { 2.1 }, 0.0, 0.0, 1.0]);
    let sides = Image::new(33, 9, |x, _| [if x < 16 { 1.0 } else { 5.0 }, 0.0, 0.0, 1.0]);
    let kept = blur.apply(&sides, &step, None);
    assert!(kept.pixels.iter().zip(&sides.pixels).all(|(a, b)| (a[0] - b[0]).abs() < 1e-12));
}
