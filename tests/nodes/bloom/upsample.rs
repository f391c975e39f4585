//! Upsample on the GPU, compared with its CPU reference.

use super::{SAMPLED, check, check_on, levels, picture};
use crate::reference::bloom;
use crate::reference::image::Image;
use crate::reference::resample::{Down, Firefly, Up};
use crate::support::harness::image;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn upsample_joins_levels_as_its_cpu_reference() {
    let nodes = |rest: &str| {
        format!(
            r#""mips": Downsample(source: "scene", levels: 4, filter: Tap4),
            "result": Upsample(source: "mips", {rest})"#
        )
    };
    let mips = |image: &Image| levels(image, 4, Down::FourTap, Firefly::Off);
    for (name, up) in [("Tent", Up::Tent), ("Bilinear", Up::Bilinear)] {
        let mixed = nodes(&format!("blend: Mix, spread: 0.7, filter: {name}, radius: 0.85"));
        check(&mixed, SAMPLED, |image| bloom::lerp_chain(&mips(image), 0.7, up, 0.85));
        let added = nodes(&format!("blend: Add, filter: {name}, radius: 1.25"));
        check(&added, SAMPLED, |image| bloom::additive_chain(&mips(image), up, 1.25));
    }
    check(&nodes("spread: 0.0"), SAMPLED, |image| mips(image).swap_remove(0));
    check(&nodes("spread: 1.0"), SAMPLED, |image| bloom::lerp_chain(&mips(image), 1.0, Up::Tent, 1.0));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn levels_that_are_not_normalized_are_summed() {
    let nodes = r#"
        "mips": Downsample(source: "scene", levels: 3, filter: Tap4),
        "result": Upsample(source: "mips", blend: Add, normalize: false)"#;
    let scene = picture([40, 24], false);
    let mips = levels(&image(&scene), 3, Down::FourTap, Firefly::Off);
    let sum = bloom::additive_chain(&mips, Up::Tent, 1.0).map(|pixel| pixel.map(|v| 3.0 * v));
    check_on(nodes, &scene, &sum, SAMPLED);
}
