//! Rows of kinds that read depth with a camera.

use super::Reference;
use crate::nodes::color::tolerance;
use crate::nodes::surface::{eye, projected};
use crate::reference::image::Image;
use crate::reference::view::View;

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
    ]
}
