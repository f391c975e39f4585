//! Fog whose density falls exponentially with the height, by the closed form (Quilez, "Better Fog", 2010), and light of
//! the sun in it (Henyey and Greenstein, 1941).

use afterimage_graph::node::Camera;
use glam::{DMat4, DVec3};

use super::image::{Image, center_uv};
use super::math::{Rgb, dot};
use super::view::{View, distance_of};

/// The fog and the camera, in meters. Directions are in view space.
#[derive(Clone, Copy)]
pub(crate) struct Fog {
    pub(crate) density: f64,
    pub(crate) falloff: f64,
    pub(crate) level: f64,
    pub(crate) eye_height: f64,
    pub(crate) up: Rgb,
    pub(crate) start: f64,
    pub(crate) most: f64,
    pub(crate) color: Rgb,
    pub(crate) sun: Rgb,
    pub(crate) sun_color: Rgb,
    pub(crate) anisotropy: f64,
    /// The vertical field of view in degrees.
    pub(crate) fov: f64,
}

impl Fog {
    /// The optical depth up to a distance on a ray that begins at a height and rises by this much in a meter.
    pub(crate) fn optical_depth(&self, eye_height: f64, rise: f64, distance: f64) -> f64 {
        let way = (distance - self.start).max(0.0);
        let height = eye_height + rise * self.start - self.level;
        let x = self.falloff * rise * way;
        let mean = if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x };
        self.density * (-self.falloff * height).exp() * way * mean
    }

    fn phase(&self, cosine: f64) -> f64 {
        let g = self.anisotropy;
        (1.0 - g * g) / (1.0 + g * g - 2.0 * g * cosine).powf(1.5)
    }

    pub(crate) fn apply(&self, image: &Image, depth: &Image) -> Image {
        let (width, height) = (image.width, image.height);
        let tan = (0.5 * self.fov).to_radians().tan();
        Image::new(width, height, |x, y| {
            let [u, v] = center_uv(x, y, width, height);
            let ray = [(2.0 * u - 1.0) * width as f64 / height as f64 * tan, (1.0 - 2.0 * v) * tan, -1.0];
            let length = dot(ray, ray).sqrt();
            let direction = ray.map(|part| part / length);
            let distance = distance_of(depth.texel(x as i64, y as i64)[0]) * length;
            let optical = self.optical_depth(self.eye_height, dot(self.up, direction), distance);
            self.lit(image.texel(x as i64, y as i64), optical, direction)
        })
    }

    fn lit(&self, source: [f64; 4], optical: f64, direction: Rgb) -> [f64; 4] {
        let passed = (-optical).exp().max(1.0 - self.most);
        let phase = self.phase(dot(direction, self.sun));
        let lit = |c: usize| source[c] * passed + (self.color[c] + self.sun_color[c] * phase) * (1.0 - passed);
        [lit(0), lit(1), lit(2), source[3]]
    }

    /// With directions and heights of the world, which the camera stands in. For a perspective camera: its rays begin
    /// in one place.
    pub(crate) fn apply_in_world(&self, image: &Image, depth: &Image, camera: &Camera) -> Image {
        let view = View::new(camera, image);
        let to_world = DMat4::from_cols_array_2d(&camera.view.map(|column| column.map(f64::from))).inverse();
        let height = dot(self.up, to_world.transform_point3(DVec3::ZERO).to_array());
        Image::new(image.width, image.height, |x, y| {
            let place = view.place([x as f64, y as f64], distance_of(depth.texel(x as i64, y as i64)[0]));
            let direction = to_world.transform_vector3(place.normalize()).to_array();
            let optical = self.optical_depth(height, dot(self.up, direction), place.length());
            self.lit(image.texel(x as i64, y as i64), optical, direction)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOG: Fog = Fog {
        density: 0.05,
        falloff: 0.4,
        level: 1.0,
        eye_height: 2.5,
        up: [0.0, 1.0, 0.0],
        start: 3.0,
        most: 1.0,
        color: [0.5; 3],
        sun: [0.0, 0.0, -1.0],
        sun_color: [0.0; 3],
        anisotropy: 0.6,
        fov: 46.0,
    };

    #[test]
    fn the_closed_form_is_the_integral_along_the_ray() {
        for rise in [-0.7, -0.01, 0.0, 0.3] {
            let steps = 200_000;
            let step = 17.0 / f64::from(steps);
            let density = |way: f64| FOG.density * (-FOG.falloff * (2.5 + rise * (3.0 + way) - 1.0)).exp();
            let sum: f64 = (0..steps).map(|i| density((f64::from(i) + 0.5) * step) * step).sum();
            assert!((FOG.optical_depth(2.5, rise, 20.0) / sum - 1.0).abs() < 1e-8, "{rise}");
        }
    }

    #[test]
    fn the_phase_function_is_1_on_average() {
        let steps = 100_000;
        let cosine = |i: i32| (f64::from(i) + 0.5) / f64::from(steps) * 2.0 - 1.0;
        let mean: f64 = (0..steps).map(|i| FOG.phase(cosine(i))).sum::<f64>() / f64::from(steps);
        assert!((mean - 1.0).abs() < 1e-6, "{mean}");
    }
}
