//! Temporal anti-aliasing with a history that is limited by mean and variance (Karis 2014, Salvi 2016).

use afterimage_graph::node::Camera;
use glam::{DMat4, DVec2, DVec3, Vec4Swizzles as _};

use super::image::Image;
use super::math::{Rgb, mix};
use super::sanitize::extended;
use super::view::{View, distance_of};

#[derive(Clone, Copy)]
pub(crate) struct Taa {
    pub(crate) blend: f64,
    /// The share of the new frame in the middle of four texels of the history.
    pub(crate) moving: f64,
    pub(crate) variance: f64,
    pub(crate) depth_threshold: f64,
    pub(crate) white: f64,
    /// The light above which means count it in full.
    pub(crate) keep_above: f64,
}

/// A frame, and what the frame before left.
#[derive(Clone, Copy)]
pub(crate) struct Frames<'a> {
    pub(crate) source: &'a Image,
    /// `None` after a reset.
    pub(crate) history: Option<&'a Image>,
    pub(crate) depth: &'a Image,
    pub(crate) previous_depth: Option<&'a Image>,
    /// In uv.
    pub(crate) motion: Option<&'a Image>,
    pub(crate) camera: &'a Camera,
    /// The brightness of the light, relative to the frame before.
    pub(crate) ratio: f64,
}

fn wide(matrix: [[f32; 4]; 4]) -> DMat4 {
    DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)))
}

/// The neighborhood of a pixel.
struct Around {
    color: Rgb,
    mean: Rgb,
    /// From the mean to the least and to the greatest that is allowed.
    below: Rgb,
    above: Rgb,
    lamps: Lamps,
    /// The filtered new alpha, and the limits of the old one.
    alpha: [f64; 3],
}

/// The light of lamps around a pixel: the filtered new one, and the limits of the old one.
struct Lamps {
    color: Rgb,
    least: Rgb,
    greatest: Rgb,
}

impl Frames<'_> {
    fn size(&self) -> DVec2 {
        DVec2::new(self.source.width as f64, self.source.height as f64)
    }

    fn jitter(&self) -> DVec2 {
        DVec2::from_array(self.camera.jitter.map(f64::from))
    }

    fn distance(&self, [x, y]: [i64; 2]) -> f64 {
        distance_of(self.depth.texel(x, y)[0])
    }

    fn world(&self, [x, y]: [i64; 2]) -> DVec3 {
        let jitter = self.jitter();
        let view = View::new(self.camera, self.source);
        let place = view.place([x as f64 + jitter.x, y as f64 + jitter.y], self.distance([x, y]));
        (wide(self.camera.view).inverse() * place.extend(1.0)).xyz()
    }

    fn nearest(&self, [x, y]: [i64; 2]) -> [i64; 2] {
        let mut nearest = [x, y];
        let mut least = self.distance([x, y]);
        for (i, j) in (-1..=1).flat_map(|j| (-1..=1).map(move |i| (x + i, y + j))) {
            if self.distance([i, j]) < least {
                (nearest, least) = ([i, j], self.distance([i, j]));
            }
        }
        let last = [self.depth.width as i64 - 1, self.depth.height as i64 - 1];
        [nearest[0].clamp(0, last[0]), nearest[1].clamp(0, last[1])]
    }

    /// The motion of a pixel since the frame before, in uv.
    pub(crate) fn motion(&self, [x, y]: [i64; 2]) -> DVec2 {
        if let Some(motion) = self.motion {
            let [u, v, ..] = motion.texel(x, y);
            return DVec2::new(u, v);
        }
        let uv = (DVec2::new(x as f64 + 0.5, y as f64 + 0.5) + self.jitter()) / self.size();
        let before = wide(self.camera.previous_projection) * wide(self.camera.previous_view);
        let clip = before * self.world([x, y]).extend(1.0);
        let there = clip.xy() / clip.w.max(1e-7);
        uv - DVec2::new(0.5 + 0.5 * there.x, 0.5 - 0.5 * there.y)
    }

    fn was_seen(&self, pixel: [i64; 2], there: DVec2, threshold: f64) -> bool {
        let Some(previous) = self.previous_depth else { return true };
        let expected = -(wide(self.camera.previous_view) * self.world(pixel).extend(1.0)).z;
        let middle = there * self.size() - DVec2::from_array(self.camera.previous_jitter.map(f64::from));
        let middle = middle.clamp(DVec2::splat(-4.0), self.size() + 4.0).floor();
        let off = (-1..=1).flat_map(|j| (-1..=1).map(move |i| (i, j))).map(|(i, j)| {
            let found = distance_of(previous.texel(middle.x as i64 + i, middle.y as i64 + j)[0]);
            (found - expected.max(1e-3)).abs() / expected.max(1e-3).min(found)
        });
        let off = off.fold(1e9, f64::min);
        off < threshold || expected > 30000.0 && off < 2.0
    }
}

/// Light below a limit and the rest.
fn split(light: Rgb, limit: f64) -> [Rgb; 2] {
    let [r, g, b] = light;
    let share = (limit / (0.25 * r + 0.5 * g + 0.25 * b).max(1e-7)).min(1.0);
    [light.map(|x| share * x), light.map(|x| x - share * x)]
}

fn packed([r, g, b]: Rgb, white: f64) -> Rgb {
    let y = 0.25 * r + 0.5 * g + 0.25 * b;
    [y, 0.5 * (r - b), 0.5 * g - 0.25 * (r + b)].map(|x| x / (1.0 + y.max(0.0) / white))
}

fn unpacked(color: Rgb, white: f64) -> Rgb {
    let [y, orange, green] = color.map(|x| x / (1.0 - color[0].max(0.0) / white).max(1e-5));
    [y + orange - green, y + green, y - orange - green]
}

/// The Catmull-Rom spline through four numbers that are 1 apart, `x` behind the second.
fn spline(p: [f64; 4], x: f64) -> f64 {
    let slope = [0.5 * (p[2] - p[0]), 0.5 * (p[3] - p[1])];
    let (a, b) = (2.0 * (p[1] - p[2]) + slope[0] + slope[1], 3.0 * (p[2] - p[1]) - 2.0 * slope[0] - slope[1]);
    ((a * x + b) * x + slope[0]) * x + p[1]
}

fn bicubic(image: &Image, uv: DVec2) -> [f64; 4] {
    let size = DVec2::new(image.width as f64, image.height as f64);
    let place = (uv * size - 0.5).clamp(DVec2::splat(-2.0), size + 1.0);
    let (base, part) = (place.floor(), place - place.floor());
    [0, 1, 2, 3].map(|c| {
        let row = |j: i64| {
            let at = |i: i64| image.texel(base.x as i64 + i, base.y as i64 + j)[c];
            spline([-1, 0, 1, 2].map(at), part.x)
        };
        spline([-1, 0, 1, 2].map(row), part.y)
    })
}

/// The four texels around a place, each split, filtered linearly.
fn bilinear_split(image: &Image, uv: DVec2, ratio: f64, limit: f64) -> [Rgb; 2] {
    let place = (uv * DVec2::new(image.width as f64, image.height as f64) - 0.5).floor();
    let part = uv * DVec2::new(image.width as f64, image.height as f64) - 0.5 - place;
    let mut sums = [[0.0; 3]; 2];
    for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let [r, g, b, _] = image.texel(place.x as i64 + i, place.y as i64 + j);
        let weight = if i == 1 { part.x } else { 1.0 - part.x } * if j == 1 { part.y } else { 1.0 - part.y };
        let parts = split(extended([r, g, b].map(|x| x * ratio)), limit);
        (0..2).for_each(|k| (0..3).for_each(|c| sums[k][c] += weight * parts[k][c]));
    }
    sums
}

impl Taa {
    fn around(&self, frames: &Frames<'_>, [x, y]: [i64; 2]) -> Around {
        let jitter = frames.jitter();
        // What is as bright at three of the eight pixels at a distance of eight is wide, and no lamp.
        let is_bright = |(i, j): &(i64, i64)| {
            let [r, g, b, _] = frames.source.texel(x + 8 * i, y + 8 * j);
            (*i, *j) != (0, 0) && 0.25 * r + 0.5 * g + 0.25 * b > self.keep_above
        };
        let square = || (-1..=1).flat_map(|j| (-1..=1).map(move |i| (i, j)));
        let limit = if square().filter(is_bright).count() > 2 { 65504.0 } else { self.keep_above };
        let (mut nine, mut lamps, mut alphas) = (Vec::new(), Vec::new(), Vec::new());
        for (i, j) in square() {
            let [r, g, b, alpha] = frames.source.texel(x + i, y + j);
            let weight = (-2.29 * (DVec2::new(i as f64, j as f64) + jitter).length_squared()).exp();
            let [light, lamp] = split([r, g, b], limit);
            nine.push((packed(light, self.white), weight));
            lamps.push((lamp, weight));
            alphas.push((alpha, weight * self.weight(packed(light, self.white))));
        }
        let total: f64 = nine.iter().map(|(_, weight)| weight).sum();
        let mean = [0, 1, 2].map(|c| nine.iter().map(|(color, _)| color[c]).sum::<f64>() / 9.0);
        let square = |c: usize| nine.iter().map(|(color, _)| (color[c] - mean[c]).powi(2)).sum::<f64>() / 9.0;
        let color = [0, 1, 2].map(|c| nine.iter().map(|(color, weight)| color[c] * weight).sum::<f64>() / total);
        let most = |c: usize| self.variance * square(c).sqrt();
        let farthest =
            |c: usize, sign: f64| nine.iter().map(|(color, _)| sign * (color[c] - mean[c])).fold(0.0, f64::max);
        let [below, above] = [-1.0, 1.0].map(|sign| [0, 1, 2].map(|c| farthest(c, sign).min(most(c))));
        let lamps = Lamps {
            color: [0, 1, 2].map(|c| lamps.iter().map(|(lamp, weight)| lamp[c] * weight).sum::<f64>() / total),
            least: [0, 1, 2].map(|c| lamps.iter().map(|(lamp, _)| lamp[c]).fold(f64::INFINITY, f64::min)),
            greatest: [0, 1, 2].map(|c| lamps.iter().map(|(lamp, _)| lamp[c]).fold(f64::NEG_INFINITY, f64::max)),
        };
        let sum = |of: fn((f64, f64)) -> f64| alphas.iter().copied().map(of).sum::<f64>();
        let alpha = sum(|(alpha, weight)| alpha * weight) / sum(|(_, weight)| weight);
        let least = alphas.iter().map(|(alpha, _)| *alpha).fold(f64::INFINITY, f64::min);
        let greatest = alphas.iter().map(|(alpha, _)| *alpha).fold(f64::NEG_INFINITY, f64::max);
        Around { color, mean, below, above, lamps, alpha: [alpha, least, greatest] }
    }

    /// Weight of a packed color in means: that of light at `white` is one half.
    fn weight(&self, [y, ..]: Rgb) -> f64 {
        1.0 - y.max(0.0) / self.white
    }

    fn limited(&self, color: Rgb, around: &Around) -> Rgb {
        let away = [0, 1, 2].map(|c| color[c] - around.mean[c]);
        let room = |c: usize| if away[c] > 0.0 { around.above[c] } else { around.below[c] };
        let units = (0..3).map(|c| away[c].abs() / room(c).max(1e-6));
        let most = units.fold(1.0, f64::max);
        [0, 1, 2].map(|c| around.mean[c] + away[c] / most)
    }

    pub(crate) fn apply(&self, frames: &Frames<'_>) -> Image {
        Image::new(frames.source.width, frames.source.height, |x, y| {
            let pixel = [x as i64, y as i64];
            let around = self.around(frames, pixel);
            let uv = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / frames.size();
            let there = uv - frames.motion(frames.nearest(pixel));
            let is_inside = (0.0..=1.0).contains(&there.x) && (0.0..=1.0).contains(&there.y);
            let is_seen = is_inside && frames.was_seen(pixel, there, self.depth_threshold);
            let has_lamps = around.lamps.greatest.iter().any(|x| *x > 0.0);
            let old = frames.history.filter(|_| is_seen).map(|history| {
                let [light, lamps] = if has_lamps {
                    bilinear_split(history, there, frames.ratio, self.keep_above)
                } else {
                    let [r, g, b, _] = bicubic(history, there);
                    [extended([r, g, b].map(|x| x * frames.ratio)), [0.0; 3]]
                };
                let Lamps { least, greatest, .. } = around.lamps;
                let lamps = [0, 1, 2].map(|c| lamps[c].clamp(least[c], greatest[c]));
                [self.limited(packed(light, self.white), &around), lamps]
            });
            let place = there * frames.size() - 0.5;
            let part = place - place.floor();
            let softened = part.x * (1.0 - part.x) + part.y * (1.0 - part.y);
            let share = self.blend.max(2.0 * self.moving * softened);
            let new = [around.color, around.lamps.color];
            let [mixed, lamps] =
                old.map_or(new, |old| [0, 1].map(|k| [0, 1, 2].map(|c| mix(old[k][c], new[k][c], share))));
            let light = unpacked(mixed, self.white);
            let [r, g, b] = extended([0, 1, 2].map(|c| light[c] + lamps[c]));
            let [new_alpha, least, greatest] = around.alpha;
            let alpha = match (old, frames.history) {
                (Some([old, _]), Some(history)) => {
                    let weights = [(1.0 - share) * self.weight(old), share * self.weight(around.color)];
                    let old_alpha = bicubic(history, there)[3].clamp(least, greatest);
                    (weights[0] * old_alpha + weights[1] * new_alpha) / (weights[0] + weights[1])
                }
                _ => new_alpha,
            };
            [r, g, b, alpha]
        })
    }
}

#[test]
fn packing_is_undone_and_halves_white() {
    for light in [[0.1, 0.7, 0.3], [20.0, 3.0, 0.0], [-0.02, 0.4, 900.0]] {
        let again = unpacked(packed(light, 2.5), 2.5);
        assert!((0..3).all(|c| (again[c] - light[c]).abs() < 1e-9 * 900.0), "{light:?}, {again:?}");
    }
    assert_eq!(packed([4.0; 3], 4.0), [2.0, 0.0, 0.0]);
}

#[test]
fn the_spline_leads_through_its_points_and_is_exact_for_parabolas() {
    let square = |x: f64| 3.0 * x * x - x + 2.0;
    for x in [0.0, 0.25, 0.7, 1.0] {
        assert!((spline([-1.0, 0.0, 1.0, 2.0].map(square), x) - square(x)).abs() < 1e-12);
    }
}
