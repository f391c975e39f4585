//! Exposure and ToneMap.

use super::{ARITHMETIC, LARGEST, TRANSCENDENTAL, compare, light, rgb, run, tolerance};
use crate::reference::agx;
use crate::reference::color::{AP1, CUSTOM, REC709, REC2020, Space, conversion};
use crate::reference::curves::*;
use crate::reference::gt7;
use crate::reference::math::{Rgb, largest, transform};
use crate::support::gpu::Picture;
use crate::support::harness::{Nodes, assert_close, image};
use afterimage_graph::check::NoFiles;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn exposure_scales_by_powers_of_two() {
    for stops in [-24.0, -1.5, 0.25, 3.0, 24.0_f64] {
        let node = format!("Exposure(stops: {stops:?})");
        compare("Color", &node, light, ARITHMETIC, |rgb| rgb.map(|x| (x * stops.exp2()).min(LARGEST)));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_metered_exposure_adds_its_stops() {
    let text = |stops: f64| {
        format!(
            r#""bins": Histogram(source: "in"),
            "meter": AutoExposure(histogram: "bins"),
            "result": Exposure(source: "in", meter: "meter", stops: {stops:?})"#
        )
    };
    let input = Picture::new(40, 30, |x, _| [0.02 + 0.001 * x as f32, 0.03, 0.01, 1.0]);
    let result = |stops| Nodes::new(&text(stops), &[("in", "Color")]).exact(&[&input]);
    let (plain, brighter) = (result(0.0), result(1.5));
    let gain = f64::from(plain.at(3, 4)[0]) / f64::from(input.at(3, 4)[0]);
    assert!(gain > 2.0 && gain < 20.0, "a dark picture is brightened, not by {gain}");
    let by = |gain: f64| image(&input).map_rgb(|rgb| rgb.map(|x| x * gain));
    assert_close("metered", &plain, &by(gain), &TRANSCENDENTAL);
    assert_close("metered and 1.5 stops", &brighter, &by(gain * 1.5_f64.exp2()), &TRANSCENDENTAL);
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn curves_of_single_channels_match() {
    let each = |curve: fn(f64) -> f64| move |rgb: Rgb| display(rgb.map(curve));
    let check = |curve: &str, reference: fn(f64) -> f64| {
        compare("Exposed", &published_per_channel(curve), light, TRANSCENDENTAL, each(reference))
    };
    check("None", |x| x);
    check("Reinhard", reinhard);
    check("ReinhardExtended", |x| reinhard_extended(x, 4.0));
    check("ReinhardExtended, white_level: 0.5", |x| reinhard_extended(x, 0.5));
    check("Exponential", |x| exponential(x, 1.0));
    check("Exponential, exposure: 3.5", |x| exponential(x, 3.5));
    check("Aces2ToneScale", |x| aces2_tone_scale(x, 100.0));
    check("AcesNarkowicz", narkowicz);
    check("Hable", |x| hable(x, 2.0, 11.2));
    check("Uchimura", |x| uchimura(x, &UCHIMURA));
    check("Uchimura, contrast: 1.05, linear_start: 0.1, toe: 3.0", |x| {
        uchimura(x, &Uchimura { contrast: 1.05, start: 0.1, toe: 3.0, ..UCHIMURA })
    });
    check("Uchimura, pedestal: 0.02, linear_start: 0.0, linear_length: 1.0", |x| {
        uchimura(x, &Uchimura { pedestal: 0.02, start: 0.0, length: 1.0, ..UCHIMURA })
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn curves_of_whole_colors_match() {
    let check = |curve: &str, reference: fn(Rgb) -> Rgb| {
        compare("Exposed", &published(curve), light, TRANSCENDENTAL, reference)
    };
    check("ReinhardLuminance", |rgb| display(reinhard_luminance(rgb, 4.0)));
    check("AcesHill", hill);
    check("KhronosNeutral", |rgb| display(pbr_neutral(rgb, 0.8, 0.15)));
    check("AgX", |rgb| agx::linear(rgb, agx::sigmoid, &agx::BASE));
    check("AgX, look: Punchy", |rgb| agx::linear(rgb, agx::sigmoid, &agx::PUNCHY));
    check("AgX, look: Golden", |rgb| agx::linear(rgb, agx::sigmoid, &agx::GOLDEN));
    check("AgX, sigmoid: Polynomial", |rgb| agx::linear(rgb, agx::polynomial6_constrained, &agx::BASE));
    check("AgX, sigmoid: Polynomial, look: Punchy", |rgb| agx::linear(rgb, agx::polynomial6_constrained, &agx::PUNCHY));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn gt7_matches_for_sdr_and_hdr() {
    let in_rec2020 = |rgb: Rgb, curve: &dyn Fn(Rgb) -> Rgb, peak: f64| {
        let mapped = curve(transform(&conversion(&REC709, &REC2020), rgb));
        transform(&conversion(&REC2020, &REC709), mapped).map(|x| x.clamp(0.0, peak))
    };
    let sdr = published("Gt7");
    compare("Exposed", &sdr, light, TRANSCENDENTAL, |rgb| in_rec2020(rgb, &gt7::sdr, 1.0));
    for peak in [4.0, 40.0] {
        let shown = |rgb: Rgb| gt7::hdr(rgb, 250.0 * peak).map(|x| x / 2.5);
        let node = published(&format!("Gt7, peak: {peak:?}"));
        compare("Exposed", &node, light, TRANSCENDENTAL, |rgb| in_rec2020(rgb, &shown, peak));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn agx_matches_for_hdr() {
    for peak in [1.5, 4.926, 50.0] {
        let node = published(&format!("AgX, peak: {peak:?}"));
        let peak = f64::from(peak as f32);
        compare("Exposed", &node, light, TRANSCENDENTAL, |rgb| {
            let mapped = agx::hdr(transform(&conversion(&REC709, &REC2020), rgb), peak);
            transform(&conversion(&REC2020, &REC709), mapped).map(|x| x.clamp(0.0, peak))
        });
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn curves_work_in_other_primaries() {
    let spaces: [(&str, Space); 4] = [
        ("AcesCg", AP1),
        ("Tsushima", CUSTOM),
        ("Rec2020", REC2020),
        (
            "Custom, red: (0.68, 0.32), white: (0.3127, 0.329)",
            Space { red: [0.68, 0.32], white: [0.3127, 0.3290], ..AP1 },
        ),
    ];
    for (name, space) in spaces {
        let check = |curve: &str, reference: fn(f64) -> f64| {
            let node = published(&format!("{curve}, space: {name}"));
            compare("Exposed", &node, light, TRANSCENDENTAL, |rgb| in_space(rgb, &space, reference));
        };
        check("AcesNarkowicz", narkowicz);
        check("Uchimura", |x| uchimura(x, &UCHIMURA));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_peak_above_white_lets_light_through() {
    let node = published_per_channel("None, peak: 12.5");
    compare("Exposed", &node, light, ARITHMETIC, |rgb| rgb.map(|x| x.min(12.5)));
    let node = published_per_channel("Aces2ToneScale, peak: 10.0");
    compare("Exposed", &node, light, TRANSCENDENTAL, |rgb| rgb.map(|x| aces2_tone_scale(x, 1000.0).min(10.0)));
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn every_curve_and_gamut_stays_finite_and_in_range() {
    let input = light([61, 37]);
    let curves = [
        "None",
        "Reinhard",
        "ReinhardExtended",
        "ReinhardLuminance",
        "Exponential",
        "Aces2ToneScale",
        "AcesNarkowicz",
        "AcesHill",
        "Hable",
        "Uchimura",
        "KhronosNeutral",
        "AgX",
        "AgX, look: Golden",
        "AgX, sigmoid: Polynomial",
        "AgX, sigmoid: Polynomial, look: Golden",
        "Gt7",
    ];
    for curve in curves {
        for knee in [0.0, 0.8, 1.0] {
            let node = format!("ToneMap(curve: {curve}, gamut_knee: {knee:?})");
            let output = run("Exposed", &node, &NoFiles, &input);
            let good = output.pixels.iter().flat_map(|p| &p[..3]).all(|x| (0.0..=1.0).contains(x));
            assert!(good, "{node}");
            let black = rgb(output.at(1, 0));
            assert!(largest(black) < 1e-6, "{node} makes {black:?} of black");
            let white = rgb(output.at(3, 0));
            let shift = largest(white) - white[0].min(white[1]).min(white[2]);
            assert!(shift < 1e-3 || curve.contains("Golden"), "{node} makes {white:?} of the brightest gray");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn grays_stay_gray_in_every_space() {
    let ramp = Picture::new(64, 1, |x, _| {
        let gray = (x as f32 * 0.25 - 12.0).exp2();
        [gray, gray, gray, 1.0]
    });
    for space in ["Rec709", "AcesCg", "Tsushima", "Rec2020"] {
        for gamut in ["Clip", "Compress"] {
            let node = format!("ToneMap(curve: Uchimura, space: {space}, gamut: {gamut}, middle_gray: Native)");
            let output = run("Exposed", &node, &NoFiles, &ramp);
            let expected = image(&ramp).map_rgb(|rgb| display(rgb.map(|x| uchimura(x, &UCHIMURA))));
            let tolerance = tolerance(2e-6, 1e-5, "cube roots in f32; the curve of a gray has no error of matrices");
            assert_close(&format!("{space}, {gamut}"), &output, &expected, &tolerance);
        }
    }
}

/// A curve as published: with its own exposure and hues, and clipped.
fn published(curve: &str) -> String {
    format!("ToneMap(curve: {curve}, middle_gray: Native, keep_hue: 0.0, gamut: Clip)")
}

/// A curve that works per channel as published, in the primaries of the image.
fn published_per_channel(curve: &str) -> String {
    published(&format!("{curve}, space: Rec709"))
}
