//! Whole pipelines on one pixel, from sanitizing to the code of an 8-bit display.

use super::{Case, Op};
use crate::reference::bloom::{composite_add, composite_lerp};
use crate::reference::color::{BRADFORD, CUSTOM, white_balance_target};
use crate::reference::curves::{UCHIMURA, display, exponential, in_space, narkowicz, pbr_neutral, uchimura};
use crate::reference::exposure::auto_exposure_stops;
use crate::reference::grade::LiftGammaGain;
use crate::reference::local::{Range, scale};
use crate::reference::math::{Rgb, transform};
use crate::reference::purkinje::{full, strength_log};
use crate::reference::sanitize::{MAX_HALF, sanitize, sanitize_rgb};
use crate::reference::transfer::srgb_encode;

pub(super) const OPS: &[Op] = &[
    ("pipeline_ghost", |case| codes(ghost(scene(case)))),
    ("pipeline_lynx", |case| {
        let glowing = composite_add(scene(case), [0.3, 0.2, 0.1], 0.5);
        codes(glowing.map(|x| narkowicz(1.2 * x)))
    }),
    ("pipeline_caracal", |case| codes(composite_add(scene(case), [0.0, 0.2, 0.18], 0.5).map(narkowicz))),
    ("pipeline_cookbook", |case| {
        let exposed = scene(case).map(|x| x * 0.18 / 0.5);
        codes(pbr_neutral(composite_add(exposed, [0.2; 3], 0.05), 0.8, 0.15))
    }),
    ("pipeline_course", |case| codes(composite_add(scene(case).map(|x| exponential(x, 1.0)), [0.05; 3], 1.0))),
];

fn scene(case: &Case) -> Rgb {
    sanitize_rgb(case.rgb())
}

/// 8-bit sRGB codes before rounding.
fn codes(rgb: Rgb) -> Vec<f64> {
    display(rgb).map(|x| 255.0 * srgb_encode(x)).to_vec()
}

/// Metering, night vision, local tone mapping, bloom, white balance, curve and grade.
fn ghost(scene: Rgb) -> Rgb {
    let gain = auto_exposure_stops(-1.0, 0.18, 0.0).exp2();
    let exposed = scene.map(|x| sanitize(x * gain, MAX_HALF));
    let seen = full(exposed, strength_log(100.0), 380.0);

    let l = Range { low: -8.0, high: 8.0 }.log_luminance(seen);
    let local = scale(l, -1.5, 0.18_f64.log2(), 0.5, 1.0);
    let glowing = composite_lerp(seen.map(|x| x * local), [0.2; 3], 0.1);

    let balance = white_balance_target(&BRADFORD, [1.0, 0.93, 0.82], true);
    let balanced = transform(&balance, glowing).map(|x| x.max(0.0));
    let mapped = in_space(balanced, &CUSTOM, |x| uchimura(x, &UCHIMURA));
    LiftGammaGain { lift: [0.01, 0.0, 0.0], gamma: [1.05, 1.0, 1.0], gain: [1.0, 1.0, 1.02] }.apply(mapped)
}

#[test]
fn whole_pipelines_agree_with_the_vectors() {
    super::check(OPS);
}
