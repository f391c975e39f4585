//! Rows of kinds that change a color by the place of its pixel.

use super::Reference;
use crate::nodes::color::{self, tolerance};
use crate::reference::film_grain::Grain;
use crate::reference::image::{Image, center_uv};
use crate::reference::math::Rgb;
use crate::reference::vignette;

pub(super) fn placed_colors() -> Vec<Reference> {
    let grain = Grain { amount: 0.5, size: 1.5, color: 0.5, seed: 3 };
    vec![
        Reference::new(
            ("FilmGrain", "Encoded"),
            "\"result\": FilmGrain(source: \"scene\", amount: 0.5, size: 1.5, color: 0.5, seed: 3, animate: false)",
            color::unit,
            tolerance(2e-5, 0.0, "the pixel is divided by the size of a grain in f32"),
            move |image| at_pixels(image, |rgb, pixel| grain.apply(rgb, pixel)),
        ),
        Reference::new(
            ("Vignette", "Exposed"),
            "\"result\": Vignette(source: \"scene\", amount: 0.75, intensity: 0.5, smoothness: 0.25, \
             center: (0.375, 0.625))",
            color::light,
            tolerance(1e-6, 2e-5, "the fade is the cube of a distance in f32"),
            |image| {
                at_pixels(image, |rgb, [x, y]| {
                    let [u, v] = center_uv(x, y, image.width, image.height);
                    // The reference has its middle in that of the image.
                    let uv = [u + 0.125, v - 0.125];
                    let factor = vignette::factor(uv, 0.5, 0.25, 1.0);
                    rgb.map(|x| x * vignette::blended(factor, 0.75))
                })
            },
        ),
    ]
}

/// An image whose colors are mapped with the place of their pixels.
fn at_pixels(image: &Image, f: impl Fn(Rgb, [usize; 2]) -> Rgb) -> Image {
    Image::new(image.width, image.height, |x, y| {
        let [r, g, b, a] = image.texel(x as i64, y as i64);
        let [r, g, b] = f([r, g, b], [x, y]);
        [r, g, b, a]
    })
}
