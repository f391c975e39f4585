//! Properties of both meters: the range, weights, and a held exposure.

use super::{gray, sequence};
use crate::nodes::probes::{pipeline, sanitized, shown, shown_with};
use crate::reference::color::luminance;
use crate::reference::image::{center_uv, rgb};
use crate::support::gpu::Picture;

/// The nodes of both meters, with further parameters of the kind that reads the image and of the one that exposes.
fn meters(reading: &str, exposing: &str) -> [String; 2] {
    [
        format!(
            "\"h\": Histogram(source: \"scene\", {reading}), \
             \"auto\": AutoExposure(histogram: \"h\", low: 0.0, high: 1.0, {exposing}), \
             \"result\": ShowValue(value: \"auto\")"
        ),
        format!(
            "\"h\": MeanLuminance(source: \"scene\", {reading}), \"auto\": Adapt(mean: \"h\", {exposing}), \
             \"result\": ShowValue(value: \"auto\")"
        ),
    ]
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures are in graph/docs/measurements/color.md")]
fn flat_fields_of_the_whole_range_come_out_alike() {
    for nodes in meters("", "") {
        for light in [1.2208e-4, 0.001, 0.05, 1.0, 40.0, 1024.0, 4000.0, 10000.0, 6e4, 65504.0] {
            let stops = f64::from(shown(&nodes, &gray(light)).at(0, 0)[0]);
            let exposed = f64::from(light).log2() + stops;
            println!("{light:>11}: {:+.4} stops from the key, {nodes:.14}", exposed - 0.18_f64.log2());
            // Half a bin.
            assert!((exposed - 0.18_f64.log2()).abs() < 0.5 * 29.0 / 383.0 + 1e-4, "{light}: {exposed} {nodes}");
        }
        // Darker fields are exposed as the darkest of the range; only exact black is not metered.
        let darkest = 0.18_f64.log2() + 13.0;
        for light in [6e-8, 1e-6, 1e-5, 1e-4] {
            let value = shown(&nodes, &gray(light)).at(0, 0);
            assert!((f64::from(value[0]) - darkest).abs() < 0.5 * 29.0 / 383.0 + 1e-4, "{light}: {value:?}");
        }
        assert_eq!(shown(&nodes, &gray(0.0)).at(0, 0), [0.0; 4]);
    }
}

/// The range of the issue before: what the old defaults make of the ends of the range.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_narrow_range_cuts_flat_fields() {
    let [nodes, _] = meters("bins: 256, lo: -10.0, hi: 10.0, black: 0.0009765625", "min_ev: -4.0, max_ev: 16.0");
    assert_eq!(shown(&nodes, &gray(9e-4)).at(0, 0), [0.0; 4], "it counts as black");
    for (light, wanted) in [(0.001_f32, -3.0), (0.5, 0.0), (4000.0, 2.0), (10000.0, 3.3), (6e4, 5.9)] {
        let stops = f64::from(shown(&nodes, &gray(light)).at(0, 0)[0]);
        let away = f64::from(light).log2() + stops - 0.18_f64.log2();
        assert!((away - wanted).abs() < 0.05, "{light}: {away} stops from the key");
    }
}

/// Six stops from left to right, and a bright square at the top left.
fn uneven(width: u32, height: u32) -> Picture {
    Picture::new(width, height, |x, y| {
        let stops = 6.0 * x as f32 / width as f32 - 3.0 + if x < 9 && y < 7 { 5.0 } else { 0.0 };
        let light = stops.exp2();
        [light, light, light, 1.0]
    })
}

/// The mean of log2 luminance with a weight for each pixel, from its place in uv.
fn weighted_mean(picture: &Picture, weight: impl Fn([f64; 2]) -> f64) -> f64 {
    let image = sanitized(picture);
    let (mut sum, mut total) = (0.0, 0.0);
    for (index, pixel) in image.pixels.iter().enumerate() {
        let uv = center_uv(index % image.width, index / image.width, image.width, image.height);
        sum += weight(uv) * luminance(rgb(*pixel)).log2();
        total += weight(uv);
    }
    sum / total
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn both_meters_weigh_spots_centers_and_masks_alike() {
    let scene = uneven(90, 61);
    let aspect = 90.0 / 61.0;
    let squared = |[u, v]: [f64; 2], [x, y]: [f64; 2]| ((u - x) * aspect).powi(2) + (v - y).powi(2);
    let spot = weighted_mean(&scene, |uv| f64::from(u8::from(squared(uv, [0.25, 0.5]) <= 0.04)));
    let center = weighted_mean(&scene, |uv| (-squared(uv, [0.5, 0.5]) / 0.09).exp2());
    let plain = weighted_mean(&scene, |_| 1.0);
    assert!((spot - plain).abs() > 1.0 && (center - plain).abs() > 0.02, "{spot} {center} {plain}");
    for (reading, wanted) in
        [("", plain), ("weight: Spot, center: (0.25, 0.5), radius: 0.2", spot), ("weight: Center, radius: 0.3", center)]
    {
        for nodes in meters(reading, "") {
            let value = shown(&nodes, &scene).at(0, 0);
            // The histogram's weights are integers up to 255, and its bins are 0.076 stops wide.
            assert!((f64::from(value[1]) - wanted).abs() < 0.01, "{nodes}: {value:?} {wanted}");
        }
    }
    let mask = Picture::new(90, 61, |x, _| [if x < 40 { 1.0 } else { 0.2 }, 0.0, 0.0, 1.0]);
    let masked = weighted_mean(&scene, |[u, _]| if u < 40.0 / 90.0 { 1.0 } else { f64::from(0.2_f32) });
    for nodes in meters("mask: \"mask\"", "") {
        let value = shown_with(&nodes, &scene, "mask", &mask).at(0, 0);
        assert!((f64::from(value[1]) - masked).abs() < 0.01, "{nodes}: {value:?} {masked}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_held_exposure_stays_while_the_reading_follows() {
    let (dim, bright, black) = (gray(0.25), gray(16.0), gray(0.0));
    let frames = [(&black, 0.1, true), (&dim, 0.1, false), (&bright, 9.0, false), (&bright, 0.1, true)];
    for nodes in meters("", "hold: true") {
        let values = sequence(&pipeline(&nodes), &frames);
        assert_eq!(values[0], [0.0; 4]);
        assert!((values[1][0] - (0.18_f32.log2() + 2.0)).abs() < 0.04, "{values:?}");
        assert_eq!(values[2][0], values[1][0], "held");
        assert!((values[2][1] - 4.0).abs() < 0.04, "the reading follows: {values:?}");
        assert!((values[3][0] - (0.18_f32.log2() - 4.0)).abs() < 0.04, "a cut meters anew: {values:?}");
    }
}
