//! WhiteBalance, LiftGammaGain, Cdl, Saturation, Contrast, Brightness and ColorBalance.

use super::{ARITHMETIC, TRANSCENDENTAL, compare, light, stored, stored_light, tolerance, unit};
use crate::reference::color::{BRADFORD, CAT16, luminance, white_balance_scene, white_balance_target};
use crate::reference::grade::*;
use crate::reference::math::{Matrix, Rgb, transform, zip};
use crate::reference::sanitize::extended;

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn white_balance_turns_white_into_its_target() {
    let cones: [(&str, &Matrix); 2] = [("Bradford", &BRADFORD), ("Cat16", &CAT16)];
    for (name, cone) in cones {
        for (target, wanted) in [
            ("(1.0, 0.9, 0.7)", [1.0, 0.9, 0.7]),
            ("(0.5, 0.6, 1.0)", [0.5, 0.6, 1.0]),
            ("(0.0, 0.0, 1.0)", [0.0, 0.0, 1.0]),
        ] {
            for keep in [true, false] {
                let node = format!("WhiteBalance(target: {target}, adaptation: {name}, keep_luminance: {keep})");
                let matrix = white_balance_target(cone, wanted.map(|x: f64| f64::from(x as f32)), keep);
                compare("Exposed", &node, light, ARITHMETIC, |rgb| extended(stored(transform(&matrix, rgb))));
            }
        }
        for (kelvin, duv) in
            [(3200.0, 0.0), (5000.0, 0.0), (6504.0, 0.0), (9300.0, 0.01), (2000.0, -0.02), (25000.0, 0.0)]
        {
            let node =
                format!("WhiteBalance(mode: Temperature, temperature: {kelvin:?}, tint: {duv:?}, adaptation: {name})");
            let matrix = white_balance_scene(cone, kelvin, f64::from(duv as f32));
            compare("Color", &node, light, ARITHMETIC, |rgb| extended(stored(transform(&matrix, rgb))));
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn lift_gamma_gain_matches() {
    let text = |v: Rgb| format!("({:?}, {:?}, {:?})", v[0], v[1], v[2]);
    let grades = [
        ([0.1, 0.05, 0.0], [1.0; 3], [1.0; 3]),
        ([0.02, 0.0, -0.02], [1.1, 1.0, 0.9], [1.2, 1.0, 0.8]),
        ([0.0; 3], [2.2; 3], [1.0; 3]),
        ([-0.1; 3], [0.5, 1.0, 3.0], [1.0; 3]),
        ([0.1; 3], [20.0, 0.05, 1.0], [16.0, 1.0, 0.0]),
    ];
    for (lift, gamma, gain) in grades {
        let grade = LiftGammaGain { lift, gamma, gain };
        let rest = format!("lift: {}, gamma: {}, gain: {}", text(lift), text(gamma), text(gain));
        for (state, picture) in [("DisplayLinear", unit as fn([u32; 2]) -> _), ("Exposed", light)] {
            let steep = gamma.iter().any(|gamma| *gamma < 0.5);
            let reason = "a power multiplies the error of its base by the inverse of gamma, at most by 20";
            let tolerance = tolerance(2e-6, if steep { 1e-3 } else { 2e-5 }, reason);
            let node = format!("LiftGammaGain({rest})");
            compare(state, &node, picture, tolerance, |rgb| stored(grade.apply(rgb)));
            let node = format!("LiftGammaGain({rest}, lift_by: Channel)");
            compare(state, &node, picture, tolerance, |rgb| stored(grade.apply_per_channel(rgb)));
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn cdl_matches() {
    let cdl = Cdl { slope: [1.1, 1.0, 0.9], offset: [0.01, 0.0, -0.05], power: [0.9, 1.0, 1.1], saturation: 1.2 };
    let node = "Cdl(slope: (1.1, 1.0, 0.9), offset: (0.01, 0.0, -0.05), power: (0.9, 1.0, 1.1), saturation: 1.2)";
    compare("Encoded", node, unit, TRANSCENDENTAL, |rgb| stored(cdl.apply(rgb)));
    compare("Exposed", node, light, tolerance(2e-6, 2e-5, "the offset is rounded to f32 before the power"), |rgb| {
        // The power ends at the largest half float, before the saturation.
        let own = Cdl { saturation: 1.0, ..cdl };
        stored(saturation(stored(own.apply(rgb)), 1.2))
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn saturation_matches() {
    for amount in [0.0, 0.5, 2.5] {
        let node = format!("Saturation(amount: {amount:?})");
        compare("Exposed", &node, light, ARITHMETIC, |rgb| extended(stored(saturation(rgb, amount))));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn contrast_matches_in_both_forms() {
    for (amount, pivot) in [(1.5, 0.18), (0.5, 0.18), (3.0, 1.0), (8.0, 0.01), (0.0, 0.18)] {
        let values = format!("amount: {amount:?}, pivot: {pivot:?}");
        let tolerance = tolerance(2e-6, 1e-5 * (1.0 + amount), "the power multiplies the error of its base");
        let pivot = f64::from(pivot as f32);
        compare("Exposed", &format!("Contrast({values})"), light, tolerance, |rgb| {
            stored_light(rgb.map(|x| contrast_log(x, amount, pivot)))
        });
        compare("Encoded", &format!("Contrast(form: Linear, {values})"), unit, ARITHMETIC, |rgb| {
            stored_light(rgb.map(|x| contrast(x, amount, pivot)))
        });
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn brightness_adds() {
    for amount in [0.1, -0.3] {
        let node = format!("Brightness(amount: {amount:?})");
        compare("Encoded", &node, unit, ARITHMETIC, |rgb| stored_light(rgb.map(|x| brightness(x, amount))));
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn color_balance_tints_by_luminance() {
    let multiply = [1.1, 1.0, 0.9];
    let shifts = [[0.1, 0.0, -0.1], [0.0, 0.05, 0.0], [-0.05, 0.0, 0.2]];
    let node = |keep: bool| {
        format!(
            "ColorBalance(multiply: (1.1, 1.0, 0.9), shadows: (0.1, 0.0, -0.1), midtones: (0.0, 0.05, 0.0), \
             highlights: (-0.05, 0.0, 0.2), keep_luminance: {keep})"
        )
    };
    for keep in [true, false] {
        compare("Encoded", &node(keep), unit, ARITHMETIC, |rgb| {
            let scaled = balance(rgb, multiply);
            let y = luminance(scaled).clamp(0.0, 1.0);
            let weights = [(1.0 - y) * (1.0 - y), 2.0 * y * (1.0 - y), y * y];
            let tint = |shift: Rgb| if keep { shift.map(|x| x - luminance(shift)) } else { shift };
            let sum = (0..3).fold(scaled, |sum, range| zip(sum, tint(shifts[range]), |a, b| a + weights[range] * b));
            stored_light(sum)
        });
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn d65_is_the_identity_to_a_millionth() {
    // Just beside the neutral temperature's name the matrix is computed, and still all but the identity.
    let node = "WhiteBalance(target: (0.7, 0.7, 0.70000005))";
    compare("Exposed", node, unit, tolerance(1e-6, 0.0, "the matrix is the identity to a millionth"), |rgb| rgb);
}
