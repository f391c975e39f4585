//! BakedGrade against the nodes that it bakes.

use super::{light, run};
use crate::reference::color::{AP1, BRADFORD, CUSTOM, REC709, Space, conversion, white_balance_target};
use crate::reference::curves::*;
use crate::reference::grade::LiftGammaGain;
use crate::reference::math::{Rgb, transform};
use crate::reference::oklab::{fitted, with_hue};
use crate::reference::transfer::srgb_encode;
use crate::reference::{agx, math};
use crate::support::gpu::Picture;
use crate::support::harness::Nodes;
use afterimage_graph::check::NoFiles;

const GRADE: LiftGammaGain = LiftGammaGain { lift: [0.01, 0.0, 0.0], gamma: [1.05, 1.0, 1.0], gain: [1.0, 1.0, 1.02] };

/// The chain in f64, in 8-bit codes before rounding.
fn codes(rgb: Rgb, curve: &dyn Fn(Rgb) -> Rgb) -> Rgb {
    let target = [1.0, 0.93, 0.82].map(|x: f64| f64::from(x as f32));
    let balanced = transform(&white_balance_target(&BRADFORD, target, true), rgb).map(|x| x.max(0.0));
    GRADE.apply(curve(balanced)).map(|x| 255.0 * srgb_encode(x.min(1.0)))
}

/// Colors of the formula book's population A: each channel on its own, log-uniform from 1e-4 to 60.
fn population() -> Picture {
    let mut numbers = super::Numbers(0x1234_5678_9abc_def1);
    let (low, high) = (1e-4_f64.log2(), 60.0_f64.log2());
    super::picture([128, 100], move |_| [0, 1, 2].map(|_| (low + (high - low) * numbers.next()).exp2()))
}

/// The error that 99 of 100 channels stay below, and the largest, in codes.
fn error(rest: &str, curve: &dyn Fn(Rgb) -> Rgb) -> (f64, f64) {
    let input = population();
    let grade = "target: (1.0, 0.93, 0.82), lift: (0.01, 0.0, 0.0), gamma: (1.05, 1.0, 1.0), gain: (1.0, 1.0, 1.02)";
    let output = run("Exposed", &format!("BakedGrade({grade}, {rest})"), &NoFiles, &input);
    let difference = |(&from, &to): (&[f32; 4], &[f32; 4])| {
        math::zip(codes(super::rgb(from), curve), super::rgb(to), |wanted, found| (wanted - 255.0 * found).abs())
    };
    let mut errors: Vec<f64> = input.pixels.iter().zip(&output.pixels).flat_map(difference).collect();
    errors.sort_by(f64::total_cmp);
    (errors[errors.len() * 99 / 100], errors[errors.len() - 1])
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_error_is_what_the_manual_says() {
    let finish = |mapped: Rgb, light: Rgb| fitted(with_hue(mapped, light), 1.0, f64::from(0.8_f32));
    let channel = |space: &'static Space, curve: fn(f64) -> f64| {
        let (scale, enter, leave) = (matched_scale(curve), conversion(&REC709, space), conversion(space, &REC709));
        move |rgb: Rgb| {
            let inside = transform(&enter, rgb).map(|x| curve(scale * x.max(0.0)));
            finish(transform(&leave, inside), rgb)
        }
    };
    let uchimura = channel(&CUSTOM, |x| uchimura(x, &UCHIMURA));
    let tone_scale = channel(&AP1, |x| aces2_tone_scale(x, 100.0));
    let aces = channel(&AP1, narkowicz);
    let agx = |rgb: Rgb| agx::linear(rgb, agx::sigmoid, &agx::BASE);
    let agx_scale = matched_scale(|x| agx([x; 3])[1]);
    let agx = |rgb: Rgb| finish(agx(rgb.map(|x| agx_scale * x)), rgb);
    let neutral = |rgb: Rgb| pbr_neutral(rgb, 0.8, 0.15);
    let neutral_scale = matched_scale(|x| neutral([x; 3])[1]);
    let neutral = |rgb: Rgb| finish(neutral(rgb.map(|x| neutral_scale * x)), rgb);
    type Case<'a> = (&'a str, &'a dyn Fn(Rgb) -> Rgb, f64, f64);
    let cases: [Case<'_>; 8] = [
        ("", &tone_scale, 0.6, 8.0),
        ("curve: Uchimura, space: Tsushima", &uchimura, 0.96, 17.0),
        ("curve: AcesNarkowicz", &aces, 0.7, 11.0),
        ("curve: AgX", &agx, 0.62, 6.0),
        ("curve: KhronosNeutral", &neutral, 1.5, 9.0),
        ("curve: KhronosNeutral, interpolation: Tetrahedral", &neutral, 0.9, 9.0),
        ("curve: Uchimura, space: Tsushima, size: 32", &uchimura, 3.4, 27.0),
        ("curve: Uchimura, space: Tsushima, shaper: Log2", &uchimura, 1.6, 26.0),
    ];
    let mut above = String::new();
    for (rest, curve, most_of, largest) in cases {
        let (found, worst) = error(rest, curve);
        if found > most_of || worst > largest {
            above += &format!("{rest}: 99 % below {found:.2}, largest {worst:.2}\n");
        }
        assert!(found > 0.01, "{rest}: a table of half floats cannot be as close as {found}");
    }
    assert!(above.is_empty(), "{above}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn the_table_works_in_the_primaries_of_its_display() {
    let input = population();
    let grade = "lift: (0.01, 0.0, 0.0), gamma: (1.05, 1.0, 1.0)";
    // The errors are those of interpolation where the gamut bends: the wider the display, the fewer colors are there.
    for (primaries, limit, largest) in [("Rec709", 4.0, 20.0), ("DisplayP3", 1.4, 9.0), ("Rec2020", 0.6, 6.0)] {
        let nodes = format!(
            r#""mapped": ToneMap(source: "in"), "graded": LiftGammaGain(source: "mapped", {grade}),
            "result": Encode(source: "graded", primaries: {primaries})"#
        );
        let wanted = Nodes::new(&nodes, &[("in", "Exposed")]).exact(&[&input]);
        let found = run("Exposed", &format!("BakedGrade(primaries: {primaries}, {grade})"), &NoFiles, &input);
        let pairs = wanted.pixels.iter().zip(&found.pixels).flat_map(|(a, b)| [0, 1, 2].map(|c| (a[c], b[c])));
        let mut errors: Vec<f32> = pairs.map(|(wanted, found)| 255.0 * (wanted - found).abs()).collect();
        errors.sort_by(f32::total_cmp);
        let (most, worst) = (errors[errors.len() * 99 / 100], errors[errors.len() - 1]);
        assert!(most < limit && worst < largest, "{primaries}: 99 % below {most}, largest {worst}");
        // Another display has another signal: the parameter has an effect.
        let other = run("Exposed", &format!("BakedGrade({grade})"), &NoFiles, &input);
        assert_eq!(other.pixels == found.pixels, primaries == "Rec709", "{primaries}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn extremes_stay_finite_and_in_range() {
    let input = light([61, 37]);
    for rest in
        ["", "shaper: Log2", "interpolation: Tetrahedral", "transfer: Linear, size: 8", "transfer: Gamma, curve: Gt7"]
    {
        let output = run("Exposed", &format!("BakedGrade({rest})"), &NoFiles, &input);
        assert!(output.pixels.iter().flat_map(|p| &p[..3]).all(|x| (0.0..=1.0).contains(x)), "{rest}");
        let black = super::rgb(output.at(1, 0));
        assert!(math::largest(black) < 2e-3, "{rest}: black is {black:?}");
        assert!(output.at(3, 0)[1] > 0.97, "{rest}: the brightest white is {:?}", output.at(3, 0));
    }
}
