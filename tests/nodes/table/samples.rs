//! Rows of kinds that read samples of multisampled images.

use half::f16;

use super::Reference;
use crate::nodes::camera::depths;
use crate::nodes::color;
use crate::reference::image::Image;
use crate::reference::resolve::Samples;
use crate::support::gpu::Picture;
use crate::support::harness::{Scale, Tolerance};

/// Four pictures one below the other, one for each sample. Samples are half floats.
fn four(scene: fn([u32; 2]) -> Picture, [width, height]: [u32; 2]) -> Picture {
    let mut all = scene([width, 4 * height]);
    all.pixels.iter_mut().for_each(|pixel| *pixel = pixel.map(|number| f16::from_f32(number).to_f32()));
    all
}

fn light(size: [u32; 2]) -> Picture {
    four(color::light, size)
}

fn distances(size: [u32; 2]) -> Picture {
    four(depths, size)
}

const WINDOWS: Tolerance = Tolerance {
    absolute: 1e-9,
    relative: 2e-5,
    of: Scale::Neighborhood,
    reason: "cosines of f32, whose sum is small at the end of a window",
};

pub(super) fn sample_kinds() -> Vec<Reference> {
    let row = |filter: &str, gain: f32, radius: f64| {
        let nodes = format!("\"result\": Resolve(source: \"scene\", filter: {filter}, gain: {gain:?})");
        let expected = move |all: &Image| Samples { all, count: 4 }.resolved(radius, f64::from(gain));
        Reference::new(("Resolve", "Color(multisampled: true)"), &nodes, light, WINDOWS, expected)
    };
    let chosen = |filter: &str, is_largest: bool| {
        let nodes = format!("\"result\": Resolve(source: \"scene\", filter: {filter})");
        let expected = move |all: &Image| Samples { all, count: 4 }.chosen(is_largest);
        let none = Tolerance { absolute: 0.0, relative: 0.0, of: Scale::Channel, reason: "samples" };
        Reference::new(("Resolve", "Depth(multisampled: true)"), &nodes, distances, none, expected)
    };
    vec![
        row("Box", 0.0, 0.0),
        row("Box", 1.0, 0.0),
        row("Box", 65504.0, 0.0),
        row("BlackmanHarris15", 0.0, 1.5),
        row("BlackmanHarris20", 0.25, 2.0),
        chosen("Smallest", false),
        chosen("Largest", true),
    ]
}
