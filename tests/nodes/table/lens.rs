//! Rows of sharpening, anti-aliasing and lenses.

use super::Reference;
use crate::nodes::bloom;
use crate::nodes::color::{self, tolerance};
use crate::nodes::lens::{aliased, lights};
use crate::reference::fxaa::{Fxaa, STEPS};
use crate::reference::haze::Haze;
use crate::reference::image::{Image, center_uv};
use crate::reference::lens::{Flare, dirt, halation, streaks};
use crate::reference::sharpen::{Unsharp, cas};
use crate::reference::smaa::Smaa;
use crate::reference::warp::{Lens, aberration, inverse, warped};
use crate::support::gpu::Picture;
use crate::support::harness::{Scale, Tolerance, image};

/// A tolerance relative to the brightest number within four pixels: sums of neighbors.
const fn near(relative: f64, reason: &'static str) -> Tolerance {
    Tolerance { absolute: 1e-6, relative, of: Scale::Neighborhood, reason }
}

pub(super) fn sharpness_kinds() -> Vec<Reference> {
    vec![
        Reference::new(
            ("Cas", "DisplayLinear"),
            "\"result\": Cas(source: \"scene\", sharpness: 0.8, amount: 0.75)",
            color::unit,
            near(2e-5, "a root and a division in f32, of differences of neighbors"),
            |image| cas(image, 0.8, 1.0, 0.75),
        ),
        Reference::new(
            ("Sharpen", "Encoded"),
            "\"result\": Sharpen(source: \"scene\", amount: 1.5, radius: 1.5, threshold: 0.01, halo: 0.1)",
            color::unit,
            near(2e-5, "differences of sums of 81 neighbors in f32"),
            |image| Unsharp { amount: 1.5, sigma: 1.5, threshold: 0.01, halo: 0.1, ceiling: 1.0 }.apply(image),
        ),
        Reference::new(
            ("Fxaa", "Encoded"),
            "\"result\": Fxaa(source: \"scene\")",
            aliased,
            near(2e-4, "the place of the last read is a quotient of distances in f32"),
            |image| {
                let steps = STEPS[0];
                Fxaa { subpixel: 0.75, threshold: 0.125, floor: 0.0312, steps, is_light: false }.apply(image)
            },
        ),
        Reference::new(
            ("Smaa", "DisplayLinear"),
            "\"result\": Smaa(source: \"scene\")",
            aliased,
            near(2e-5, "shares are quotients in f32"),
            |image| Smaa { threshold: 0.1, corners: 0.25, reach: 32, diagonals: 8, is_light: true }.apply(image),
        ),
    ]
}

pub(super) fn lens_kinds() -> Vec<Reference> {
    let sampled = bloom::SAMPLED.within(bloom::SAMPLED.exact, 1e-6);
    let flare = |threshold: f64, limit: f64| Flare {
        threshold,
        limit,
        ghosts: 5,
        spacing: 0.35,
        ghost_strength: 0.3,
        halo_radius: 0.4,
        halo_strength: 0.1,
        dispersion: 0.01,
    };
    let flares = |fields: &str, threshold: f64, limit: f64| {
        Reference::new(
            ("LensFlare", "Exposed"),
            &format!("\"result\": LensFlare(source: \"scene\"{fields})"),
            lights,
            Tolerance { absolute: 1e-4, ..sampled },
            move |image| flare(threshold, limit).apply(image),
        )
    };
    vec![
        Reference::new(
            ("Halation", "Exposed"),
            "\"result\": Halation(source: \"scene\", strength: 0.4, tint: (1.0, 0.5, 0.25), radius: 0.15)",
            lights,
            sampled,
            |image| halation(image, [0.4, 0.2, 0.1], f64::from(0.15_f32) * image.height as f64),
        ),
        Reference::new(
            ("Streaks", "Exposed"),
            "\"result\": Streaks(source: \"scene\", length: 0.1, tint: (0.5, 0.75, 1.0), intensity: 2.0)",
            lights,
            sampled,
            |image| {
                let length = f64::from(0.1_f32) * image.height as f64;
                let count = [4, 16, 64].into_iter().find(|count| *count as f64 >= 5.0 * length);
                streaks(image, length, count.expect("the pictures are small"), [1.0, 1.5, 2.0])
            },
        ),
        flares("", 0.0, 65504.0),
        flares(", threshold: 8.0, limit: 16.0", 8.0, 16.0),
        Reference::new(
            ("LensDirt", "Exposed"),
            "\"result\": LensDirt(source: \"scene\", strength: 2.0, seed: 3)",
            color::light,
            tolerance(1e-5, 1e-4, "places of smudges in f32, times their steep edges"),
            |image| {
                let aspect = image.width as f64 / image.height as f64;
                Image::new(image.width, image.height, |x, y| {
                    let [r, g, b, a] = image.texel(x as i64, y as i64);
                    let dirt = dirt(center_uv(x, y, image.width, image.height), aspect, 6.0, 3);
                    let [r, g, b] = [r, g, b].map(|x| (x * (1.0 + 2.0 * dirt)).min(65504.0));
                    [r, g, b, a]
                })
            },
        ),
    ]
}

/// Places are exact to a thousandth of a texel. Neighboring texels of `lights` differ by up to 60.
const PLACES: Tolerance = Tolerance {
    absolute: 1e-4,
    relative: 4e-3,
    of: Scale::Neighborhood,
    reason: "places of taps in f32, and the last step of Newton's method",
};

/// The mask of hot air: from 0 to 1, and beyond.
fn heat([width, height]: [u32; 2]) -> Picture {
    Picture::new(width, height, |x, y| {
        [1.2 * (x as f32 + 0.5) / width as f32 - 0.1 * y as f32 / height as f32, 0.0, 0.0, 1.0]
    })
}

pub(super) fn warp_kinds() -> Vec<Reference> {
    let lens = Lens { k: [-0.2, 0.05, -0.01], p: [0.004, -0.006] };
    let haze = Haze { strength: 0.05, scale: 0.2, speed: 0.25, shape: 1.5, time: 0.0 };
    vec![
        Reference::new(
            ("HeatHaze", "Exposed"),
            "\"result\": HeatHaze(source: \"scene\", mask: \"data\", strength: 0.05, scale: 0.2, shape: 1.5)",
            lights,
            PLACES,
            move |source| haze.apply(source, Some(&image(&heat([source.width as u32, source.height as u32])))),
        )
        .with_data(heat),
        Reference::new(
            ("ChromaticAberration", "Exposed"),
            "\"result\": ChromaticAberration(source: \"scene\", red: 0.02, blue: -0.03, growth: 0.75)",
            lights,
            PLACES,
            |image| warped(image, [&aberration(0.02, 0.75), &|place| place, &aberration(-0.03, 0.75)]),
        ),
        Reference::new(
            ("LensDistortion", "Exposed"),
            "\"result\": LensDistortion(source: \"scene\", k1: -0.2, k2: 0.05, k3: -0.01, p1: 0.004, p2: -0.006)",
            lights,
            PLACES,
            move |image| {
                let straight = |place| inverse(|place| lens.brown(place), place);
                warped(image, [&straight; 3])
            },
        ),
    ]
}
