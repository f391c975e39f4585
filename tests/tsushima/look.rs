//! What the look must not do: halos at edges, and fewer highlights than a plain tone curve keeps.

use afterimage_graph::check::Graph;

use super::reference::undithered;
use super::scene;
use crate::support::gpu::{Picture, Run, graph};

/// A picture of gray columns as dark as `dark`, and `stops` brighter from the column `at` on.
fn edge(at: u32, dark: f32, stops: f32) -> Picture {
    Picture::new(256, 128, |x, _| {
        let light = if x < at { dark } else { dark * stops.exp2() };
        [light, light, light, 1.0]
    })
}

/// How many codes of 8 bits the columns on either side of the edge differ from the one farthest from it.
fn halo(picture: &Picture, at: u32) -> f32 {
    let code = |x: u32| 255.0 * picture.at(x, picture.height / 2)[1];
    let stray = |x: u32, far: u32| (code(x) - code(far)).abs();
    // The two columns at the edge are the edge.
    let dark = (0..at - 1).map(|x| stray(x, 0));
    let bright = (at + 1..picture.width).map(|x| stray(x, picture.width - 1));
    dark.chain(bright).fold(0.0, f32::max)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn local_tone_mapping_has_no_halo_at_an_edge_of_seven_stops() {
    // Bloom is light around lights, and the vignette darkens the borders: both are wanted.
    let graph = undithered(&[("lit", "Off"), ("vignette", "Off")]);
    for (at, dark) in [(128, 0.02), (180, 0.05), (77, 0.01), (240, 2.0)] {
        let found = halo(&Run::new(&graph).frame(&[("scene", &edge(at, dark, 7.0))])[0], at);
        assert!(found <= 6.0, "the edge at column {at} from {dark} has a halo of {found} codes");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_talk_s_share_of_the_gaussian_has_a_halo() {
    let graph = undithered(&[("lit", "Off"), ("vignette", "Off"), ("local.share", "0.4")]);
    let found = halo(&Run::new(&graph).frame(&[("scene", &edge(128, 0.02, 7.0))])[0], 128);
    assert!(found > 25.0, "{found} codes");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_white_light_at_the_border_stays_white() {
    let graph = undithered(&[]);
    let picture = Picture::new(160, 90, |x, y| {
        let light = if x < 12 && y < 12 { 4000.0 } else { 0.2 + 0.1 * ((x / 8 + y / 8) % 2) as f32 };
        [light, light, light, 1.0]
    });
    let corner = Run::new(&graph).frame(&[("scene", &picture)])[0].at(2, 2);
    assert!(corner[..3].iter().all(|x| *x > 250.0 / 255.0), "{corner:?}");
}

/// The same exposure with a plain curve.
fn plain(stops: f64) -> Graph {
    graph(&format!(
        "Pipeline(inputs: {{ \"scene\": Color }}, nodes: {{ \
         \"exposed\": Exposure(source: \"scene\", stops: {stops:?}), \
         \"mapped\": ToneMap(source: \"exposed\", curve: AcesNarkowicz), \
         \"encoded\": Encode(source: \"mapped\") }}, outputs: {{ \"display\": \"encoded\" }})"
    ))
}

/// The mean code of a picture, and its share of pixels above code 250.
fn mean_and_clipped(picture: &Picture) -> (f64, f64) {
    let lumas = picture.pixels.iter().map(|[r, g, b, _]| 0.2126 * r + 0.7152 * g + 0.0722 * b);
    let count = picture.pixels.len() as f64;
    let (sum, clipped) = lumas.fold((0.0, 0), |(sum, clipped), luma| {
        (sum + f64::from(255.0 * luma), clipped + usize::from(luma > 250.0 / 255.0))
    });
    (sum / count, clipped as f64 / count)
}

/// The plain curve at the exposure at which its mean code is `mean`.
fn plain_with_mean(scene: &Picture, mean: f64) -> (f64, f64) {
    let (mut low, mut high) = (-16.0, 16.0);
    let mut found = (0.0, 0.0);
    for _ in 0..16 {
        let middle = 0.5 * (low + high);
        found = mean_and_clipped(&Run::new(&plain(middle)).frame(&[("scene", scene)])[0]);
        if found.0 < mean { low = middle } else { high = middle }
    }
    found
}

/// The share of pixels that may be clipped: a scene that fits the display keeps its contrast, and its few highlights.
const MAX_CLIPPED: f64 = 0.002;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn more_highlights_are_kept_than_by_a_plain_curve_of_the_same_mean() {
    let graph = undithered(&[]);
    for walk in [0.0, 0.5, 1.0] {
        let scene = scene(160, 90, walk);
        let (mean, clipped) = mean_and_clipped(&Run::new(&graph).frame(&[("scene", &scene)])[0]);
        let (plain_mean, plain_clipped) = plain_with_mean(&scene, mean);
        assert!((mean - plain_mean).abs() < 0.5, "the means are equal: {mean} {plain_mean}");
        assert!(
            clipped <= plain_clipped.max(MAX_CLIPPED),
            "at {walk}: {clipped} of the pixels are clipped, {plain_clipped} by the curve"
        );
    }
}
