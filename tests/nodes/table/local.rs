//! Rows of local tone mapping and night vision.

use super::{Reference, smooth};
use crate::nodes::color::{self, tolerance};
use crate::nodes::local::{RANGE, SIGMAS, SIZE, wide};
use crate::reference::gaussian::radius;
use crate::reference::image::Image;
use crate::reference::local::{Grid, LocalToneMap, Splat};
use crate::reference::math::Rgb;
use crate::reference::purkinje::{full, simple, strength_log};
use crate::support::gpu::Picture;
use crate::support::harness::{Scale, Tolerance};

/// A flat picture whose log2 luminance is at the center of a cell of the grid: rounding moves no pixel to another cell.
fn in_one_slice([width, height]: [u32; 2]) -> Picture {
    let light = (-1.875_f32).exp2();
    Picture::new(width, height, |_, _| [light, light, light, 1.0])
}

/// The image that a probe shows of a grid: sums and weights in units of a pixel, then the range.
fn grid_image(grid: &Grid, image: &Image) -> Image {
    let capacity = image.width.div_ceil(SIZE[0]) * image.height.div_ceil(SIZE[1]);
    let unit = 512.0 / capacity as f64;
    Image::new(SIZE[0] * SIZE[1], SIZE[2], |x, y| {
        let [sum, weight] = grid.cells[x + SIZE[0] * SIZE[1] * y];
        [sum * unit, weight * unit, RANGE.low, RANGE.high]
    })
}

fn night(kind: &'static str, expected: impl Fn(Rgb) -> Rgb + 'static) -> Reference {
    let tolerance = Tolerance { of: Scale::Channel, ..tolerance(1e-6, 2e-4, "powers of small numbers in f32") };
    Reference::new(
        (kind, "Exposed"),
        &format!("\"result\": {kind}(source: \"scene\", illuminance: 0.8)"),
        color::light,
        tolerance,
        move |image| image.map_rgb(&expected).map_rgb(|rgb| rgb.map(|x| x.min(65504.0))),
    )
}

pub(super) fn local_kinds() -> Vec<Reference> {
    let cell =
        |relative| Tolerance { of: Scale::Channel, ..tolerance(5.0, relative, "cells count in units of 1/512 pixel") };
    let grid = "\"grid\": GridBuild(source: \"scene\", method: Nearest)";
    let blurred = "\"blurred\": GridBlur(source: \"grid\")";
    let around = "\"around\": LogGaussian(source: \"scene\")";
    let build = |image: &Image| Grid::build(image, SIZE, RANGE, Splat::Nearest);
    let blur = move |image: &Image| build(image).blurred(SIGMAS, SIGMAS.map(radius));
    let settings = LocalToneMap { bilateral: 0.4, middle: 0.18_f64.log2(), contrast: 0.5, detail: 1.0 };
    vec![
        Reference::new(
            ("GridBuild", "Exposed"),
            &format!("{grid}, \"result\": ProbeVolume(volume: \"grid\")"),
            in_one_slice,
            cell(1e-4),
            move |image| grid_image(&build(image), image),
        ),
        Reference::new(
            ("GridBlur", "Exposed"),
            &format!("{grid}, {blurred}, \"result\": ProbeVolume(volume: \"blurred\")"),
            in_one_slice,
            cell(0.02),
            move |image| grid_image(&blur(image), image),
        ),
        Reference::new(
            ("LogGaussian", "Exposed"),
            "\"result\": LogGaussian(source: \"scene\")",
            smooth,
            tolerance(1e-3, 0.0, "half floats hold eleven bits of a logarithm"),
            |image| wide(image).map(|[l, ..]| [l, l, l, 1.0]),
        ),
        Reference::new(
            ("LocalToneMap", "Exposed"),
            &format!(
                "{grid}, {blurred}, {around}, \"result\": LocalToneMap(source: \"scene\", grid: \"blurred\", \
                 gaussian: \"around\", share: 0.4, contrast: 0.5, detail: 1.0)"
            ),
            smooth,
            Tolerance { of: Scale::Channel, ..tolerance(0.0, 1.4e-3, "0.002 stops: the grid stores half floats") },
            move |image| settings.apply(image, &blur(image), &wide(image)),
        ),
        night("Purkinje", |rgb| full(rgb, strength_log(0.8), 380.0)),
        night("PurkinjeSimple", |rgb| simple(rgb, 0.8)),
    ]
}
