//! Rows of exposure, grading and display.

use afterimage_nodes::Aces2Output;

use super::{POWERS, ROUNDING, Reference};
use crate::nodes::color::{self, noise, stored, stored_light, tolerance};
use crate::reference::color::{BRADFORD, white_balance_target};
use crate::reference::curves::{display, narkowicz};
use crate::reference::film_grain::Grain;
use crate::reference::gamut::{Eetf, reference_compress};
use crate::reference::grade::{Cdl, LiftGammaGain, balance, brightness, contrast, saturation};
use crate::reference::image::{Image, center_uv};
use crate::reference::lut::Cube;
use crate::reference::math::{Rgb, transform};
use crate::reference::sanitize::extended;
use crate::reference::transfer::{dither, srgb_encode};
use crate::reference::vignette;

pub(super) fn exposure_and_grade() -> Vec<Reference> {
    let cdl = Cdl { slope: [1.1, 1.0, 0.9], offset: [0.0; 3], power: [0.9, 1.0, 1.1], saturation: 1.2 };
    let lift = LiftGammaGain { lift: [0.1, 0.05, 0.0], gamma: [1.1, 1.0, 0.9], gain: [1.2, 1.0, 0.8] };
    let white = white_balance_target(&BRADFORD, [1.0, 0.5, 0.75], true);
    vec![
        Reference::colors(("Exposure", "Color"), "stops: -1.5", ROUNDING, |rgb| rgb.map(|x| x * (-1.5_f64).exp2())),
        Reference::colors(("WhiteBalance", "Exposed"), "target: (1.0, 0.5, 0.75)", ROUNDING, move |rgb| {
            extended(stored(transform(&white, rgb)))
        }),
        Reference::colors(("Saturation", "Exposed"), "amount: 0.5", ROUNDING, |rgb| {
            extended(stored(saturation(rgb, 0.5)))
        }),
        Reference::colors(("Brightness", "Encoded"), "amount: 0.1", ROUNDING, |rgb| {
            stored_light(rgb.map(|x| brightness(x, 0.1)))
        }),
        Reference::colors(("Contrast", "Encoded"), "form: Linear, amount: 1.5, pivot: 0.25", ROUNDING, |rgb| {
            stored_light(rgb.map(|x| contrast(x, 1.5, 0.25)))
        }),
        Reference::colors(("ColorBalance", "Encoded"), "multiply: (1.1, 1.0, 0.9)", ROUNDING, |rgb| {
            stored_light(balance(rgb, [1.1, 1.0, 0.9]))
        }),
        Reference::colors(
            ("Cdl", "Encoded"),
            "slope: (1.1, 1.0, 0.9), power: (0.9, 1.0, 1.1), saturation: 1.2",
            POWERS,
            move |rgb| stored(cdl.apply(rgb)),
        ),
        Reference::colors(
            ("LiftGammaGain", "DisplayLinear"),
            "lift: (0.1, 0.05, 0.0), gamma: (1.1, 1.0, 0.9), gain: (1.2, 1.0, 0.8)",
            tolerance(2e-6, 2e-5, "a power multiplies the error of its base by the inverse of gamma"),
            move |rgb| stored(lift.apply(rgb)),
        ),
    ]
}

/// Kinds that make or change an image for a display.
pub(super) fn display_kinds() -> Vec<Reference> {
    let cube = Cube::new(5, color::lut::look);
    let one_code = tolerance(1.0 / 255.0, 0.0, "a value at the border of two codes may be rounded to either");
    let grain = Grain { amount: 0.5, size: 1.5, color: 0.5, seed: 3 };
    vec![
        Reference::colors(
            ("ToneMap", "Exposed"),
            "curve: AcesNarkowicz, space: Rec709, middle_gray: Native, keep_hue: 0.0, gamut: Clip",
            POWERS,
            |rgb| display(rgb.map(narkowicz)),
        ),
        Reference::new(
            ("Aces2Output", "Exposed"),
            "\"result\": Aces2Output(source: \"scene\")",
            color::aces2::scene,
            tolerance(1e-4, 1e-4, "a chain of seven powers in f32, and a table of hues in f32"),
            |image| image.map_rgb(Aces2Output::default().evaluator()),
        ),
        Reference::colors(("ReferenceGamutCompress", "Exposed"), "", POWERS, reference_compress),
        Reference::colors(
            ("Eetf", "DisplayLinear"),
            "source_nits: 1000.0, peak_nits: 300.0, white_nits: 1000.0",
            tolerance(1e-5, 5e-5, "PQ and its inverse in f32"),
            |rgb| {
                let eetf = Eetf { source_peak: 1000.0, peak: 300.0, black: 0.0 };
                eetf.on_largest(rgb.map(|x| 1000.0 * x)).map(|x| x / 1000.0)
            },
        ),
        Reference::colors(("Encode", "DisplayLinear"), "transfer: Srgb", POWERS, |rgb| {
            rgb.map(|x| srgb_encode(x.clamp(0.0, 1.0)))
        }),
        Reference::colors(("ColorLut", "Encoded"), "file: \"look.cube\"", color::lut::LUT, move |rgb| {
            cube.tetrahedral(rgb)
        }),
        Reference::new(
            ("Dither", "Encoded"),
            "\"result\": Dither(source: \"scene\", bits: 8, seed: 7)",
            color::unit,
            one_code,
            |image| {
                at_pixels(image, |rgb, [x, y]| {
                    [0, 1, 2].map(|channel| {
                        let [u1, u2] = noise::random(x as u32, y as u32, channel, 7);
                        dither(rgb[channel], u1, u2, 8) / 255.0
                    })
                })
            },
        ),
        Reference::new(
            ("FilmGrain", "Encoded"),
            "\"result\": FilmGrain(source: \"scene\", amount: 0.5, size: 1.5, color: 0.5, seed: 3, animate: false)",
            color::unit,
            tolerance(2e-5, 0.0, "the pixel is divided by the size of a grain in f32"),
            move |image| at_pixels(image, |rgb, pixel| grain.apply(rgb, pixel)),
        ),
        Reference::new(
            ("Vignette", "Exposed"),
            "\"result\": Vignette(source: \"scene\", amount: 0.75, intensity: 0.5, smoothness: 0.25)",
            color::light,
            tolerance(1e-6, 2e-5, "the fade is the cube of a distance in f32"),
            |image| {
                at_pixels(image, |rgb, [x, y]| {
                    let uv = center_uv(x, y, image.width, image.height);
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
