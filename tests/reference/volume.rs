//! A froxel volume before a scene: Wronski, "Volumetric Fog", 2014.

use super::image::{Image, center_uv};
use super::view::distance_of;

/// Slices that lie one below the other, the nearest first.
pub(crate) struct Volume<'a> {
    pub(crate) all: &'a Image,
    pub(crate) depth: usize,
}

impl Volume<'_> {
    fn height(&self) -> usize {
        self.all.height / self.depth
    }

    /// A texel, or the nearest one.
    fn texel(&self, [x, y, z]: [i64; 3]) -> [f64; 4] {
        let inside = |at: i64, side: usize| at.clamp(0, side as i64 - 1) as usize;
        let row = inside(y, self.height()) + inside(z, self.depth) * self.height();
        self.all.pixels[inside(x, self.all.width) + row * self.all.width]
    }

    /// The trilinear mean at a place from 0 to 1 along each axis.
    fn at(&self, place: [f64; 3]) -> [f64; 4] {
        let sides = [self.all.width, self.height(), self.depth];
        let texels: [f64; 3] = std::array::from_fn(|axis| place[axis] * sides[axis] as f64 - 0.5);
        let mut sum = [0.0; 4];
        for corner in 0..8_i64 {
            let step = [corner & 1, corner >> 1 & 1, corner >> 2];
            let weight: f64 =
                (0..3).map(|axis| 1.0 - (texels[axis] - texels[axis].floor() - step[axis] as f64).abs()).product();
            let texel = self.texel(std::array::from_fn(|axis| texels[axis].floor() as i64 + step[axis]));
            (0..4).for_each(|channel| sum[channel] += weight * texel[channel]);
        }
        sum
    }
}

/// The placement of a volume before the scene, in meters.
#[derive(Clone, Copy)]
pub(crate) struct Composite {
    pub(crate) near: f64,
    pub(crate) far: f64,
    /// 0 is linear, the logarithm of far / near exponential.
    pub(crate) curve: f64,
    /// True if a texel belongs to the end of its slice; else to its middle.
    pub(crate) is_end: bool,
    pub(crate) light: f64,
    pub(crate) amount: f64,
}

impl Composite {
    /// The relative place of a distance between `near` and `far`: from 0 to 1.
    pub(crate) fn along(&self, distance: f64) -> f64 {
        let linear = ((distance - self.near) / (self.far - self.near)).clamp(0.0, 1.0);
        if self.curve == 0.0 { linear } else { (linear * self.curve.exp_m1()).ln_1p() / self.curve }
    }

    /// The distance at a place between both.
    pub(crate) fn distance(&self, along: f64) -> f64 {
        let bent = if self.curve == 0.0 { along } else { (along * self.curve).exp_m1() / self.curve.exp_m1() };
        self.near + (self.far - self.near) * bent
    }

    /// Scattered light and the share that passes, up to a distance at a place of the picture.
    pub(crate) fn fog(&self, volume: &Volume<'_>, [u, v]: [f64; 2], distance: f64) -> [f64; 4] {
        let (slices, first) = (volume.depth as f64, if self.is_end { 1.0 } else { 0.5 });
        let slice = self.along(distance) * slices;
        let [r, g, b, passed] = volume.at([u, v, (slice - first + 0.5) / slices]);
        let share = (slice / first).min(1.0);
        [share * r, share * g, share * b, 1.0 - share * (1.0 - passed.clamp(0.0, 1.0))]
    }

    pub(crate) fn apply(&self, source: &Image, depth: &Image, volume: &Volume<'_>) -> Image {
        let (width, height) = (source.width, source.height);
        Image::new(width, height, |x, y| {
            let distance = distance_of(depth.texel(x as i64, y as i64)[0]);
            let fog = self.fog(volume, center_uv(x, y, width, height), distance);
            let light = source.texel(x as i64, y as i64);
            let passed = 1.0 - self.amount * (1.0 - fog[3]);
            let [r, g, b] = [0, 1, 2].map(|c| light[c] * passed + self.amount * self.light * fog[c]);
            [r, g, b, light[3]]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOG: Composite = Composite { near: 0.5, far: 64.0, curve: 0.0, is_end: true, light: 1.0, amount: 1.0 };
    /// Optical depth of a meter, and the light that the fog would have if it were infinitely thick.
    const DENSITY: f64 = 0.04;
    const GLOW: f64 = 3.0;

    fn curved(curve: f64, is_end: bool) -> Composite {
        Composite { curve, is_end, ..FOG }
    }

    /// A volume of uniform fog that begins at `near`, whose texels hold the integral to their distances.
    fn uniform(composite: &Composite, depth: usize) -> Image {
        let first = if composite.is_end { 1.0 } else { 0.5 };
        Image::new(2, 2 * depth, |_, row| {
            let way = composite.distance(((row / 2) as f64 + first) / depth as f64) - composite.near;
            let passed = (-DENSITY * way).exp();
            [GLOW * (1.0 - passed), 0.0, 1.0, passed]
        })
    }

    #[test]
    fn the_exponential_curve_is_the_one_whose_slices_grow_by_a_factor() {
        let fog = curved((64.0_f64 / 0.5).ln(), true);
        for along in [0.0, 0.1, 0.5, 0.9, 1.0] {
            let wanted = 0.5 * 128.0_f64.powf(along);
            assert!((fog.distance(along) / wanted - 1.0).abs() < 1e-12, "{along}");
            assert!((fog.along(wanted) - along).abs() < 1e-12, "{along}");
        }
        // Half way on a logarithmic scale.
        assert!((fog.along(8.0_f64.sqrt() * 2.0) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn uniform_fog_is_its_closed_form_within_the_error_of_the_filter() {
        for composite in [curved(0.0, true), curved(0.0, false), curved(128.0_f64.ln(), true), curved(3.0, false)] {
            let image = uniform(&composite, 64);
            let volume = Volume { all: &image, depth: 64 };
            for distance in [0.0, 0.3, 0.6, 1.0, 3.7, 20.0, 50.0] {
                let passed = (-DENSITY * (distance - composite.near).max(0.0)).exp();
                let found = composite.fog(&volume, [0.3, 0.8], distance);
                // The curvature of the exponential, and that of the distances along the slices.
                let along = composite.along(distance);
                let [a, b, c] = [0.0, 1.0, 2.0].map(|slice| composite.distance(along + slice / 64.0));
                let allowed = (DENSITY * (b - a)).powi(2) / 7.0 + DENSITY * (c - 2.0 * b + a) / 7.0 + 1e-12;
                assert!((found[3] - passed).abs() <= allowed, "{distance}: {found:?} instead of {passed}");
                assert!((found[0] - GLOW * (1.0 - passed)).abs() <= GLOW * allowed, "{distance}: {found:?}");
            }
            // The sky has what the whole volume has.
            let last = volume.texel([0, 0, 63]);
            let sky = composite.fog(&volume, [0.5, 0.5], f64::INFINITY);
            assert!((0..4).all(|channel| (sky[channel] - last[channel]).abs() < 1e-12), "{sky:?} instead of {last:?}");
            assert_eq!(composite.fog(&volume, [0.5, 0.5], 0.0), [0.0, 0.0, 0.0, 1.0]);
        }
    }

    /// The largest error of the share that passes, of uniform fog from `near` to the last texel.
    fn worst(composite: &Composite, depth: usize) -> f64 {
        let image = uniform(composite, depth);
        let volume = Volume { all: &image, depth };
        let first = if composite.is_end { 1.0 } else { 0.5 };
        let longest = composite.distance(1.0 - (1.0 - first) / depth as f64) - composite.near;
        let errors = (0..=6350).map(|step| {
            let way = longest * f64::from(step) / 6350.0;
            let found = composite.fog(&volume, [0.5, 0.5], composite.near + way)[3];
            (found - (-DENSITY * way).exp()).abs()
        });
        errors.fold(0.0, f64::max)
    }

    #[test]
    #[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/depth.md")]
    fn twice_the_slices_have_a_quarter_of_the_error() {
        for (name, curve) in [("exponential", 128.0_f64.ln()), ("linear", 0.0), ("curved 3", 3.0)] {
            for is_end in [true, false] {
                let found = [16, 32, 64, 128].map(|depth| worst(&curved(curve, is_end), depth));
                println!("{name}, {}: {found:.5?}", if is_end { "end" } else { "middle" });
                for pair in found.windows(2).skip(1) {
                    assert!((3.5..4.3).contains(&(pair[0] / pair[1])), "{name}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn one_texel_is_a_ramp_to_its_distance() {
        let image = Image::new(1, 1, |_, _| [2.0, 1.0, 0.0, 0.25]);
        let volume = Volume { all: &image, depth: 1 };
        let fog = Composite { near: 1.0, far: 5.0, ..FOG };
        assert_eq!(fog.fog(&volume, [0.1, 0.9], 2.0), [0.5, 0.25, 0.0, 0.8125]);
        assert_eq!(fog.fog(&volume, [0.1, 0.9], 5.0), [2.0, 1.0, 0.0, 0.25]);
        let middle = Composite { is_end: false, ..fog };
        assert_eq!(middle.fog(&volume, [0.1, 0.9], 2.0), [1.0, 0.5, 0.0, 0.625]);
        assert_eq!(middle.fog(&volume, [0.1, 0.9], 3.0), [2.0, 1.0, 0.0, 0.25]);
    }
}
