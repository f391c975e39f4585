//! Rows of kinds that read depth with a camera.

use glam::DVec3;

use super::Reference;
use crate::nodes::camera::depths;
use crate::nodes::color::{self, tolerance};
use crate::nodes::lens::lights;
use crate::nodes::occlusion::surfaces;
use crate::nodes::surface::{eye, projected};
use crate::nodes::taa::moved;
use crate::reference::bilateral::Bilateral;
use crate::reference::gtao::{Gtao, Surfaces, lit};
use crate::reference::image::Image;
use crate::reference::math::mix;
use crate::reference::taa::{Frames, Taa};
use crate::reference::view::View;
use crate::support::harness::{Tolerance, image};

pub(super) fn surface_kinds() -> Vec<Reference> {
    vec![
        Reference::new(
            ("LinearDepth", "Data"),
            "\"result\": LinearDepth(depth: \"scene\", camera: \"camera\")",
            projected,
            tolerance(0.0, 2e-5, "a product with a matrix in f32, and a division"),
            |depth| {
                let view = View::new(&eye(), depth);
                Image::new(depth.width, depth.height, |x, y| {
                    let [depth, ..] = depth.texel(x as i64, y as i64);
                    [view.distance([x as f64, y as f64], depth), 0.0, 0.0, 1.0]
                })
            },
        )
        .with_camera(eye()),
        Reference::new(
            ("BilateralBlur", "Color"),
            "\"result\": BilateralBlur(source: \"scene\", depth: \"data\", normal: \"data\", radius: 5, \
             depth_threshold: 0.1, normal_threshold: 0.4)",
            color::light,
            BLURRED,
            |source| {
                let data = image(&surfaces(size(source)));
                let threshold = |value: f32| f64::from(value);
                let blur = Bilateral { radius: 5, depth_threshold: threshold(0.1), normal_threshold: threshold(0.4) };
                blur.apply(source, &data, Some(&data))
            },
        )
        .with_data(surfaces),
        Reference::new(
            ("Gtao", "Color"),
            "\"result\": Gtao(source: \"scene\", depth: \"data\", camera: \"camera\", radius: 4.0, falloff: 0.5, \
             largest: 0.5, amount: 0.75, power: 1.5, slices: 2, steps: 5)",
            color::light,
            ANGLES,
            |source| {
                let depth = image(&depths(size(source)));
                let surfaces = Surfaces { view: View::new(&eye(), &depth), depth: &depth };
                let found = search(&depth).visibility(surfaces, |pixel| surfaces.normal(pixel));
                shown(source, &found, |light, visible, _| lit(light, mix(1.0, visible.powf(1.5), 0.75), None))
            },
        )
        .with_data(depths)
        .with_camera(eye()),
        Reference::new(
            ("Gtao", "Exposed"),
            "\"result\": Gtao(source: \"scene\", depth: \"data\", camera: \"camera\", normal: \"data\", \
             albedo: \"data\", radius: 4.0, falloff: 0.5, largest: 0.5, slices: 2, steps: 5, size: Half, denoise: 2)",
            color::light,
            ANGLES,
            |source| {
                let data = image(&surfaces(size(source)));
                let surfaces = Surfaces { view: View::new(&eye(), &data), depth: &data };
                let normal = |[x, y]: [i64; 2]| {
                    let [x, y, z, _] = data.texel(x, y);
                    DVec3::new(x, y, z).normalize()
                };
                let search = Gtao { is_half: true, denoise: 2, ..search(&data) };
                let found = search.visibility(surfaces, normal);
                shown(source, &found, |light, visible, at| lit(light, visible, Some(data.texel(at[0], at[1]))))
            },
        )
        .with_data(surfaces)
        .with_camera(eye()),
        Reference::new(
            ("Taa", "Exposed"),
            "\"result\": Taa(source: \"scene\", history: \"result@previous\", depth: \"data\", camera: \"camera\")",
            lights,
            BLURRED,
            |source| {
                let (camera, depth) = (moved(), image(&surfaces(size(source))));
                let taa = Taa {
                    blend: f64::from(0.08_f32),
                    moving: 0.5,
                    variance: 1.25,
                    depth_threshold: 0.05,
                    white: 1.0,
                    keep_above: 65504.0,
                };
                let (depth, camera) = (&depth, &camera);
                let none =
                    Frames { source, history: None, depth, previous_depth: None, motion: None, camera, ratio: 1.0 };
                taa.apply(&none)
            },
        )
        .with_data(surfaces)
        .with_camera(moved()),
    ]
}

const BLURRED: Tolerance = Tolerance {
    absolute: 1e-6,
    relative: 1e-4,
    of: crate::support::harness::Scale::Neighborhood,
    reason: "weights by differences of inverse depths in f32",
};

/// The arc cosine of f32 is off by 3e-4 near 1.
pub(super) const ANGLES: Tolerance = tolerance(0.0, 4e-3, "arc cosines of f32, in products with light");

pub(super) fn size(image: &Image) -> [u32; 2] {
    [image.width as u32, image.height as u32]
}

fn search(depth: &Image) -> Gtao {
    let most = 0.5 * depth.height as f64;
    Gtao { radius: 4.0, falloff: 0.5, most, slices: 2, steps: 5, is_half: false, denoise: 1 }
}

/// The light of an image by the visibility of each pixel.
pub(super) fn shown(source: &Image, found: &Image, lit: impl Fn([f64; 4], f64, [i64; 2]) -> [f64; 4]) -> Image {
    Image::new(source.width, source.height, |x, y| {
        let at = [x as i64, y as i64];
        lit(source.texel(at[0], at[1]), found.texel(at[0], at[1])[0].max(0.0), at)
    })
}
