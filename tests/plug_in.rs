//! A node kind from another crate runs like a built-in one.

use crate::support::gpu::{Picture, run_exact};

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_dots_of_halftone_keep_the_mean_luminance() {
    let text = r#"Pipeline(
        inputs: { "in": DisplayLinear },
        nodes: { "out": Halftone(source: "in", pitch: 8.0) },
        outputs: { "out": "out" },
    )"#;
    for (light, most_off) in [(0.15, 0.02), (0.4, 0.02), (0.7, 0.02)] {
        let flat = Picture::new(160, 160, |_, _| [light, light, light, 1.0]);
        let printed = run_exact(text, &[("in", &flat)]).remove(0);
        let mean = printed.pixels.iter().map(|pixel| pixel[1]).sum::<f32>() / printed.pixels.len() as f32;
        assert!((mean - light).abs() < most_off, "{light} is printed as {mean}");
        assert!(printed.pixels.iter().any(|pixel| (pixel[1] - light).abs() > 0.1), "{light} has no dots");
    }
}
