//! Shadows from the depth map of a light, by percentage-closer filtering, with penumbrae for lights of some size.

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
    /// For lights of some size.
    pub(crate) soft: Option<Soft>,
}

/// A light of some size, and how what blocks it is searched.
#[derive(Clone, Copy)]
pub(crate) struct Soft {
    /// The diameter in meters of a light with a perspective, or the angular diameter in degrees.
    pub(crate) diameter: f64,
    /// The widest penumbra, in widths of the map.
    pub(crate) largest: f64,
    pub(crate) blocker_taps: usize,
    pub(crate) taps: usize,
}

/// A place as the light sees it: in texels of the map, whose centers have whole numbers; the distance along the axis,
/// less the bias; and what a texel covers there.
#[derive(Clone, Copy)]
struct Place {
    texel: DVec2,
    distance: f64,
    width: f64,
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

    /// The distance of what a texel shows, if it is one of the map.
    fn distance(&self, [x, y]: [i64; 2]) -> Option<f64> {
        let (width, height) = (self.map.width as i64, self.map.height as i64);
        let is_inside = (0..width).contains(&x) && (0..height).contains(&y);
        is_inside.then(|| self.view.distance([x as f64, y as f64], self.map.texel(x, y)[0]))
    }

    /// True if a texel lies before a distance.
    fn is_before(&self, texel: [i64; 2], distance: f64) -> bool {
        self.distance(texel).is_some_and(|found| found < distance)
    }

    fn is_perspective(&self) -> bool {
        self.view.projection.z_axis.w != 0.0
    }

    /// The distance of the near plane, at either end of the depths.
    fn nearest(&self) -> f64 {
        let middle = [0.5 * self.map.width as f64 - 0.5, 0.5 * self.map.height as f64 - 0.5];
        self.view.distance(middle, 0.0).min(self.view.distance(middle, 1.0))
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

/// The direction of a tap of a spiral, which turns within four by four pixels.
fn direction([x, y]: [i64; 2], tap: usize) -> DVec2 {
    let turn = (((x + y) & 3) * 4 + (x & 3)) as f64 / 16.0;
    let angle = TAU * turn + 2.3999632 * tap as f64;
    DVec2::new(angle.cos(), angle.sin())
}

impl Soft {
    /// Half of the width in texels of the penumbra of an edge that is so much nearer to the light.
    fn penumbra(&self, lamp: &Lamp<'_>, place: Place, gap: f64) -> f64 {
        let half = 0.5 * self.diameter;
        let meters = if lamp.is_perspective() {
            // By similar triangles: the light's disc, the edge, the place.
            half * gap / (place.distance - gap).max(1e-3)
        } else {
            half.to_radians().tan() * gap
        };
        meters / place.width
    }

    /// How much nearer to the light its blockers are in the mean, if there are any.
    fn gap(&self, lamp: &Lamp<'_>, place: Place, radius: f64, (pixel, kernel): ([i64; 2], usize)) -> Option<f64> {
        let blockers = (0..self.blocker_taps).filter_map(|tap| {
            let way = radius * tap as f64 / self.blocker_taps as f64;
            let at = (place.texel + way * direction(pixel, tap) + 0.5).floor();
            let gap = place.distance - lamp.distance([at.x as i64, at.y as i64])?;
            let reach = self.penumbra(lamp, place, gap).max(0.5 * kernel as f64 + 0.5);
            (gap > 0.0 && at.distance(place.texel) <= reach).then_some(gap)
        });
        let (sum, count) = blockers.fold((0.0, 0), |(sum, count), gap| (sum + gap, count + 1));
        (count > 0).then(|| sum / f64::from(count))
    }
}

/// The mean of taps on a disc of this radius in texels, compared with distances that fall by `rise` to the rim.
fn disc(lamp: &Lamp<'_>, place: Place, (radius, rise): (f64, f64), (pixel, taps): ([i64; 2], usize)) -> f64 {
    let one = |tap: usize| {
        let share = ((tap as f64 + 0.5) / taps as f64).sqrt();
        lamp.square(place.texel + radius * share * direction(pixel, tap), place.distance - rise * share, 1)
    };
    (0..taps).map(one).sum::<f64>() / taps as f64
}

impl Shadow {
    fn filtered(&self, lamp: &Lamp<'_>, place: Place, pixel: [i64; 2]) -> f64 {
        let least = 0.5 * self.kernel as f64;
        let Some(soft) = self.soft else {
            let Some(taps) = self.disc else { return lamp.square(place.texel, place.distance, self.kernel) };
            return disc(lamp, place, (least, 0.0), (pixel, taps));
        };
        let widest = (0.5 * soft.largest * lamp.map.width as f64).max(least);
        let reach = soft.penumbra(lamp, place, (place.distance - lamp.nearest()).max(0.0)).clamp(least, widest);
        let Some(gap) = soft.gap(lamp, place, reach, (pixel, self.kernel)) else { return 0.0 };
        let radius = soft.penumbra(lamp, place, gap).clamp(least, widest);
        disc(lamp, place, (radius, 0.5 * gap), (pixel, soft.taps))
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
        let toward = if lamp.is_perspective() { (-place).normalize() } else { DVec3::Z };
        let facing = n.dot(toward);
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
        let texel = DVec2::new(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y) * size - 0.5;
        let filtered = if self.disc.is_some() || self.soft.is_some() { 1.0 } else { 0.5 };
        let reach = (0.5 * self.kernel as f64 + filtered) * width;
        let slope = (n.x.abs() + n.y.abs()) * toward.z.max(0.0) / facing.max(GRAZING);
        let distance = -moved.z - self.bias - self.slope_bias * reach * slope;
        self.filtered(lamp, Place { texel, distance, width }, pixel)
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
