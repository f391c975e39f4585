//! Shadows from the depth map of a light, by percentage-closer filtering.

use std::f64::consts::TAU;

use afterimage_graph::node::Camera;
use glam::{DMat4, DVec2, DVec3, DVec4, Vec4Swizzles as _};

use super::gtao::Surfaces;
use super::image::Image;
use super::view::{View, wide};

/// Surfaces that the light grazes at a smaller cosine have the bias of this one.
const GRAZING: f64 = 0.05;

/// The parameters of a shadow.
#[derive(Clone, Copy)]
pub(crate) struct Shadow {
    pub(crate) kernel: usize,
    /// Taps on a disc instead of a square.
    pub(crate) disc: Option<usize>,
    pub(crate) bias: f64,
    pub(crate) slope_bias: f64,
    pub(crate) normal_bias: f64,
}

/// A depth map, and the camera that it was drawn with.
#[derive(Clone, Copy)]
pub(crate) struct Lamp<'a> {
    view: View,
    to_light: DMat4,
    map: &'a Image,
}

impl<'a> Lamp<'a> {
    pub(crate) fn new(camera: &Camera, map: &'a Image) -> Self {
        Self { view: View::new(camera, map), to_light: wide(camera.view), map }
    }

    /// Whether a texel lies before a distance.
    fn is_before(&self, [x, y]: [i64; 2], distance: f64) -> bool {
        let (width, height) = (self.map.width as i64, self.map.height as i64);
        let is_inside = (0..width).contains(&x) && (0..height).contains(&y);
        is_inside && self.view.distance([x as f64, y as f64], self.map.texel(x, y)[0]) < distance
    }

    /// The mean of taps on a square, each filtered linearly.
    fn square(&self, at: DVec2, distance: f64, kernel: usize) -> f64 {
        let offset = |i: usize| i as f64 - 0.5 * (kernel as f64 - 1.0);
        let tap = |at: DVec2| {
            let (base, part) = (at.floor(), at - at.floor());
            let one = |i: i64, j: i64| {
                let share = (if i == 0 { 1.0 - part.x } else { part.x }) * (if j == 0 { 1.0 - part.y } else { part.y });
                if self.is_before([base.x as i64 + i, base.y as i64 + j], distance) { share } else { 0.0 }
            };
            one(0, 0) + one(1, 0) + one(0, 1) + one(1, 1)
        };
        let places = (0..kernel * kernel).map(|i| at + DVec2::new(offset(i % kernel), offset(i / kernel)));
        places.map(tap).sum::<f64>() / (kernel * kernel) as f64
    }
}

impl Shadow {
    fn filtered(&self, lamp: &Lamp<'_>, at: DVec2, distance: f64, [x, y]: [i64; 2]) -> f64 {
        let Some(taps) = self.disc else { return lamp.square(at, distance, self.kernel) };
        let turn = (((x + y) & 3) * 4 + (x & 3)) as f64 / 16.0;
        let one = |i: usize| {
            let angle = TAU * turn + 2.3999632 * i as f64;
            let way = 0.5 * self.kernel as f64 * ((i as f64 + 0.5) / taps as f64).sqrt();
            lamp.square(at + way * DVec2::new(angle.cos(), angle.sin()), distance, 1)
        };
        (0..taps).map(one).sum::<f64>() / taps as f64
    }

    /// The share of the light that is blocked in a pixel of the eye's image, for a normal in the eye's space.
    pub(crate) fn share(
        &self,
        (eye, surfaces): (&Camera, Surfaces<'_>),
        lamp: &Lamp<'_>,
        pixel: [i64; 2],
        normal: DVec3,
    ) -> f64 {
        let from_eye = lamp.to_light * wide(eye.view).inverse();
        let place = (from_eye * surfaces.place(pixel).extend(1.0)).xyz();
        let n = (from_eye * normal.extend(0.0)).xyz();
        let is_perspective = lamp.view.projection.z_axis.w != 0.0;
        let towards = if is_perspective { (-place).normalize() } else { DVec3::Z };
        let facing = n.dot(towards);
        if facing <= 0.0 {
            return 1.0;
        }
        let width = 1.0 / lamp.view.pixels_apart(DVec2::X, -place.z).length();
        let moved = place + n * self.normal_bias * width * (1.0 - facing * facing).max(0.0).sqrt();
        let clip = lamp.view.projection * moved.extend(1.0);
        let clip = clip / clip.w;
        if moved.z >= 0.0 || clip.xy().abs().max_element() > 1.0 {
            return 0.0;
        }
        let size = DVec2::new(lamp.map.width as f64, lamp.map.height as f64);
        let at = DVec2::new(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y) * size - 0.5;
        let filtered = if self.disc.is_some() { 1.0 } else { 0.5 };
        let reach = (0.5 * self.kernel as f64 + filtered) * width;
        let slope = (n.x.abs() + n.y.abs()) * towards.z.max(0.0) / facing.max(GRAZING);
        self.filtered(lamp, at, -moved.z - self.bias - self.slope_bias * reach * slope, pixel)
    }
}

/// A perspective projection to depths from 0 to 1: columns.
pub(crate) fn perspective(fov: f64, aspect: f64, near: f64, far: f64) -> DMat4 {
    let t = 1.0 / (0.5 * fov).tan();
    let depth = DVec4::new(0.0, 0.0, far / (near - far), -1.0);
    DMat4::from_cols(t / aspect * DVec4::X, t * DVec4::Y, depth, near * far / (near - far) * DVec4::Z)
}

/// A view from a place to another: columns.
pub(crate) fn look_at(eye: DVec3, there: DVec3, up: DVec3) -> DMat4 {
    let back = (eye - there).normalize();
    let right = up.cross(back).normalize();
    let up = back.cross(right);
    DMat4::from_cols(right.extend(0.0), up.extend(0.0), back.extend(0.0), eye.extend(1.0)).inverse()
}

/// Where a projection shows a place: uv from the upper left, and depth.
pub(crate) fn shown_at(light: DMat4, place: DVec3) -> [f64; 3] {
    let clip = light * place.extend(1.0);
    let clip = clip / clip.w;
    [0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y, clip.z]
}

/// The share of these depths that a depth is not behind of. A depth beyond the far plane is lit.
pub(crate) fn lit_share(depth: f64, bias: f64, map: &[f64]) -> f64 {
    let lit = map.iter().filter(|found| depth > 1.0 || depth - bias <= **found).count();
    lit as f64 / map.len() as f64
}

/// The position along the axis, which is negative, of a depth.
pub(crate) fn position_of_depth(depth: f64, near: f64, far: f64, is_reversed: bool) -> f64 {
    let depth = if is_reversed { 1.0 - depth } else { depth };
    -near * far / (far - depth * (far - near))
}

/// The depth of a position along the axis.
pub(crate) fn depth_of_position(z: f64, near: f64, far: f64, is_reversed: bool) -> f64 {
    let depth = far * (z + near) / (z * (far - near));
    if is_reversed { 1.0 - depth } else { depth }
}
