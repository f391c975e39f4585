//! The range that AutoExposure measures, and the local tone mapping that follows it.

use super::sequence;
use crate::nodes::probes::{pipeline, shown};
use crate::support::gpu::{Picture, Run, built_in};

const METER: &str = "\"h\": Histogram(source: \"scene\"), \"auto\": AutoExposure(histogram: \"h\", PARAMETERS)";

/// As many stops from left to right, with the middle at a luminance of 1.
fn ramp(stops: f32) -> Picture {
    Picture::new(256, 16, |x, _| {
        let light = (stops * ((x as f32 + 0.5) / 256.0 - 0.5)).exp2();
        [light, light, light, 1.0]
    })
}

/// The result of a node on the ramp, after the meter.
fn on_ramp(stops: f32, parameters: &str, result: &str) -> Picture {
    shown(&format!("{}, {result}", METER.replace("PARAMETERS", parameters)), &ramp(stops))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_range_is_the_distance_of_two_parts_in_stops() {
    // A bin of the histogram is 29 stops over 383.
    let bin = 29.0 / 383.0;
    for (stops, parameters, wanted) in [
        (10.0, "", 9.0),
        (10.0, "dark: 0.0, bright: 1.0", 10.0),
        (10.0, "dark: 0.5, bright: 0.75", 2.5),
        (10.0, "dark: 0.9, bright: 0.1", 0.0),
        (2.0, "", 1.8),
    ] {
        let range = on_ramp(stops, parameters, "\"result\": ShowValue(value: \"auto.range\")").at(0, 0);
        assert!((range[0] - wanted).abs() < bin, "{stops} {parameters}: {range:?}");
        assert_eq!(range[3], 1.0);
        assert!(wanted == 0.0 || (range[2] - range[1] - range[0]).abs() < 1e-5, "{range:?}");
    }
    let black = Picture::new(5, 3, |_, _| [0.0, 0.0, 0.0, 1.0]);
    let nodes = format!("{}, \"result\": ShowValue(value: \"auto.range\")", METER.replace("PARAMETERS", ""));
    assert_eq!(shown(&nodes, &black).at(0, 0), [0.0; 4]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_range_follows_the_scene_exponentially_and_a_reset_sets_it() {
    let nodes = |parameters| {
        pipeline(&format!("{}, \"result\": ShowValue(value: \"auto.range\")", METER.replace("PARAMETERS", parameters)))
    };
    let (wide, narrow, black) = (ramp(10.0), ramp(4.0), Picture::new(256, 16, |_, _| [0.0, 0.0, 0.0, 1.0]));
    let frames =
        [(&wide, 0.0, true), (&narrow, 0.5, false), (&black, 0.5, false), (&narrow, 0.0, false), (&narrow, 1.0, true)];
    let found = sequence(&nodes("rate_dark: 2.0"), &frames);
    let [first, last] = [found[0][0], found[4][0]];
    // After one time constant, 1/e of the way is left.
    let wanted = last + (first - last) * (-1.0_f32).exp();
    assert!((found[1][0] - wanted).abs() < 1e-4, "{found:?}");
    assert!(found[2] == found[1] && found[3][0] == found[1][0], "black and no time change nothing: {found:?}");
    assert!((last - 3.6).abs() < 0.08);
    let held = sequence(&nodes("hold: true"), &frames);
    assert_eq!((held[1][0], held[3][0]), (held[0][0], held[0][0]));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn contrast_between_regions_follows_the_range() {
    let local = |parameters: &str, stops: f32| {
        let exposed = "\"exposed\": Exposure(source: \"scene\")";
        let grid = "\"grid\": GridBuild(source: \"exposed\"), \"smooth\": GridBlur(source: \"grid\")";
        let result = format!("\"result\": LocalToneMap(source: \"exposed\", grid: \"smooth\", {parameters})");
        on_ramp(stops, "dark: 0.0, bright: 1.0", &format!("{exposed}, {grid}, {result}"))
    };
    let apart = |one: &Picture, other: &Picture| {
        let pairs = one.pixels.iter().zip(&other.pixels);
        pairs.map(|(one, other)| (one[0] / other[0]).log2().abs()).fold(0.0, f32::max)
    };
    for (stops, span, contrast) in [(8.0, 4.0, 0.5), (8.0, 6.0, 0.75), (8.0, 1.0, 0.25), (3.0, 5.0, 1.0)] {
        let ranged = local(&format!("range: \"auto.range\", span: {span:?}, contrast: 0.25"), stops);
        let fixed = local(&format!("contrast: {contrast:?}"), stops);
        // A bin of 0.08 stops changes the contrast by one part in a hundred, and the ends by 0.04 stops.
        assert!(apart(&ranged, &fixed) < 0.05, "{stops} {span}: {} stops", apart(&ranged, &fixed));
    }
    let other = local("contrast: 0.25", 8.0);
    assert!(apart(&local("range: \"auto.range\", span: 6.0, contrast: 0.25", 8.0), &other) > 1.0);
}

/// A picture from -6 to 0 stops with a lamp that fills a share of it.
fn with_lamp(share: f32, light: f32) -> Picture {
    const SIZE: [u32; 2] = [200, 100];
    let pixels = (share * (SIZE[0] * SIZE[1]) as f32).round() as u32;
    Picture::new(SIZE[0], SIZE[1], |x, y| {
        let is_lamp = x >= 160 && y * 40 + x - 160 < pixels;
        let light = if is_lamp { light } else { (6.0 * x as f32 / 199.0 - 6.0).exp2() };
        [light, light, light, 1.0]
    })
}

/// The judge is the law: what fills one more thousandth of the picture changes the rest of it by little, wherever it
/// stands. The dark half is far below the lamp.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
#[expect(clippy::print_stdout, reason = "the figures say how good the pipelines are")]
fn a_lamp_that_grows_changes_the_tone_in_small_steps() {
    for name in ["tsushima.ron", "cinematic.ron", "tsushima-night.ron"] {
        let graph = built_in(name, None);
        let run = Run::new(&graph);
        for light in [20.0, 10000.0] {
            let pictures: Vec<Picture> = (0..=25).map(|step| with_lamp(0.002 * step as f32, light)).collect();
            let codes: Vec<f32> = pictures
                .iter()
                .map(|picture| {
                    let shown = run.frame(&[("scene", picture)]).remove(0);
                    let dark = (60..100).flat_map(|y| (10..100).map(move |x| (x, y)));
                    dark.map(|(x, y)| 255.0 * shown.at(x, y)[1]).sum::<f32>() / 3600.0
                })
                .collect();
            println!("{name}, a lamp of {light}: {codes:.1?}");
            let largest = codes.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
            let all = codes.iter().fold(0.0_f32, |most, code| most.max((code - codes[0]).abs()));
            assert!(largest < 2.5 && largest < 0.2 * all + 0.5, "{name}, {light}: {largest} of {all}: {codes:?}");
        }
    }
}
