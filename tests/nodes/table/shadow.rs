//! Rows of occlusion by points and of the shadows of lights.

use glam::DVec3;

use super::Reference;
use super::surface::{ANGLES, shown, size};
use crate::nodes::camera::depths;
use crate::nodes::color::{self, tolerance};
use crate::nodes::occlusion::surfaces;
use crate::nodes::surface::eye;
use crate::reference::gtao::{Surfaces, lit};
use crate::reference::image::Image;
use crate::reference::math::mix;
use crate::reference::shadow::{Lamp, Shadow, Soft};
use crate::reference::ssao::Ssao;
use crate::reference::view::View;
use crate::support::gpu::Picture;
use crate::support::harness::{Tolerance, image};

pub(super) fn shadow_kinds() -> Vec<Reference> {
    vec![
        Reference::new(
            ("Ssao", "Color"),
            "\"result\": Ssao(source: \"scene\", depth: \"data\", camera: \"camera\", radius: 4.0, bias: 0.05, \
             samples: 24, amount: 0.75, power: 1.5)",
            color::light,
            ANGLES,
            |source| {
                let depth = image(&depths(size(source)));
                let surfaces = Surfaces { view: View::new(&eye(), &depth), depth: &depth };
                let found = points(false, 1).visibility(surfaces, |pixel| surfaces.normal(pixel));
                shown(source, &found, |light, visible, _| lit(light, mix(1.0, visible.powf(1.5), 0.75), None))
            },
        )
        .with_data(depths)
        .with_camera(eye()),
        Reference::new(
            ("Ssao", "Exposed"),
            "\"result\": Ssao(source: \"scene\", depth: \"data\", camera: \"camera\", normal: \"data\", radius: 4.0, \
             bias: 0.05, samples: 24, size: Half, denoise: 2)",
            color::light,
            ANGLES,
            |source| {
                let data = image(&surfaces(size(source)));
                let surfaces = Surfaces { view: View::new(&eye(), &data), depth: &data };
                let normal = |[x, y]: [i64; 2]| {
                    let [x, y, z, _] = data.texel(x, y);
                    DVec3::new(x, y, z).normalize()
                };
                let found = points(true, 2).visibility(surfaces, normal);
                shown(source, &found, |light, visible, _| lit(light, visible, None))
            },
        )
        .with_data(surfaces)
        .with_camera(eye()),
        Reference::new(
            ("ShadowMask", "Color"),
            &format!("\"result\": ShadowMask({SHADOWED}, kernel: 4, bias: 0.02, slope_bias: 0.5, amount: 0.75)"),
            color::light,
            SHARES,
            |source| {
                let shadow = Shadow { kernel: 4, bias: f64::from(0.02_f32), slope_bias: 0.5, ..HARD };
                shadowed(source, &shadow, 0.75)
            },
        )
        .with_data(near)
        .with_camera(eye()),
        Reference::new(
            ("ShadowMask", "Exposed"),
            &format!(
                "\"result\": ShadowMask({SHADOWED}, kernel: 5, pattern: Disc, taps: 12, bias: 0.0, normal_bias: 0.5)"
            ),
            color::light,
            SHARES,
            |source| {
                let shadow = Shadow { kernel: 5, disc: Some(12), normal_bias: 0.5, ..HARD };
                shadowed(source, &shadow, 1.0)
            },
        )
        .with_data(near)
        .with_camera(eye()),
        Reference::new(
            ("ShadowMask", "Color"),
            &format!(
                "\"result\": ShadowMask({SHADOWED}, kernel: 2, taps: 24, bias: 0.02, light_diameter: 0.5, \
                 largest: 0.4, blocker_taps: 20)"
            ),
            color::light,
            SHARES,
            |source| {
                let soft = Soft { diameter: 0.5, largest: f64::from(0.4_f32), blocker_taps: 20, taps: 24 };
                let shadow = Shadow { kernel: 2, bias: f64::from(0.02_f32), soft: Some(soft), ..HARD };
                shadowed(source, &shadow, 1.0)
            },
        )
        .with_data(near)
        .with_camera(eye()),
    ]
}

fn points(is_half: bool, denoise: usize) -> Ssao {
    Ssao { radius: 4.0, bias: f64::from(0.05_f32), samples: 24, is_half, denoise }
}

/// The eye is the light, too, and distances are what its projection writes: many places lie behind what it shows there.
const SHADOWED: &str = "source: \"scene\", depth: \"data\", camera: \"camera\", map: \"data\", light: \"camera\"";

/// A square, without a bias but that of the slope.
const HARD: Shadow = Shadow { kernel: 3, disc: None, bias: 0.0, slope_bias: 1.0, normal_bias: 0.0, soft: None };

const SHARES: Tolerance = tolerance(1e-5, 1e-3, "places by products of matrices in f32, which linear filters weigh");

/// A surface that rises and falls, from 0.15 to 0.85.
fn near([width, height]: [u32; 2]) -> Picture {
    Picture::new(width, height, |x, y| {
        let (u, v) = (x as f32 / width as f32, y as f32 / height as f32);
        [0.5 + 0.35 * (5.0 * u + 3.0 * v).sin() * (1.0 - 0.3 * v), 0.0, 0.0, 1.0]
    })
}

/// The light of an image that its own camera's light leaves.
fn shadowed(source: &Image, shadow: &Shadow, amount: f64) -> Image {
    let depth = image(&near(size(source)));
    let surfaces = Surfaces { view: View::new(&eye(), &depth), depth: &depth };
    let (camera, lamp) = (eye(), Lamp::new(&eye(), &depth));
    Image::new(source.width, source.height, |x, y| {
        let pixel = [x as i64, y as i64];
        let share = shadow.share((&camera, surfaces), &lamp, pixel, surfaces.normal(pixel));
        let [r, g, b, a] = source.texel(pixel[0], pixel[1]);
        let lit = 1.0 - amount * share;
        [lit * r, lit * g, lit * b, a]
    })
}
