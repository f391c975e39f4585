//! Transparent pictures: what a node makes of light and alpha, over a background, is what it makes of the picture over
//! that background.

use super::lens::{apart, on_glass, over};
use crate::support::gpu::Picture;
use crate::support::harness::Nodes;

const SIZE: [u32; 2] = [72, 60];

fn nodes(text: &str, pictures: &[&Picture]) -> Picture {
    let text = if text.starts_with('"') { text.to_owned() } else { format!("\"result\": {text}") };
    // Bars are for a display.
    let state = if text.contains("Letterbox") { "Encoded" } else { "Exposed" };
    Nodes::new(&text, &[("in", state), ("depth", "Data")]).exact(pictures)
}

fn depth() -> Picture {
    let glass = on_glass(SIZE, [35.0, 29.0]);
    Picture::new(SIZE[0], SIZE[1], |x, y| [if glass.at(x, y)[3] > 0.0 && x < 40 { 1.5 } else { 1.6 }, 0.0, 0.0, 1.0])
}

/// Soft ripples, from dark to as bright as a sheet of paper.
fn photograph() -> Picture {
    Picture::new(SIZE[0], SIZE[1], |x, y| {
        let ripple = |a: f32, b: f32| 0.5 + 0.4 * (a * x as f32 + b * y as f32).sin();
        [ripple(0.06, 0.03), ripple(0.02, -0.05), ripple(-0.04, 0.04), 1.0]
    })
}

/// A picture over another one.
fn laid(front: &Picture, behind: &Picture) -> Picture {
    Picture::new(front.width, front.height, |x, y| {
        let ([r, g, b, a], back) = (front.at(x, y), behind.at(x, y));
        [r + (1.0 - a) * back[0], g + (1.0 - a) * back[1], b + (1.0 - a) * back[2], 1.0]
    })
}

/// The mean of the channels of each pixel in all three.
fn grayed(picture: &Picture) -> Picture {
    Picture::new(picture.width, picture.height, |x, y| {
        let [r, g, b, a] = picture.at(x, y);
        let mean = (r + g + b) / 3.0;
        [mean, mean, mean, a]
    })
}

/// Glow that is mixed in: a mean of the picture takes its place.
const MIXED: &str = "\"all\": Extract(source: \"in\", method: All), \"mips\": Downsample(source: \"all\", levels: 4), \
    \"bloom\": Upsample(source: \"mips\"), \
    \"result\": Composite(base: \"in\", bloom: \"bloom\", blend: Mix, strength: 0.6)";

const BILATERAL: &str = "BilateralBlur(source: \"in\", depth: \"depth\", radius: 6, depth_threshold: 0.1)";
const HALATION: &str = "Halation(source: \"in\", strength: 0.8, tint: (1.0, 1.0, 1.0), radius: 0.04)";

/// Kinds that blur, move or cover all channels alike.
const ALIKE: [&str; 17] = [
    MIXED,
    BILATERAL,
    "DirectionalBlur(source: \"in\", length: 0.3, angle: 25.0)",
    "Gaussian(source: \"in\", sigma: 2.5)",
    "Glitch(source: \"in\", amount: 0.3, share: 1.0, fringe: 0.0)",
    HALATION,
    "Halation(source: \"in\", strength: 0.8, tint: (1.0, 1.0, 1.0), radius: 0.2)",
    "HeatHaze(source: \"in\", strength: 0.1)",
    "LensDistortion(source: \"in\", k1: -0.2)",
    "Letterbox(source: \"in\", aspect: 2.0, color: (0.3, 0.1, 0.0), amount: 0.7)",
    "Outline(source: \"in\", depth: \"depth\", depth_threshold: 0.02, color: (0.1, 0.2, 0.4))",
    "LensProfile(source: \"in\", ptlens: (0.0, -0.2, 0.0))",
    "Pixelate(source: \"in\", side: 7.0)",
    "RadialBlur(source: \"in\", center: (0.4, 0.6), zoom: 0.4, spin: 20.0)",
    "Transform(source: \"in\", offset: (0.13, -0.07), scale: 0.7, rotation: 31.0)",
    "Transform(source: \"in\", scale: 1.4, rotation: -20.0, crop: (0.3, 0.0, 0.0, 0.4), repeat: true)",
    "\"mask\": GradientMask(source: \"in\", start: (0.5, 1.0)), \
     \"result\": VariableBlur(source: \"in\", mask: \"mask\", sigma: 0.06)",
];

/// Kinds that move the channels apart.
const APART: [&str; 4] = [
    "ChromaticAberration(source: \"in\", red: 0.08, blue: -0.06, growth: 0.0)",
    "Glitch(source: \"in\", amount: 0.3, share: 1.0, fringe: 0.5)",
    "Halation(source: \"in\", strength: 1.0, radius: 0.06)",
    "LensProfile(source: \"in\", red: (1.06, 0.0, 0.0), blue: (0.95, 0.0, 0.0))",
];

/// The judge is the same node on the picture over the background. The channels that move apart have one alpha, which is
/// right for their mean.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn what_moves_light_moves_its_coverage() {
    let (glass, depth) = (on_glass(SIZE, [35.0, 29.0]), depth());
    for (text, is_alike) in ALIKE.map(|text| (text, true)).into_iter().chain(APART.map(|text| (text, false))) {
        let moved = nodes(text, &[&glass, &depth]);
        assert!(apart(&moved, &glass) > 0.1, "{text}: nothing moves");
        for background in [0.0, 1.0, 20.0] {
            // Where no picture is, the background is seen again.
            let wanted = over(&nodes(text, &[&over(&glass, background), &depth]), background);
            let found = over(&moved, background);
            let pair = if is_alike { [found, wanted] } else { [grayed(&found), grayed(&wanted)] };
            let off = apart(&pair[0], &pair[1]) / background.max(1.0);
            assert!(off < 1e-4, "{text} over {background}: off by {off}");
        }
    }
}

/// A photograph behind the picture does not move, where it would move in the judge. So the error is compared with that
/// of an alpha which stays where it was. One alpha for three channels that move apart has at best 0.82 of it.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures say how good the kinds are")]
fn a_photograph_is_seen_behind_what_has_moved() {
    let (glass, depth, behind) = (on_glass(SIZE, [35.0, 29.0]), depth(), photograph());
    let mut worse = Vec::new();
    for (text, share) in [
        (MIXED, 0.55),
        (BILATERAL, 0.25),
        (HALATION, 0.25),
        ("LensProfile(source: \"in\", ptlens: (0.0, -0.05, 0.0))", 0.4),
        (APART[0], 0.9),
        (APART[2], 0.9),
        (APART[3], 0.9),
        ("Denoise(source: \"in\", strength: 8.0)", 0.85),
        ("HeatHaze(source: \"in\", strength: 0.02)", 0.5),
    ] {
        let moved = nodes(text, &[&glass, &depth]);
        let wanted = nodes(text, &[&laid(&glass, &behind), &depth]);
        let stuck = Picture::new(SIZE[0], SIZE[1], |x, y| {
            let [r, g, b, _] = moved.at(x, y);
            [r, g, b, glass.at(x, y)[3]]
        });
        let [with, without] = [&moved, &stuck].map(|picture| {
            let found = laid(picture, &behind);
            let pairs = found.pixels.iter().zip(&wanted.pixels);
            let sum: f32 = pairs.flat_map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).powi(2))).sum();
            (sum / (3 * found.pixels.len()) as f32).sqrt()
        });
        println!("{text}: {with:.5}, with an alpha that stays {without:.5}");
        if with > share * without {
            worse.push(text);
        }
    }
    assert!(worse.is_empty(), "{worse:?}");
}

/// Glow is light without coverage: it is added to whatever is behind, and what is there stays to be seen. A background
/// that is too dark to glow gets the same as in the picture over it.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn glow_adds_light_and_covers_nothing() {
    let glass = on_glass(SIZE, [35.0, 29.0]);
    let lamps = Picture::new(SIZE[0], SIZE[1], |x, y| {
        let is_lamp = [(30, 25), (44, 31), (8, 50)].iter().any(|(a, b)| x.abs_diff(*a) < 2 && y.abs_diff(*b) < 2);
        if is_lamp { [30.0, 20.0, 12.0, 1.0] } else { glass.at(x, y) }
    });
    let light = "\"bright\": Extract(source: \"in\", threshold: 1.0, knee: 0.0), \
                 \"mips\": Downsample(source: \"bright\", levels: 4), \"bloom\": Upsample(source: \"mips\"),";
    let depth = depth();
    for last in [
        "\"result\": Composite(base: \"in\", bloom: \"bloom\", strength: 0.3)",
        "\"lines\": Streaks(source: \"bright\"), \"result\": Composite(base: \"in\", bloom: \"lines\", strength: 0.3)",
        "\"result\": GodRays(source: \"in\", bright: \"bright\")",
    ] {
        let text = format!("{light} {last}");
        let glowing = nodes(&text, &[&lamps, &depth]);
        let pairs = || glowing.pixels.iter().zip(&lamps.pixels);
        assert!(pairs().all(|(found, own)| found[3] == own[3]), "{last}: it covers what is behind");
        assert!(pairs().any(|(found, own)| own[3] == 0.0 && found[0] > 0.01), "{last}: light beside the picture");
        let dark = Picture::new(SIZE[0], SIZE[1], |_, _| [0.9, 0.9, 0.9, 1.0]);
        let black = Picture::new(SIZE[0], SIZE[1], |_, _| [0.0, 0.0, 0.0, 1.0]);
        for behind in [&black, &dark, &photograph()] {
            let wanted = nodes(&text, &[&laid(&lamps, behind), &depth]);
            let off = apart(&laid(&glowing, behind), &wanted);
            assert!(off < 1e-4, "{last} over {:?}: off by {off}", behind.at(0, 0));
        }
    }
}
