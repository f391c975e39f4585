//! ReferenceGamutCompress and Eetf.

use super::{Numbers, TRANSCENDENTAL, compare, light, picture, rgb, run, tolerance};
use crate::reference::color::{AP1, REC709, REC2020, conversion, luminance};
use crate::reference::gamut::{Eetf, reference_compress};
use crate::reference::gt7::to_ictcp;
use crate::reference::math::{Rgb, largest, transform};
use crate::support::gpu::Picture;
use crate::support::harness::{assert_close, image};
use afterimage_graph::check::NoFiles;

/// Colors of AP0's size: channels of Rec.709 below 0.
fn wide([width, height]: [u32; 2]) -> Picture {
    let mut numbers = Numbers(0x7a31_55e0_c9b8_1f27);
    picture([width, height], move |_| {
        let bright = (10.0 * numbers.next() - 5.0).exp2();
        [0, 1, 2].map(|_| bright * (1.3 * numbers.next() - 0.3))
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_gamut_compression_matches() {
    compare("Exposed", "ReferenceGamutCompress()", light, TRANSCENDENTAL, reference_compress);
    let input = wide([61, 37]);
    let output = run("Exposed", "ReferenceGamutCompress()", &NoFiles, &input);
    let tolerance = tolerance(1e-4, 1e-4, "the distance is a quotient, which is large for dark colors");
    // A color whose largest channel of AP1 is nearly 0 has no defined distance. A negative luminance does not exist.
    let is_lit = |rgb| largest(transform(&conversion(&REC709, &AP1), rgb)) > 0.01 && luminance(rgb) > 1e-3;
    let expected = image(&input).map_rgb(|rgb| if is_lit(rgb) { reference_compress(rgb) } else { [0.0; 3] });
    let lit = |picture: &Picture| {
        Picture::new(61, 37, |x, y| {
            let [.., a] = picture.at(x, y);
            if is_lit(rgb(input.at(x, y))) { picture.at(x, y) } else { [0.0, 0.0, 0.0, a] }
        })
    };
    assert_close("wide colors", &lit(&output), &expected, &tolerance);
    let inside = output.pixels.iter().zip(&input.pixels).filter(|(_, from)| is_lit(rgb(**from)));
    for (to, from) in inside {
        let ap1 = transform(&conversion(&REC709, &AP1), rgb(*to));
        let least = ap1[0].min(ap1[1]).min(ap1[2]);
        assert!(least > -0.35 * largest(ap1), "{from:?} became {ap1:?}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn bt_2390_matches() {
    let tolerance = tolerance(1e-5, 5e-5, "PQ and its inverse in f32");
    for (source_peak, peak, black) in [(1000.0, 600.0, 0.0), (4000.0, 300.0, 0.05), (1000.0, 2000.0, 0.0)] {
        let eetf = Eetf { source_peak, peak, black };
        let parameters =
            format!("source_nits: {source_peak:?}, peak_nits: {peak:?}, black_nits: {black:?}, white_nits: 200.0");
        let scaled = |rgb: [f64; 3], curve: &dyn Fn([f64; 3]) -> [f64; 3]| {
            curve(rgb.map(|x| (200.0 * x).min(source_peak))).map(|x| x / 200.0)
        };
        let input = bright([61, 37]);
        let largest = run("DisplayLinear", &format!("Eetf({parameters})"), &NoFiles, &input);
        let expected = image(&input).map_rgb(|rgb| scaled(rgb, &|nits| eetf.on_largest(nits)));
        assert_close(&format!("{eetf:?}, largest"), &largest, &expected, &tolerance);
        let extremes = run("DisplayLinear", &format!("Eetf({parameters}, on: Extremes)"), &NoFiles, &input);
        let expected = image(&input).map_rgb(|rgb| scaled(rgb, &|nits| eetf.on_extremes(nits)));
        assert_close(&format!("{eetf:?}, extremes"), &extremes, &expected, &tolerance);
    }
}

/// Display-linear Rec.709 of which the largest channel is 1.
const BRIGHT: [(&str, Rgb); 8] = [
    ("skin", [1.0, 0.63, 0.48]),
    ("dark skin", [1.0, 0.53, 0.33]),
    ("wax", [1.0, 0.73, 0.35]),
    ("fire", [1.0, 0.42, 0.05]),
    ("sunset", [1.0, 0.55, 0.22]),
    ("sky", [0.25, 0.5, 1.0]),
    ("leaf", [0.5, 1.0, 0.16]),
    ("blue lamp", [0.08, 0.1, 1.0]),
];

/// The hue of light in ICtCp, in degrees, and its distance from gray.
fn hue_of_nits(nits: Rgb) -> [f64; 2] {
    let [_, t, p] = to_ictcp(transform(&conversion(&REC709, &REC2020), nits).map(|x| x / 100.0));
    [p.atan2(t).to_degrees(), p.hypot(t)]
}

/// The difference of the largest and the smallest channel, as a share of the largest.
fn saturation(rgb: Rgb) -> f64 {
    1.0 - rgb.into_iter().fold(f64::INFINITY, f64::min) / largest(rgb)
}

/// In a space that the node does not use.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn bright_light_becomes_white_in_its_own_hue() {
    let nits = |step: u32| 1000.0 * (f64::from(step) / 20.0 - 5.0).exp2();
    for (name, color) in BRIGHT {
        let ramp = Picture::new(101, 1, |x, _| {
            let [r, g, b] = color.map(|channel| (channel * nits(x) / 203.0) as f32);
            [r, g, b, 1.0]
        });
        let shown = run("DisplayLinear", "Eetf(peak_nits: 203.0, on: Extremes)", &NoFiles, &ramp);
        let shown: Vec<Rgb> = shown.pixels.iter().map(|pixel| rgb(*pixel).map(|x| 203.0 * x)).collect();
        for (pair, step) in shown.windows(2).zip(1..) {
            assert!(luminance(pair[1]) > luminance(pair[0]) - 1e-3, "{name} is darker: {pair:?}");
            assert!(saturation(pair[1]) < saturation(pair[0]) + 1e-4, "{name} has more color: {pair:?}");
            let ([hue, chroma], [wanted, _]) = (hue_of_nits(pair[1]), hue_of_nits(color.map(|x| x * nits(step))));
            let turn = (hue - wanted + 180.0).rem_euclid(360.0) - 180.0;
            assert!(turn.abs() < 5.0 || chroma < 0.02, "{name} of {:.0} nits turns by {turn:.1} degrees", nits(step));
        }
        let [.., last] = shown[..] else { panic!("a ramp") };
        assert!((largest(last) - 203.0).abs() < 0.1, "{name}: {last:?}");
        assert!(saturation(last) < 0.95 * saturation(color), "{name} is as saturated as before: {last:?}");
    }
}

/// Display-linear light up to five times white, with black.
fn bright(size: [u32; 2]) -> Picture {
    let mut numbers = Numbers(0x2b7e_1516_28ae_d2a6);
    picture(size, move |index| if index == 0 { [0.0; 3] } else { [0, 1, 2].map(|_| 5.0 * numbers.next().powi(3)) })
}
