//! Depth of field and motion blur by gathering: after Jimenez (2014), and after McGuire and others (2012) with shares of
//! the time as weights.

use std::f64::consts::PI;

use super::image::Image;
use super::math::mix;
use super::view::distance_of;

/// Surfaces whose depths differ by less than this share belong together.
const SOFT: f64 = 0.05;

#[derive(Clone, Copy)]
pub(crate) struct DepthOfField {
    /// The distance of the focus in meters.
    pub(crate) focus: f64,
    pub(crate) f_stop: f64,
    /// In millimeters.
    pub(crate) focal_length: f64,
    /// The height of the sensor in millimeters.
    pub(crate) sensor: f64,
    /// The largest radius in pixels.
    pub(crate) most: f64,
    pub(crate) rings: usize,
    pub(crate) blades: usize,
    /// Radians.
    pub(crate) rotation: f64,
}

impl DepthOfField {
    /// The radius of the circle of confusion in pixels.
    pub(crate) fn radius(&self, depth: f64, height: f64) -> f64 {
        let focus = 1000.0 * self.focus;
        let diameter = self.focal_length.powi(2) / self.f_stop / (focus - self.focal_length);
        let on_sensor = diameter * (depth - self.focus).abs() / depth.max(1e-3);
        (0.5 * on_sensor / self.sensor * height).min(self.most)
    }

    /// The radius that is gathered with: reading whole pixels and softening the edge of the circle add the variance of
    /// a pixel.
    fn gathered(&self, depth: f64, height: f64) -> f64 {
        (self.radius(depth, height).powi(2) - 1.0 / 6.0).max(0.0).sqrt()
    }

    /// The radius and the depth of a pixel: those of the sharpest surface well in front of it among its four neighbors,
    /// if it is sharper, or of the nearest blurred one before a pixel in focus.
    fn circle(&self, depth: &Image, [x, y]: [i64; 2], image: &Image) -> [f64; 4] {
        let surface = |[x, y]: [i64; 2]| {
            let z = distance_of(depth.texel(x, y)[0]);
            [self.gathered(z, image.height as f64), z]
        };
        let own = surface([x, y]);
        let is_sharp = own[0] < 0.5;
        let fronts = beside([x, y]).map(surface).into_iter().filter(|[_, z]| *z < (1.0 - SOFT) * own[1]);
        let front = if is_sharp {
            fronts.filter(|[radius, _]| *radius >= 2.0).min_by(|a, b| a[1].total_cmp(&b[1]))
        } else {
            fronts.filter(|[radius, _]| *radius < own[0]).min_by(|a, b| a[0].total_cmp(&b[0]))
        };
        let [radius, z] = front.unwrap_or(own);
        [radius, z, 0.0, 1.0]
    }

    fn edge(&self, angle: f64) -> f64 {
        if self.blades < 3 {
            return 1.0;
        }
        let side = 2.0 * PI / self.blades as f64;
        let within = (angle + self.rotation).rem_euclid(side);
        (0.5 * side).cos() / (within - 0.5 * side).cos()
    }

    /// The radius of a ring: rings are nearer to each other in the middle.
    fn ring(&self, ring: f64, reach: f64) -> f64 {
        reach * (ring / self.rings as f64).powf(1.5)
    }

    /// Offset, distance in a round aperture, and area of each sample, the pixel itself first.
    fn samples(&self, reach: f64) -> Vec<([f64; 2], f64, f64)> {
        let middle = ([0.0, 0.0], 0.0, PI * self.ring(0.5, reach).powi(2));
        let ring = |ring: usize| {
            let [inside, distance, outside] = [-0.5, 0.0, 0.5].map(|off| self.ring(ring as f64 + off, reach));
            let area = PI * (outside.powi(2) - inside.powi(2)) / (6 * ring) as f64;
            (0..6 * ring).map(move |i| {
                let angle = 2.0 * PI * (i as f64 + 0.5 * (ring % 2) as f64) / (6 * ring) as f64;
                let along = distance * self.edge(angle);
                ([along * angle.cos(), along * angle.sin()], distance, area)
            })
        };
        std::iter::once(middle).chain((1..=self.rings).flat_map(ring)).collect()
    }

    pub(crate) fn apply(&self, image: &Image, depth: &Image) -> Image {
        let circles = Image::new(image.width, image.height, |x, y| self.circle(depth, [x as i64, y as i64], image));
        let tile = (self.most.ceil() as usize + 1).max(8);
        Image::new(image.width, image.height, |x, y| {
            let reach = tile_most(&circles, [x, y], tile);
            if reach < 0.5 {
                return image.texel(x as i64, y as i64);
            }
            self.gather(image, &circles, [x, y], reach)
        })
    }

    fn gather(&self, image: &Image, circles: &Image, [x, y]: [usize; 2], reach: f64) -> [f64; 4] {
        let [own, own_depth, ..] = circles.texel(x as i64, y as i64);
        let (mut layers, mut weights) = ([[0.0; 4]; 2], [0.0; 2]);
        let mut add = |color: [f64; 4], [radius, depth, ..]: [f64; 4], distance: f64, area: f64| {
            let apart = ((depth - own_depth) / (SOFT * own_depth)).clamp(-1.0, 1.0);
            let covers = |radius: f64| (radius - distance + 0.5).clamp(0.0, 1.0) / (PI * radius * radius).max(1.0);
            let before = (-apart).max(0.0);
            // Past the own surface, what is behind is seen through the own circle.
            let far = mix(covers(radius.min(own)), covers(own), apart.max(0.0));
            for (layer, weight) in [area * before * covers(radius), area * (1.0 - before) * far].iter().enumerate() {
                (0..4).for_each(|c| layers[layer][c] += weight * color[c]);
                weights[layer] += weight;
            }
        };
        for ([dx, dy], distance, area) in self.samples(reach) {
            let place = [x as i64 + dx.round_ties_even() as i64, y as i64 + dy.round_ties_even() as i64];
            let color = image.texel(place[0], place[1]);
            add(color, circles.texel(place[0], place[1]), distance, area);
        }
        let [before, behind] = layers;
        let cover = weights[0].clamp(0.0, 1.0);
        [0, 1, 2, 3].map(|c| mix(behind[c] / weights[1].max(1e-6), before[c] / weights[0].max(1e-6), cover))
    }
}

/// The pixels beside a pixel.
fn beside([x, y]: [i64; 2]) -> [[i64; 2]; 4] {
    [[x - 1, y], [x + 1, y], [x, y - 1], [x, y + 1]]
}

/// The largest red of the nine tiles around a pixel.
fn tile_most(image: &Image, [x, y]: [usize; 2], tile: usize) -> f64 {
    let mut most = 0.0_f64;
    for_tiles(image, [x, y], tile, |pixel| most = most.max(pixel[0]));
    most
}

/// Calls `f` for each pixel of the nine tiles around a pixel, row by row of each tile. Tiles beyond the border are
/// those at it.
fn for_tiles(image: &Image, [x, y]: [usize; 2], tile: usize, mut f: impl FnMut([f64; 4])) {
    let last = [(image.width - 1) / tile, (image.height - 1) / tile];
    let near = |at: usize, last: usize| [-1, 0, 1].map(|i| (at as i64 + i).clamp(0, last as i64) as usize);
    for j in near(y / tile, last[1]) {
        for i in near(x / tile, last[0]) {
            for at in 0..tile * tile {
                f(image.texel((i * tile + at % tile) as i64, (j * tile + at / tile) as i64));
            }
        }
    }
}

/// Motion blur with this many samples along half paths of at most `most` pixels.
#[derive(Clone, Copy)]
pub(crate) struct MotionBlur {
    pub(crate) samples: usize,
    pub(crate) most: f64,
    /// True if the paths are those of an image, and not of a camera alone.
    pub(crate) objects: bool,
}

impl MotionBlur {
    /// `paths` holds half of each pixel's path in pixels, and its depth, NaN where it is unknown; `shift` is the random
    /// number of a pixel, from -0.5 to 0.5.
    pub(crate) fn apply(&self, image: &Image, paths: &Image, shift: impl Fn(usize, usize) -> f64) -> Image {
        let paths = paths.map(|[x, y, z, _]| {
            let limit = (self.most / x.hypot(y).max(1e-6)).min(1.0);
            let nearness = 1.0 / (1.0 + limit * x.hypot(y));
            [x * limit, y * limit, if z.is_nan() { nearness } else { distance_of(z) }, 1.0]
        });
        // A pixel beside a surface well in front of it moves with that, if it moves in another way.
        let paths = Image::new(image.width, image.height, |x, y| {
            let own = paths.texel(x as i64, y as i64);
            let around = beside([x as i64, y as i64]).map(|[i, j]| paths.texel(i, j));
            let fronts = around.into_iter().filter(|other| self.objects && other[2] < (1.0 - SOFT) * own[2]);
            let front = fronts.fold(own, |front, other| if other[2] < front[2] { other } else { front });
            if (front[0] - own[0]).hypot(front[1] - own[1]) >= 1.0 { front } else { own }
        });
        let tile = (self.most.ceil() as usize + 1).max(8);
        Image::new(image.width, image.height, |x, y| {
            let mut longest = [0.0_f64; 2];
            for_tiles(&paths, [x, y], tile, |[i, j, ..]| {
                if i.hypot(j) > longest[0].hypot(longest[1]) {
                    longest = [i, j];
                }
            });
            let center = image.texel(x as i64, y as i64);
            if longest[0].hypot(longest[1]) < 0.5 {
                return center;
            }
            self.gather((image, &paths), [x, y], longest, shift(x, y))
        })
    }

    fn gather(&self, (image, paths): (&Image, &Image), [x, y]: [usize; 2], longest: [f64; 2], shift: f64) -> [f64; 4] {
        let (x, y) = (x as i64, y as i64);
        let (center, own) = (image.texel(x, y), paths.texel(x, y));
        let count = self.samples.div_ceil(2);
        // Color, path and depth, distance, and how many pixels it stands for.
        let samples = |path: [f64; 2]| {
            let length = path[0].hypot(path[1]);
            (0..count).map(move |i| {
                let t = (length + 0.5) * (2.0 * (i as f64 + 0.5 + shift) / count as f64 - 1.0);
                let offset = path.map(|part| (part / length * t).round_ties_even());
                let place = [x + offset[0] as i64, y + offset[1] as i64];
                let along = |v: [f64; 2]| ((v[0] * path[0] + v[1] * path[1]) / length).abs();
                let other = paths.texel(place[0], place[1]);
                let seen = cover(along([other[0], other[1]]), along(offset));
                let step = 2.0 * (length + 0.5) / count as f64;
                (image.texel(place[0], place[1]), other[2], step * seen, step * cover(length, along(offset)))
            })
        };
        let mut light = center;
        if own[0].hypot(own[1]) >= 0.5 {
            let (mut same, mut behind) = (Layer::default(), Layer::default());
            same.add(center, 1e-3 * 2.0 * (own[0].hypot(own[1]) + 0.5) / count as f64);
            for (color, depth, seen, own_seen) in samples([own[0], own[1]]) {
                let (before, after) = (before(depth, own[2]), before(own[2], depth));
                same.add(color, (1.0 - before - after) * seen);
                behind.add(color, after * own_seen);
            }
            let seen = same.mean().expect("the pixel itself is there");
            light = same.over(behind.mean().unwrap_or(seen));
        }
        let mut front = Layer::default();
        for (color, depth, seen, _) in samples(longest) {
            front.add(color, before(depth, own[2]) * seen);
        }
        front.over(light)
    }
}

/// Light with its alpha, and for how much of the time it is seen.
#[derive(Default)]
struct Layer {
    sum: [f64; 4],
    cover: f64,
}

impl Layer {
    fn add(&mut self, color: [f64; 4], cover: f64) {
        self.sum = [0, 1, 2, 3].map(|c| self.sum[c] + cover * color[c]);
        self.cover += cover;
    }

    fn mean(&self) -> Option<[f64; 4]> {
        (self.cover > 1e-6).then(|| self.sum.map(|sum| sum / self.cover))
    }

    fn over(&self, under: [f64; 4]) -> [f64; 4] {
        let Some(mean) = self.mean() else { return under };
        [0, 1, 2, 3].map(|c| mix(under[c], mean[c], self.cover.min(1.0)))
    }
}

/// 1 if the first depth is well before the second, 0 if it is not before it.
fn before(first: f64, second: f64) -> f64 {
    ((second - first) / (SOFT * first.min(second))).clamp(0.0, 1.0)
}

/// The share of the time in which what moves half a path of this length is seen at a pixel this far away.
fn cover(path: f64, distance: f64) -> f64 {
    let half = path.max(0.5);
    (half + 0.5 - distance).clamp(0.0, 1.0) / (2.0 * half)
}

#[test]
fn a_circle_of_confusion_is_that_of_a_lens() {
    let lens = DepthOfField {
        focus: 2.0,
        f_stop: 2.0,
        focal_length: 50.0,
        sensor: 24.0,
        most: 1e9,
        rings: 4,
        blades: 0,
        rotation: 0.0,
    };
    // By the thin lens: the image of 4 m lies at 1 / (1/50 - 1/4000) mm, the sensor at 1 / (1/50 - 1/2000) mm.
    let image = |distance: f64| 1.0 / (1.0 / 50.0 - 1.0 / distance);
    let diameter = 25.0 * (image(2000.0) - image(4000.0)).abs() / image(4000.0);
    assert!((lens.radius(4.0, 1080.0) - 0.5 * diameter / 24.0 * 1080.0).abs() < 1e-9);
}
