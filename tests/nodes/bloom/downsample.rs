//! Downsample on the GPU, compared with its CPU reference.

use super::{FILTERS, Precision, SAMPLED, SCENE, check, check_each, coarsest, pictures};
use crate::reference::image::Image;
use crate::reference::resample::Firefly;
use crate::support::gpu::{Picture, Run};
use crate::support::harness::{Nodes, image};

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn downsample_filters_as_its_cpu_reference() {
    for (name, filter) in FILTERS {
        for count in [1, 3] {
            let nodes =
                format!(r#""mips": Downsample(source: "scene", levels: {count}, filter: {name}) -> mips.coarsest"#);
            check(&nodes, SAMPLED, |image| coarsest(image, count, filter, Firefly::Off));
        }
    }
}

/// A texel's share in a tap is rounded; of the brightest number, that changes what the tap weighs.
const WEIGHTED: Precision = Precision { exact: 2e-4, half: 3e-3, reason: "shares of the brightest number are rounded" };

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn downsample_weighs_fireflies_as_its_cpu_reference() {
    for (name, filter) in FILTERS {
        for (how, firefly) in [("Groups", Firefly::Groups), ("Taps", Firefly::Taps)] {
            let nodes = format!(
                r#""mips": Downsample(source: "scene", levels: 2, filter: {name}, firefly: {how}) -> mips.coarsest"#
            );
            let scenes = pictures();
            let expected: Vec<Image> = scenes.iter().map(|scene| coarsest(&image(scene), 2, filter, firefly)).collect();
            check_each(&nodes, &scenes.iter().collect::<Vec<_>>(), &expected, WEIGHTED);
        }
    }
}

/// A dim picture with a lamp of many pixels and single bright pixels at every place that a filter tells apart.
fn lamps() -> Picture {
    Picture::new(64, 64, |x, y| {
        let lamp = (20..28).contains(&x) && (36..44).contains(&y);
        let spark = y % 16 == x / 16 && x % 16 == 5 + y / 16;
        let light = if spark { 500.0 } else { f32::from(u8::from(lamp)) * 30.0 + 0.1 };
        [light, 0.5 * light, 0.25 * light, 1.0]
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_cheaper_filter_holds_fireflies_back_as_the_thirteen_taps_do() {
    let lamps = lamps();
    let glow = |filter: &str, firefly: &str| {
        let nodes = format!(
            r#""mips": Downsample(source: "scene", levels: 4, filter: {filter}, firefly: {firefly}) -> mips.coarsest"#
        );
        let level = Nodes::new(&nodes, SCENE).half(&[&lamps]);
        level.pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>()
    };
    let wanted = glow("Tap13", "Groups");
    for filter in ["Tap9", "Tap4", "Box"] {
        let ratio = glow(filter, "Groups") / wanted;
        assert!((0.85..1.15).contains(&ratio), "{filter}: {ratio}");
    }
    // Each tap by itself dims more, and no weights at all far less.
    assert!(glow("Tap4", "Taps") < 0.8 * wanted && glow("Tap4", "Off") > 1.2 * wanted);
}

/// All four parities of the sides, and those of frames.
const PARITIES: [[u32; 2]; 7] = [[64, 64], [65, 64], [64, 65], [65, 65], [482, 269], [481, 269], [1281, 719]];

/// The coarsest of so many levels of each picture.
fn downsampled(filter: &str, levels: u32, pictures: &[Picture]) -> Vec<Picture> {
    let nodes = format!(r#""mips": Downsample(source: "scene", levels: {levels}, filter: {filter}) -> mips.coarsest"#);
    let graph = Nodes::new(&nodes, SCENE).graph();
    Run::new(&graph).exact().shown(&pictures.iter().collect::<Vec<_>>())
}

/// Pixels between lights, along both axes: odd, so that lights have all positions within the texels of every level, and
/// wide enough that no texel of the first two levels has light of two.
const BETWEEN: u32 = 31;

/// True if a pixel has a light: one in each square of that many pixels, away from the border.
fn is_light(x: u32, y: u32, width: u32, height: u32) -> bool {
    let is_inside = (14..width - 14).contains(&x) && (14..height - 14).contains(&y);
    is_inside && x % BETWEEN == 15 && y % BETWEEN == 15
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_light_of_one_pixel_keeps_its_energy_at_every_size() {
    let pictures = PARITIES.map(|[width, height]| {
        Picture::new(width, height, |x, y| [if is_light(x, y, width, height) { 1000.0 } else { 0.0 }, 0.0, 0.0, 1.0])
    });
    for (name, _) in FILTERS {
        for count in [1, 2] {
            for ([width, height], level) in PARITIES.into_iter().zip(downsampled(name, count, &pictures)) {
                let scale = [f64::from(width) / f64::from(level.width), f64::from(height) / f64::from(level.height)];
                // The texels of the level whose centers are in the square around a light.
                let mut energies = std::collections::BTreeMap::<[u32; 2], f64>::new();
                for (x, y) in (0..level.height).flat_map(|y| (0..level.width).map(move |x| (x, y))) {
                    let square = [(x, scale[0]), (y, scale[1])]
                        .map(|(texel, scale)| ((f64::from(texel) + 0.5) * scale) as u32 / BETWEEN);
                    *energies.entry(square).or_default() += f64::from(level.at(x, y)[0]) * scale[0] * scale[1] / 1000.0;
                }
                let mut lights = 0;
                for ([across, down], energy) in energies {
                    if is_light(across * BETWEEN + 15, down * BETWEEN + 15, width, height) {
                        lights += 1;
                        let place = format!("{name} {count}, {width}x{height}, {across} {down}");
                        assert!((energy - 1.0).abs() < 1e-3, "{place}: {energy}");
                    }
                }
                assert!(lights >= 4, "{lights}");
            }
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_chessboard_becomes_its_mean() {
    let boards = PARITIES.map(|[width, height]| {
        Picture::new(width, height, |x, y| [f32::from(u8::from((x + y) % 2 == 0)), 0.0, 0.0, 1.0])
    });
    for (name, _) in FILTERS {
        for ([width, height], level) in PARITIES.into_iter().zip(downsampled(name, 1, &boards)) {
            // Within the border. Along an odd side of n texels, a box has 1/n more of one color.
            for (x, y) in (2..level.height - 2).flat_map(|y| (2..level.width - 2).map(move |x| (x, y))) {
                let light = level.at(x, y)[0];
                assert!((light - 0.5).abs() < 1e-3, "{name}, {width}x{height}, {x}, {y}: {light}");
            }
        }
    }
}
