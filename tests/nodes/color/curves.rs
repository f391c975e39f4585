//! Exposure and ToneMap.

use super::{ARITHMETIC, LARGEST, TRANSCENDENTAL, compare, light, rgb, run, tolerance};
use crate::reference::agx;
use crate::reference::color::{AP1, CUSTOM, REC709, REC2020, Space, conversion, luminance};
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
        compare("Exposed", &tone_map(curve), light, TRANSCENDENTAL, each(reference))
    };
    check("None", |x| x);
    check("Reinhard", reinhard);
    check("ReinhardExtended", |x| reinhard_extended(x, 4.0));
    check("ReinhardExtended, white_level: 0.5", |x| reinhard_extended(x, 0.5));
    check("Exponential", |x| exponential(x, 1.0));
    check("Exponential, exposure: 3.5", |x| exponential(x, 3.5));
    check("Aces", narkowicz);
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
fn curves_of_whole_colours_match() {
    let check =
        |curve: &str, reference: fn(Rgb) -> Rgb| compare("Exposed", &tone_map(curve), light, TRANSCENDENTAL, reference);
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
    compare("Exposed", &tone_map("Gt7"), light, TRANSCENDENTAL, |rgb| in_rec2020(rgb, &gt7::sdr, 1.0));
    let hdr = |rgb: Rgb| gt7::hdr(rgb, 1000.0).map(|x| x / 2.5);
    compare("Exposed", &tone_map("Gt7, peak: 4.0"), light, TRANSCENDENTAL, |rgb| in_rec2020(rgb, &hdr, 4.0));
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
            let node = tone_map(&format!("{curve}, space: {name}"));
            compare("Exposed", &node, light, TRANSCENDENTAL, |rgb| in_space(rgb, &space, reference));
        };
        check("Aces", narkowicz);
        check("Uchimura", |x| uchimura(x, &UCHIMURA));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_peak_above_white_lets_light_through() {
    let node = tone_map("None, peak: 12.5");
    compare("Exposed", &node, light, ARITHMETIC, |rgb| rgb.map(|x| x.min(12.5)));
}

/// The distance of a colour from grey, as a share of the distance of the gamut's border.
fn reach(rgb: Rgb) -> f64 {
    let grey = luminance(rgb).clamp(0.0, 1.0);
    let share = |x: f64| if x > grey { (x - grey) / (1.0 - grey) } else { (grey - x) / grey };
    rgb.map(share).into_iter().fold(0.0, f64::max)
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn compression_keeps_inner_colours_and_the_luminance_of_outer_ones() {
    let size = [61, 37];
    // Colours around the middle of the range, up to twice as far from grey as the gamut goes.
    let mut numbers = super::Numbers(77);
    let input = Picture::new(size[0], size[1], |_, _| {
        let grey = 0.1 + 0.7 * numbers.next();
        let [r, g, b] = [0, 1, 2].map(|_| (grey * (0.3 + 1.6 * numbers.next())) as f32);
        [r, g, b, 1.0]
    });
    let output = run("Exposed", &tone_map("None, gamut: Compress, gamut_knee: 0.6"), &NoFiles, &input);
    let (mut inner, mut outer) = (0, 0);
    for (&from, &to) in input.pixels.iter().zip(&output.pixels) {
        let (from, to) = (rgb(from), rgb(to));
        let (was, is) = (reach(from), reach(to));
        if luminance(from) > 0.97 {
            continue;
        }
        let kept = [0, 1, 2].map(|channel| (to[channel] - from[channel]).abs());
        if was <= 0.599 {
            inner += 1;
            assert!(largest(kept) < 1e-6, "{from:?} became {to:?}");
        } else if was > 0.601 {
            outer += 1;
            let expected = 0.6 + (was - 0.6) * 0.4 / (0.4 + was - 0.6);
            assert!((is - expected).abs() < 1e-4, "{from:?} became {to:?}: reach {was} became {is}, not {expected}");
            assert!((luminance(to) - luminance(from)).abs() < 1e-5, "{from:?} became {to:?}");
        }
    }
    assert!(inner > 200 && outer > 500, "{inner} inner and {outer} outer colours");
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
        "Aces",
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
            let node = tone_map(&format!("{curve}, gamut: Compress, gamut_knee: {knee:?}"));
            let output = run("Exposed", &node, &NoFiles, &input);
            let good = output.pixels.iter().flat_map(|p| &p[..3]).all(|x| (0.0..=1.0).contains(x));
            assert!(good, "{node}");
            let black = rgb(output.at(1, 0));
            assert!(largest(black) < 1e-6, "{node} makes {black:?} of black");
            let white = rgb(output.at(3, 0));
            let shift = largest(white) - white[0].min(white[1]).min(white[2]);
            assert!(shift < 1e-3 || curve.contains("Golden"), "{node} makes {white:?} of the brightest grey");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn greys_stay_grey_in_every_space() {
    let ramp = Picture::new(64, 1, |x, _| {
        let grey = (x as f32 * 0.25 - 12.0).exp2();
        [grey, grey, grey, 1.0]
    });
    for space in ["Rec709", "AcesCg", "Tsushima", "Rec2020"] {
        for gamut in ["Clip", "Compress"] {
            let output =
                run("Exposed", &tone_map(&format!("Uchimura, space: {space}, gamut: {gamut}")), &NoFiles, &ramp);
            let expected = image(&ramp).map_rgb(|rgb| display(rgb.map(|x| uchimura(x, &UCHIMURA))));
            let tolerance = tolerance(1e-6, 2e-6, "rounding in f32; the curve of a grey has no error of matrices");
            assert_close(&format!("{space}, {gamut}"), &output, &expected, &tolerance);
        }
    }
}

fn tone_map(curve: &str) -> String {
    format!("ToneMap(curve: {curve})")
}
