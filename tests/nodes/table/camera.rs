//! Rows of kinds that need depth or motion.

use super::Reference;
use crate::nodes::camera::{depths, motions, shift};
use crate::nodes::color::{self, tolerance};
use crate::nodes::lens::lights;
use crate::nodes::taa::moved;
use crate::reference::fog::Fog;
use crate::reference::image::Image;
use crate::reference::lens_blur::{DepthOfField, MotionBlur};
use crate::reference::outline;
use crate::reference::taa::Frames;
use crate::support::harness::{Scale, Tolerance, image};

/// Edges of samples' circles fall between one and nothing within a pixel, and lights are up to 60.
const EDGES: Tolerance = Tolerance {
    absolute: 2e-3,
    relative: 4e-3,
    of: Scale::Neighborhood,
    reason: "places of samples in f32, times the steep edges of circles and paths",
};

pub(super) fn camera_kinds() -> Vec<Reference> {
    let fog = Fog {
        density: 0.03,
        falloff: 0.2,
        level: 0.5,
        eye_height: 1.5,
        up: [0.0, 0.8, 0.6],
        start: 1.0,
        most: 0.9,
        color: [0.5, 0.6, 0.7],
        sun: [0.6, 0.0, -0.8],
        sun_color: [0.4, 0.3, 0.2],
        anisotropy: 0.6,
        fov: 60.0,
    };
    let size = |image: &Image| [image.width as u32, image.height as u32];
    vec![
        Reference::new(
            ("Fog", "Color"),
            "\"result\": Fog(source: \"scene\", depth: \"data\", density: 0.03, falloff: 0.2, level: 0.5, \
             eye_height: 1.5, up: (0.0, 0.8, 0.6), start: 1.0, most: 0.9, sun: (0.6, 0.0, -0.8), \
             sun_color: (0.4, 0.3, 0.2), anisotropy: 0.6, fov: 60.0)",
            color::light,
            tolerance(2e-5, 2e-5, "exponentials of distances in f32"),
            move |source| fog.apply(source, &image(&depths(size(source)))),
        )
        .with_data(depths),
        Reference::new(
            ("Fog", "Exposed"),
            "\"result\": Fog(source: \"scene\", depth: \"data\", camera: \"camera\", density: 0.03, falloff: 0.2, \
             level: 0.5, up: (0.0, 0.8, 0.6), start: 1.0, most: 0.9, sun: (0.6, 0.0, -0.8), sun_color: (0.4, 0.3, 0.2), \
             anisotropy: 0.6)",
            color::light,
            tolerance(2e-5, 4e-5, "exponentials of distances in f32, and products with matrices"),
            move |source| fog.apply_in_world(source, &image(&depths(size(source))), &moved()),
        )
        .with_data(depths)
        .with_camera(moved()),
        Reference::new(
            ("DepthOfField", "Exposed"),
            "\"result\": DepthOfField(source: \"scene\", depth: \"data\", focus: 4.0, f_stop: 1.4, \
             focal_length: 85.0, largest: 0.1, rings: 5, blades: 6, rotation: 20.0)",
            lights,
            EDGES,
            move |source| {
                let lens = DepthOfField {
                    focus: 4.0,
                    f_stop: f64::from(1.4_f32),
                    focal_length: 85.0,
                    sensor: 24.0,
                    most: f64::from(0.1_f32) * source.height as f64,
                    rings: 5,
                    blades: 6,
                    rotation: 20.0_f64.to_radians(),
                };
                lens.apply(source, &image(&depths(size(source))))
            },
        )
        .with_data(depths),
        Reference::new(
            ("MotionBlur", "Exposed"),
            "\"result\": MotionBlur(source: \"scene\", motion: \"data\", unit: Pixels, shutter: 360.0, largest: 0.1, \
             samples: 9)",
            lights,
            EDGES,
            move |source| {
                let blur = MotionBlur { samples: 9, most: f64::from(0.1_f32) * source.height as f64, objects: true };
                let paths = image(&motions(size(source))).map(|[x, y, ..]| [0.5 * x, 0.5 * y, f64::NAN, 1.0]);
                blur.apply(source, &paths, shift)
            },
        )
        .with_data(motions),
        Reference::new(
            ("MotionBlur", "Exposed"),
            "\"result\": MotionBlur(source: \"scene\", depth: \"data\", camera: \"camera\", shutter: 360.0, largest: 0.1, \
             samples: 9)",
            lights,
            EDGES,
            move |source| {
                let blur = MotionBlur { samples: 9, most: f64::from(0.1_f32) * source.height as f64, objects: false };
                let depth = image(&depths(size(source)));
                let (camera, depth) = (&moved(), &depth);
                let frames =
                    Frames { source, history: None, depth, previous_depth: None, motion: None, camera, ratio: 1.0 };
                let paths = Image::new(source.width, source.height, |x, y| {
                    let [u, v] = frames.motion([x as i64, y as i64]).to_array();
                    let depth = depth.texel(x as i64, y as i64)[0];
                    [0.5 * u * source.width as f64, 0.5 * v * source.height as f64, depth, 1.0]
                });
                blur.apply(source, &paths, shift)
            },
        )
        .with_data(depths)
        .with_camera(moved()),
        Reference::new(
            ("Outline", "Encoded"),
            "\"result\": Outline(source: \"scene\", depth: \"data\", normal: \"data\", color: (0.9, 0.5, 0.1), \
             amount: 0.75, depth_threshold: 0.04, normal_threshold: 0.2)",
            color::unit,
            Tolerance {
                of: Scale::Channel,
                ..tolerance(2e-5, 0.0, "differences of inverse depths in f32, over the width of a threshold")
            },
            move |source| {
                let data = image(&motions(size(source)));
                outline::drawn(source, [0.9, 0.5, 0.1], |at| {
                    let normal = outline::normal_edge(&data, at, 1, f64::from(0.2_f32));
                    0.75 * outline::depth_edge(&data, at, 1, f64::from(0.04_f32)).max(normal)
                })
            },
        )
        .with_data(motions),
    ]
}
