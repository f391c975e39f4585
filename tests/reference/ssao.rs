//! Ambient occlusion by points in a hemisphere.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

use super::gtao::{Surfaces, smoothed};
use super::image::Image;
use super::math::smooth_step;

/// The points of a hemisphere over z.
pub(crate) fn kernel(count: usize) -> Vec<DVec3> {
    let point = |index: usize| {
        let height = 0.05 + 0.95 * f64::from((index as u32).reverse_bits()) / 2_f64.powi(32);
        let angle = TAU * (0.6180339887498949 * index as f64).fract();
        let aside = (1.0 - height * height).sqrt();
        let scale = 0.1 + 0.9 * (index as f64 / count as f64).powi(2);
        scale * DVec3::new(aside * angle.cos(), aside * angle.sin(), height)
    };
    (0..count).map(point).collect()
}

/// The share of a point at z that is hidden by what is seen at `found`, from a pixel at `own`.
fn hidden(z: f64, found: f64, own: f64, radius: f64, bias: f64) -> f64 {
    let near = smooth_step(0.0, 1.0, radius / (own - found).abs().max(1e-4));
    if found >= z + bias { near } else { 0.0 }
}

/// The visibility of a pixel at `own` that faces the camera, where all of the depth image shows `plane`.
pub(crate) fn before_plane(own: f64, plane: f64, radius: f64, bias: f64) -> f64 {
    let points = kernel(16);
    let hidden = points.iter().map(|point| hidden(own + radius * point.z, plane, own, radius, bias));
    1.0 - hidden.sum::<f64>() / points.len() as f64
}

/// The search of a pixel.
#[derive(Clone, Copy)]
pub(crate) struct Ssao {
    pub(crate) radius: f64,
    pub(crate) bias: f64,
    pub(crate) samples: usize,
    pub(crate) is_half: bool,
    pub(crate) denoise: usize,
}

/// Two directions across a unit vector, and the vector: Duff and others, 2017.
fn frame(n: DVec3) -> DMat3 {
    let sign = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    DMat3::from_cols(
        DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        DVec3::new(b, sign + n.y * n.y * a, -n.y),
        n,
    )
}

impl Ssao {
    fn visible(&self, surfaces: Surfaces<'_>, pixel: [i64; 2], [x, y]: [usize; 2], normal: DVec3) -> f64 {
        let turn = (((x + y) & 3) * 4 + (x & 3)) as f64 / 16.0;
        let (place, frame) = (surfaces.place(pixel), frame(normal) * DMat3::from_rotation_z(TAU * turn));
        let shares = kernel(self.samples).into_iter().filter_map(|point| {
            let there = place + self.radius * (frame * point);
            let seen = surfaces.view.pixel_of(there).filter(|_| there.z < 0.0)?;
            let found = surfaces.place(seen);
            let is_above = normal.dot(found - place) >= self.radius * point.z;
            let is_before = is_above || normal.dot(surfaces.toward(found)) <= 0.0;
            Some(if is_before { hidden(there.z, found.z, place.z, self.radius, self.bias) } else { 0.0 })
        });
        let shares: Vec<f64> = shares.collect();
        1.0 - shares.iter().sum::<f64>() / shares.len().max(1) as f64
    }

    /// Visibilities and inverse distances, by normals that `normal` gives for a pixel.
    pub(crate) fn visibility(&self, surfaces: Surfaces<'_>, normal: impl Fn([i64; 2]) -> DVec3) -> Image {
        smoothed(surfaces, (self.is_half, self.denoise), |pixel, texel| {
            self.visible(surfaces, pixel, texel, normal(pixel))
        })
    }
}

#[test]
fn points_are_within_the_hemisphere_and_denser_near_the_pixel() {
    for count in [8, 16, 64] {
        let points = kernel(count);
        assert!(points.iter().all(|point| point.z > 0.0 && (0.1..1.0).contains(&point.length())));
        let near = points.iter().filter(|point| point.length() < 0.5).count();
        assert!(2 * near > count, "{near} of {count}");
    }
    let frame = frame(DVec3::new(0.3, -0.5, -0.8).normalize());
    assert!((frame.determinant() - 1.0).abs() < 1e-12);
    assert!((frame.transpose() * frame).abs_diff_eq(DMat3::IDENTITY, 1e-12));
}
