//! Rows of metering.

use super::{Reference, smooth};
use crate::nodes::color::tolerance;
use crate::nodes::metering::{BINS, LIMITS};
use crate::reference::color::luminance;
use crate::reference::exposure::{auto_exposure_stops, limit_mean, pyramid_mean};
use crate::reference::image::{Image, rgb};
use crate::support::gpu::Picture;
use crate::support::harness::{Scale, Tolerance};

/// A flat picture at the center of a bin: rounding moves no pixel to another bin.
fn in_one_bin([width, height]: [u32; 2]) -> Picture {
    let light = BINS.center(150).exp2() as f32;
    Picture::new(width, height, |_, _| [light, light, light, 1.0])
}

/// The one pixel that a probe shows of an exposure: stops within the default limits of EV100, the metered mean in log2,
/// the illuminance, 1.
fn exposure(mean: f64) -> Image {
    let lux = std::f64::consts::PI / 0.18 * mean.exp2();
    Image::new(1, 1, |_, _| [auto_exposure_stops(limit_mean(mean, LIMITS[0], LIMITS[1]), 0.18, 0.0), mean, lux, 1.0])
}

/// The words of a histogram: the brightest channel, the range, the number of bins; then counts, low and high halves.
fn histogram_image(image: &Image) -> Image {
    let brightest = image.pixels.iter().flat_map(|pixel| rgb(*pixel)).fold(0.0, f64::max);
    let header = [brightest, BINS.low, BINS.high, BINS.count as f64].map(|word| [word, 0.0, 0.0, 0.0]);
    let counts = BINS.histogram(image).into_iter();
    let counts = counts.map(|count| [f64::from(count & 0xffff), f64::from(count >> 16), 0.0, 0.0]);
    Image { width: 4 + BINS.count, height: 1, pixels: header.into_iter().chain(counts).collect() }
}

pub(super) fn metering_kinds() -> Vec<Reference> {
    let histogram = "\"bins\": Histogram(source: \"scene\")";
    let logarithm = Tolerance { of: Scale::Channel, ..tolerance(2e-4, 1e-4, "sums of logarithms in fixed point") };
    let mean = |image: &Image| {
        let lights: Vec<f64> = image.pixels.iter().map(|pixel| luminance(rgb(*pixel))).collect();
        pyramid_mean(&lights, BINS.low)
    };
    let metered = "\"mean\": MeanLuminance(source: \"scene\"), \"value\": Adapt(mean: \"mean\"), \
                   \"result\": ProbeValue(value: \"value\")";
    vec![
        Reference::new(
            ("Histogram", "Color"),
            &format!("{histogram}, \"result\": ProbeTable(table: \"bins\")"),
            in_one_bin,
            tolerance(0.0, 0.0, "integers"),
            histogram_image,
        ),
        Reference::new(
            ("AutoExposure", "Color"),
            &format!(
                "{histogram}, \"value\": AutoExposure(histogram: \"bins\"), \"result\": ProbeValue(value: \"value\")"
            ),
            in_one_bin,
            logarithm,
            |_| exposure(BINS.center(150)),
        ),
        Reference::new(("MeanLuminance", "Color"), metered, smooth, logarithm, move |image| exposure(mean(image))),
        Reference::new(("Adapt", "Color"), metered, smooth, logarithm, move |image| exposure(mean(image))),
    ]
}
