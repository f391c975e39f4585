//! Wires that no output accepts, shown by the probes.

use afterimage_graph::check::Graph;

use crate::reference::image::Image;
use crate::reference::sanitize;
use crate::support::gpu::Picture;
use crate::support::harness::{Nodes, image};

/// A pipeline from `scene` to the node `result`.
pub(crate) fn pipeline(nodes: &str) -> Graph {
    Nodes::new(nodes, &[("scene", "Color")]).graph()
}

/// The node `result` in the first frame, with 32 bits between all nodes.
pub(crate) fn shown(nodes: &str, scene: &Picture) -> Picture {
    Nodes::new(nodes, &[("scene", "Color")]).exact(&[scene])
}

/// The same with a further image of data.
pub(crate) fn shown_with(nodes: &str, scene: &Picture, name: &str, data: &Picture) -> Picture {
    Nodes::new(nodes, &[("scene", "Color"), (name, "Data")]).exact(&[scene, data])
}

/// The sizes of the pictures.
pub(crate) const SIZES: [(u32, u32); 3] = [(1, 1), (2, 3), (161, 89)];

/// Seventeen stops of gradients and edges, with black, the brightest half float and NaN in it.
pub(crate) fn scene(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let (u, v) = (f64::from(x) / f64::from(width), f64::from(y) / f64::from(height));
        let edge = if u + 0.3 * v > 0.7 { 5.0 } else { 0.0 };
        let stops = -8.0 + 6.0 * u + 2.0 * (9.0 * v).sin() + edge + 0.4 * (40.0 * u).sin() * (31.0 * v).cos();
        let light = stops.exp2() as f32;
        match (x * 31 + y * 17) % 1009 {
            500 => [0.0, 0.0, 0.0, 1.0],
            501 => [65504.0, 65504.0, 65504.0, 1.0],
            502 => [f32::NAN, 0.25, f32::INFINITY, 1.0],
            503 => [-1.0, 0.5, 0.25, 1.0],
            _ => [light * (1.0 + u as f32), light, light * (1.5 - v as f32), 0.5],
        }
    })
}

/// The picture as nodes read it: sanitized, in f64.
pub(crate) fn sanitized(picture: &Picture) -> Image {
    sanitize::sanitized(&image(picture))
}
