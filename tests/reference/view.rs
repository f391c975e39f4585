//! The view of a camera, in f64: places in its space, which looks along -z with y upwards, and depths.

use afterimage_graph::node::{Camera, Matrix};
use glam::{DMat4, DVec2, DVec3, DVec4, Vec4Swizzles as _};

use super::image::Image;

/// The distance that a number of a depth image stands for. Nothing is at 0 or behind the camera: that is as far as it
/// goes.
pub(crate) fn distance_of(number: f64) -> f64 {
    if number > 0.0 { number.clamp(1e-3, 65504.0) } else { 65504.0 }
}

/// A camera and the size of its image.
#[derive(Clone, Copy)]
pub(crate) struct View {
    pub(crate) projection: DMat4,
    pub(crate) size: [usize; 2],
}

pub(super) fn wide(matrix: Matrix) -> DMat4 {
    DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)))
}

impl View {
    pub(crate) fn new(camera: &Camera, image: &Image) -> Self {
        let size = [image.width, image.height];
        Self { projection: wide(camera.projection), size }
    }

    /// From -1 to 1 in both directions, y upwards, at the middle of a pixel.
    fn clip(&self, [x, y]: [f64; 2]) -> DVec2 {
        let [width, height] = self.size.map(|side| side as f64);
        DVec2::new(2.0 * (x + 0.5) / width - 1.0, 1.0 - 2.0 * (y + 0.5) / height)
    }

    /// The distance along the axis of what a pixel shows at this depth of the projection.
    pub(crate) fn distance(&self, pixel: [f64; 2], depth: f64) -> f64 {
        let clip = self.clip(pixel);
        let place = self.projection.inverse() * DVec4::new(clip.x, clip.y, depth, 1.0);
        distance_of(-place.z / place.w.max(1e-7))
    }

    /// The place in the camera's space of what a pixel shows at this distance along the axis: where the ray through
    /// the pixel, from two depths of it, has this distance.
    pub(crate) fn place(&self, pixel: [f64; 2], distance: f64) -> DVec3 {
        let clip = self.clip(pixel);
        let inverse = self.projection.inverse();
        let at = |depth: f64| {
            let place = inverse * DVec4::new(clip.x, clip.y, depth, 1.0);
            place.xyz() / place.w
        };
        let (a, b) = (at(0.75), at(0.25));
        a + (b - a) * ((-distance - a.z) / (b.z - a.z))
    }

    /// The pixel that shows a place in the camera's space, if one does.
    pub(crate) fn pixel_of(&self, place: DVec3) -> Option<[i64; 2]> {
        let clip = self.projection * place.extend(1.0);
        let [width, height] = self.size.map(|side| side as f64);
        let x = (0.5 + 0.5 * clip.x / clip.w) * width;
        let y = (0.5 - 0.5 * clip.y / clip.w) * height;
        let is_inside = (0.0..width).contains(&x) && (0.0..height).contains(&y);
        is_inside.then_some([x.floor() as i64, y.floor() as i64])
    }

    /// How far in pixels two places lie from each other that are `apart` in the camera's x and y, y downwards.
    pub(crate) fn pixels_apart(&self, apart: DVec2, distance: f64) -> DVec2 {
        let of = |x: f64, y: f64| {
            let clip = self.projection * DVec4::new(x, y, -distance, 1.0);
            clip.xy() / clip.w
        };
        let clip = of(apart.x, apart.y) - of(0.0, 0.0);
        let [width, height] = self.size.map(|side| side as f64);
        DVec2::new(0.5 * width, -0.5 * height) * clip
    }
}
