//! Ambient occlusion by horizons, as Jimenez and others (2016) describe it, with a denoiser.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3, Vec3Swizzles as _};

use super::image::Image;
use super::math::mix;
use super::view::{View, distance_of};

/// The distance off a plane, as a share of the depth, beyond which visibilities are not mixed.
const SOFT: f64 = 0.02;
/// The sine of the angle over the surface below which an occluder counts less.
const FLAT: f64 = 0.08;

/// The search of a pixel.
#[derive(Clone, Copy)]
pub(crate) struct Gtao {
    pub(crate) radius: f64,
    pub(crate) falloff: f64,
    /// The longest way in pixels.
    pub(crate) most: f64,
    pub(crate) slices: usize,
    pub(crate) steps: usize,
    /// True if it is computed at half of the size.
    pub(crate) is_half: bool,
    pub(crate) denoise: usize,
}

/// Depth, and what sees it.
#[derive(Clone, Copy)]
pub(crate) struct Surfaces<'a> {
    pub(crate) view: View,
    pub(crate) depth: &'a Image,
}

/// A pixel, its place, the direction to the camera, and the normal.
#[derive(Clone, Copy)]
struct Seen {
    pixel: [i64; 2],
    place: DVec3,
    toward: DVec3,
    normal: DVec3,
}

impl Surfaces<'_> {
    fn distance(&self, [x, y]: [i64; 2]) -> f64 {
        distance_of(self.depth.texel(x, y)[0])
    }

    pub(super) fn place(&self, [x, y]: [i64; 2]) -> DVec3 {
        self.view.place([x as f64, y as f64], self.distance([x, y]))
    }

    fn has(&self, [x, y]: [i64; 2]) -> bool {
        (0..self.depth.width as i64).contains(&x) && (0..self.depth.height as i64).contains(&y)
    }

    fn tangent(&self, [x, y]: [i64; 2], [dx, dy]: [i64; 2]) -> DVec3 {
        let middle = self.place([x, y]);
        let (next, last) = ([x + dx, y + dy], [x - dx, y - dy]);
        let after = self.has(next).then(|| self.place(next) - middle);
        let before = self.has(last).then(|| middle - self.place(last));
        match (after, before) {
            (Some(after), Some(before)) if after.z.abs() < before.z.abs() => after,
            (after, before) => before.or(after).unwrap_or_else(|| middle - self.place(last)),
        }
    }

    pub(crate) fn normal(&self, pixel: [i64; 2]) -> DVec3 {
        self.tangent(pixel, [0, 1]).cross(self.tangent(pixel, [1, 0])).normalize_or(DVec3::Z)
    }

    fn seen(&self, pixel: [i64; 2], normal: DVec3) -> Seen {
        let place = self.place(pixel);
        Seen { pixel, place, toward: self.toward(place), normal }
    }

    /// The direction from a place to the camera.
    pub(super) fn toward(&self, place: DVec3) -> DVec3 {
        let is_perspective = self.view.projection.z_axis.w != 0.0;
        if is_perspective { (-place).normalize() } else { DVec3::Z }
    }
}

fn arc(horizon: f64, normal: f64) -> f64 {
    0.25 * (normal.cos() - (2.0 * horizon - normal).cos() + 2.0 * horizon * normal.sin())
}

/// The cosine-weighted light of a slice that the surface alone bounds.
fn open(seen: Seen, tangent: DVec3) -> f64 {
    let (toward, along) = (seen.normal.dot(seen.toward), seen.normal.dot(tangent));
    toward + along.atan2(toward) * along
}

/// The tangents of slices that lie evenly around the direction to the camera.
fn tangents(toward: DVec3, count: usize, turn: f64) -> impl Iterator<Item = DVec3> {
    let right = DVec3::new(toward.z, 0.0, -toward.x).normalize();
    let up = toward.cross(right);
    (0..count)
        .map(move |i| DVec2::from_angle(PI * (i as f64 + turn) / count as f64))
        .map(move |at| at.x * right + at.y * up)
}

impl Gtao {
    /// The highest cosine on one side.
    fn horizon(&self, surfaces: Surfaces<'_>, seen: Seen, way: DVec2, lowest: f64, shift: f64) -> f64 {
        let cosines = (0..self.steps).filter_map(|i| {
            let share = (i as f64 + shift) / self.steps as f64;
            let pixels = 1.0 + share * share * (way.length() - 1.0).max(0.0);
            let offset = way * (pixels / way.length());
            let round = |x: f64| x.round_ties_even() as i64;
            let other = [seen.pixel[0] + round(offset.x), seen.pixel[1] + round(offset.y)];
            let to = surfaces.has(other).then(|| surfaces.place(other) - seen.place)?;
            let near = ((self.radius - to.length()) / (self.falloff * self.radius)).clamp(0.0, 1.0);
            let rise = (to.dot(seen.normal) / (FLAT * to.length()).max(1e-6)).clamp(0.0, 1.0);
            Some(mix(lowest, to.dot(seen.toward) / to.length().max(1e-6), near * rise))
        });
        cosines.fold(lowest, f64::max)
    }

    /// The occlusion of a slice along a tangent, which is across the direction to the camera.
    fn slice(&self, surfaces: Surfaces<'_>, seen: Seen, tangent: DVec3, shift: f64) -> f64 {
        let facing = DVec2::new(seen.normal.dot(seen.toward), seen.normal.dot(tangent));
        let angle = facing.y.atan2(facing.x);
        let along = tangent.xy() - seen.place.xy() * (tangent.z / seen.place.z);
        let way = surfaces.view.pixels_apart(along * self.radius, -seen.place.z);
        let way = way * (self.most / way.length().max(1e-6)).min(1.0);
        if way.length() < 1.0 {
            return 0.0;
        }
        let horizon =
            |way: DVec2, lowest: f64| self.horizon(surfaces, seen, way, lowest, shift).clamp(-1.0, 1.0).acos();
        let up = horizon(way, (angle + FRAC_PI_2).cos());
        let down = -horizon(-way, (angle - FRAC_PI_2).cos());
        let (high, low) = (angle + (up - angle).min(FRAC_PI_2), angle + (down - angle).max(-FRAC_PI_2));
        (open(seen, tangent) - facing.length() * (arc(low, angle) + arc(high, angle))).max(0.0)
    }

    /// The visibility of a pixel; `texel` is the place in the image of visibilities.
    fn visible(&self, surfaces: Surfaces<'_>, pixel: [i64; 2], [x, y]: [usize; 2], normal: DVec3) -> f64 {
        let turn = (((x + y) & 3) * 4 + (x & 3)) as f64 / 16.0;
        let shift = 0.125 + 0.25 * ((y + 4 * x - x) & 3) as f64;
        let seen = surfaces.seen(pixel, normal);
        let slices = tangents(seen.toward, self.slices, turn);
        1.0 - slices.map(|tangent| self.slice(surfaces, seen, tangent, shift)).sum::<f64>() / self.slices as f64
    }

    /// Visibilities and inverse distances, by normals that `normal` gives for a pixel.
    pub(crate) fn visibility(&self, surfaces: Surfaces<'_>, normal: impl Fn([i64; 2]) -> DVec3) -> Image {
        smoothed(surfaces, (self.is_half, self.denoise), |pixel, texel| {
            self.visible(surfaces, pixel, texel, normal(pixel))
        })
    }
}

/// Visibilities after the denoiser and inverse distances, at the pixels of the depth. `visible` gives the visibility of
/// a pixel and of its texel in the smaller image.
pub(crate) fn smoothed(
    surfaces: Surfaces<'_>,
    (is_half, denoise): (bool, usize),
    visible: impl Fn([i64; 2], [usize; 2]) -> f64,
) -> Image {
    let depth = surfaces.depth;
    let stride = if is_half { 2 } else { 1 };
    let pixel_of = |x: usize, last: usize| ((2 * x + 1) * stride / 2).min(last);
    let mut found = Image::new(depth.width.div_ceil(stride), depth.height.div_ceil(stride), |x, y| {
        let pixel = [pixel_of(x, depth.width - 1) as i64, pixel_of(y, depth.height - 1) as i64];
        let distance = surfaces.distance(pixel);
        let is_sky = distance > 60000.0;
        [if is_sky { 1.0 } else { visible(pixel, [x, y]) }, 1.0 / distance, 0.0, 1.0]
    });
    for _ in 0..denoise {
        found = denoised(&denoised(&found, [1, 0]), [0, 1]);
    }
    if is_half { enlarged(&found, depth) } else { found }
}

fn slope(image: &Image, [x, y]: [i64; 2], [dx, dy]: [i64; 2]) -> f64 {
    let at = |x: i64, y: i64| {
        let is_inside = (0..image.width as i64).contains(&x) && (0..image.height as i64).contains(&y);
        is_inside.then(|| image.texel(x, y)[1])
    };
    let middle = image.texel(x, y)[1];
    let (after, before) = (at(x + dx, y + dy).map(|z| z - middle), at(x - dx, y - dy).map(|z| middle - z));
    match (after, before) {
        (Some(after), Some(before)) if after.abs() < before.abs() => after,
        (after, before) => before.or(after).unwrap_or(0.0),
    }
}

/// The mean of four texels along an axis, on the plane of each pixel.
fn denoised(image: &Image, [dx, dy]: [i64; 2]) -> Image {
    Image::new(image.width, image.height, |x, y| {
        let (x, y) = (x as i64, y as i64);
        let [own, inverse, ..] = image.texel(x, y);
        let slope = slope(image, [x, y], [dx, dy]);
        let (mut sum, mut total) = (own, 1.0);
        for i in [-2, -1, 1, 2] {
            let (i_x, i_y) = (x + i * dx, y + i * dy);
            if !(0..image.width as i64).contains(&i_x) || !(0..image.height as i64).contains(&i_y) {
                continue;
            }
            let [other, found, ..] = image.texel(i_x, i_y);
            let off = ((found - inverse - slope * i as f64).abs() / (inverse.max(1e-6) * SOFT)).min(1.0);
            let weight = (1.0 - off * off) * if i.abs() == 2 { 0.5 } else { 1.0 };
            sum += weight * other;
            total += weight;
        }
        [sum / total, inverse, 0.0, 1.0]
    })
}

/// Visibilities of half of the size at the pixels of the depth.
fn enlarged(small: &Image, depth: &Image) -> Image {
    Image::new(depth.width, depth.height, |x, y| {
        let inverse = 1.0 / distance_of(depth.texel(x as i64, y as i64)[0]);
        let place = [x, y].map(|at| (at as f64 - 1.0) / 2.0);
        let (mut sum, mut total) = (0.0, 0.0);
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let share = |at: f64, corner: i64| if corner == 1 { at - at.floor() } else { 1.0 - at + at.floor() };
            let [other, found, ..] = small.texel(place[0].floor() as i64 + i, place[1].floor() as i64 + j);
            let off = (found - inverse).abs() / (SOFT * inverse);
            let weight = (share(place[0], i) * share(place[1], j) + 1e-3) / (1e-3 + off * off);
            sum += weight * other;
            total += weight;
        }
        [sum / total, inverse, 0.0, 1.0]
    })
}

/// Light times the visibility, with light that bounces between surfaces of the albedo.
pub(crate) fn lit(light: [f64; 4], visible: f64, albedo: Option<[f64; 4]>) -> [f64; 4] {
    let bounced = |c: usize| {
        let Some(albedo) = albedo else { return visible };
        let share = albedo[c].clamp(0.0, 1.0);
        let [a, b, k] = [2.0404 * share - 0.3324, -4.7951 * share + 0.6417, 2.7552 * share + 0.6903];
        visible.max(((visible * a + b) * visible + k) * visible).min(1.0)
    };
    [light[0] * bounced(0), light[1] * bounced(1), light[2] * bounced(2), light[3]]
}

#[cfg(test)]
mod tests {
    use afterimage_graph::node::Camera;
    use glam::Mat4;
    use glam::camera::rh::proj::directx;

    use super::*;

    const SEARCH: Gtao =
        Gtao { radius: 1.0, falloff: 0.5, most: 1e9, slices: 16, steps: 32, is_half: false, denoise: 1 };

    /// Between a floor and a wall that ends at a height, a point at a distance from the wall sees all but the wall's form
    /// factor, which is that of a rectangle without ends: (1 - distance / sqrt(distance^2 + height^2)) / 2.
    #[test]
    fn before_a_step_the_visibility_is_one_minus_its_form_factor() {
        let projection = directx::orthographic(-4.0, 4.0, -4.0, 4.0, 0.1, 50.0).to_cols_array_2d();
        let depth = Image::new(160, 160, |x, _| [if x < 80 { 10.0 } else { 9.2 }, 0.0, 0.0, 1.0]);
        let view = View::new(&Camera::still(Mat4::IDENTITY.to_cols_array_2d(), projection), &depth);
        let surfaces = Surfaces { view, depth: &depth };
        // So far that nothing fades out; the step is 0.8 m high, and pixels are 0.05 m wide.
        let search = Gtao { radius: 60.0, falloff: 0.05, most: 79.0, steps: 600, ..SEARCH };
        for x in [79, 76, 70, 60] {
            let sum: f64 = (0..16).map(|i| search.visible(surfaces, [x, 80], [i % 4, i / 4], DVec3::Z)).sum();
            let distance = 0.05 * (80 - x) as f64;
            let wanted = 1.0 - 0.5 * (1.0 - distance / distance.hypot(0.8));
            assert!((sum / 16.0 - wanted).abs() < 0.02, "{x}: {} and not {wanted}", sum / 16.0);
        }
    }

    /// The light of all slices of a plane is 1 by definition, for any number of slices that is not small: at each place of
    /// the picture, wide or narrow, whatever the tilt of the plane is.
    #[test]
    fn the_light_of_slices_around_the_ray_sums_to_that_of_the_hemisphere() {
        for (field, aspect) in [(37.0_f64, 1.78), (58.0, 1.78), (90.0, 1.78), (90.0, 0.56), (120.0, 1.0)] {
            let half = (0.5 * field.to_radians()).tan();
            for (x, y) in [(0.0, 0.0), (1.0, 1.0), (-1.0, 1.0), (1.0, 0.0), (0.0, -1.0), (0.5, -0.8)] {
                let toward = DVec3::new(-x * aspect * half, -y * half, 1.0).normalize();
                for normal in [DVec3::Z, DVec3::Y, DVec3::NEG_X, DVec3::new(0.5, -0.4, 0.6), DVec3::new(-0.9, 0.1, 0.3)]
                {
                    let normal = normal.normalize() * normal.dot(toward).signum();
                    let seen = Seen { pixel: [0, 0], place: -toward, toward, normal };
                    let sum: f64 = tangents(toward, 512, 0.5).map(|tangent| open(seen, tangent)).sum();
                    let off = (sum / 512.0 - 1.0).abs();
                    assert!(off < 1e-4, "{field} degrees at {x}, {y}, normal {normal}: {off}");
                }
            }
        }
    }

    /// A wall that faces the camera, with a step in the corner of a wide picture, beside the share of cosine-weighted rays
    /// that the side of the step does not stop.
    #[test]
    fn in_a_corner_of_a_wide_picture_the_visibility_is_that_of_rays() {
        const SIZE: usize = 1024;
        let (wall, front, edge) = (4.0, 3.7, 3.0);
        let projection = directx::perspective_infinite_reverse(FRAC_PI_2 as f32, 1.0, 0.1).to_cols_array_2d();
        let slope = |x: usize| 2.0 * (x as f64 + 0.5) / SIZE as f64 - 1.0;
        let distance = |x: usize| match slope(x) {
            right if right * front >= edge => front,
            right if right * wall >= edge => edge / right,
            _ => wall,
        };
        let depth = Image::new(SIZE, SIZE, |x, _| [distance(x), 0.0, 0.0, 1.0]);
        let view = View::new(&Camera::still(Mat4::IDENTITY.to_cols_array_2d(), projection), &depth);
        let surfaces = Surfaces { view, depth: &depth };
        let search = Gtao { radius: 60.0, falloff: 0.05, most: 200.0, steps: 400, ..SEARCH };
        let mut least = 1.0_f64;
        for [x, y] in [[890, 100], [880, 100], [860, 60], [890, 512]] {
            let place = surfaces.place([x, y]);
            assert!(place.x < edge && distance(x as usize) == wall, "{place}");
            // The cosine-weighted light of the directions that meet the side of the step before its front.
            let apart = (edge - place.x, wall - front);
            let wanted = 1.0 - 0.5 * (1.0 - apart.0 / apart.0.hypot(apart.1));
            let sum: f64 = (0..16).map(|i| search.visible(surfaces, [x, y], [i % 4, i / 4], DVec3::Z)).sum();
            assert!((sum / 16.0 - wanted).abs() < 0.025, "{x}, {y}: {} and not {wanted}", sum / 16.0);
            least = least.min(wanted);
        }
        assert!(least < 0.8, "the step stops nothing");
    }

    #[test]
    fn a_plane_in_perspective_occludes_nothing() {
        let projection = directx::perspective_infinite_reverse(1.0, 1.5, 0.1).to_cols_array_2d();
        let depth = Image::new(48, 32, |x, y| [1.0 / (0.02 + 0.002 * x as f64 + 0.006 * y as f64), 0.0, 0.0, 1.0]);
        let view = View::new(&Camera::still(Mat4::IDENTITY.to_cols_array_2d(), projection), &depth);
        let surfaces = Surfaces { view, depth: &depth };
        for (slices, is_half, denoise) in [(1, false, 0), (2, false, 1), (2, true, 1), (16, false, 1)] {
            let search = Gtao { steps: 8, slices, is_half, denoise, ..SEARCH };
            let found = search.visibility(surfaces, |pixel| surfaces.normal(pixel));
            let least = found.pixels.iter().map(|pixel| pixel[0]).fold(1.0, f64::min);
            assert!(least > 1.0 - 1e-6, "{least}");
        }
    }
}
