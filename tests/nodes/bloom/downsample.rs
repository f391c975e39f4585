//! Downsample on the GPU, compared with its CPU reference.

use super::{FILTERS, SAMPLED, SCENE, SIZES, check, check_on, coarsest, picture};
use crate::reference::resample::Firefly;
use crate::support::gpu::Picture;
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

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn downsample_weighs_fireflies_as_its_cpu_reference() {
    for (name, filter) in FILTERS {
        for (how, firefly) in [("Groups", Firefly::Groups), ("Taps", Firefly::Taps)] {
            let nodes = format!(
                r#""mips": Downsample(source: "scene", levels: 2, filter: {name}, firefly: {how}) -> mips.coarsest"#
            );
            for size in SIZES {
                // A light leaks out of its texel by the rounding of the sampler's weights; next to the brightest number
                // that is light enough to change what its neighbors weigh, except where taps fall on corners.
                let steady = size.iter().all(|side| side % 2 == 0 || *side == 1);
                for spikes in [false, true].into_iter().filter(|spikes| steady || !spikes) {
                    let scene = picture(size, spikes);
                    check_on(&nodes, &scene, &coarsest(&image(&scene), 2, filter, firefly), SAMPLED);
                }
            }
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
