//! Gaussian and GaussianPyramid on the GPU, compared with their CPU references.

use super::{SAMPLED, SIZES, WHOLE, blurred, caracal_taps, check, check_each, check_on, levels, picture, printed};
use crate::reference::image::Image;
use crate::reference::resample::{Down, Firefly, Up};
use crate::reference::{bloom, gaussian};
use crate::support::harness::image;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn gaussian_blurs_as_its_cpu_reference() {
    let nodes = |rest: &str| format!(r#""result": Gaussian(source: "scene", {rest})"#);
    for (taps, tolerance) in [("Exact", WHOLE), ("Linear", SAMPLED)] {
        for sigma in [0.6, 2.5] {
            let half = gaussian::taps(sigma, gaussian::radius(sigma));
            check(&nodes(&format!("sigma: {sigma}, taps: {taps}")), tolerance, blurred(&half));
        }
        let caracal = caracal_taps();
        check(&nodes(&format!("kernel: Caracal9, taps: {taps}")), tolerance, blurred(&caracal));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_deck_s_33_taps_are_those_it_prints() {
    let deck = printed(&[
        0.113597, 0.109084, 0.096593, 0.07887, 0.059384, 0.04123, 0.026396, 0.015583, 0.008483, 0.004258, 0.001971,
        0.000841, 0.000331, 0.00012, 0.00004, 0.000012, 0.000004,
    ]);
    // Without spikes: six printed digits of a weight are too few for them.
    for (taps, tolerance) in [("Exact", WHOLE), ("Linear", SAMPLED)] {
        let nodes = format!(r#""result": Gaussian(source: "scene", kernel: Course33, taps: {taps})"#);
        let scenes = SIZES.map(|size| picture(size, false));
        let expected = scenes.each_ref().map(|scene| blurred(&deck)(&image(scene)));
        check_each(&nodes, &scenes.each_ref(), &expected, tolerance);
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_widest_blur_is_still_a_gaussian() {
    let half = gaussian::taps(64.0, 256);
    let scene = picture([64, 64], false);
    let nodes = r#""result": Gaussian(source: "scene", sigma: 64.0, reach: 4.0)"#;
    check_on(nodes, &scene, &blurred(&half)(&image(&scene)), WHOLE);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_pyramid_is_blurred_level_by_level() {
    let nodes = r#"
        "mips": Downsample(source: "scene", levels: 3, filter: Tap4),
        "soft": GaussianPyramid(source: "mips", kernel: Caracal9),
        "result": Upsample(source: "soft", spread: 0.85, filter: Bilinear)"#;
    let half = caracal_taps();
    check(nodes, SAMPLED, |image| {
        let soft: Vec<Image> = levels(image, 3, Down::FourTap, Firefly::Off).iter().map(blurred(&half)).collect();
        bloom::lerp_chain(&soft, 0.85, Up::Bilinear, 1.0)
    });
}
