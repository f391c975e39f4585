//! Lift-gamma-gain, the CDL, the simple operators, and the vignette.

use super::{Case, Op, number};
use crate::reference::grade::{Cdl, LiftGammaGain, balance, brightness, contrast, contrast_log, gamma};
use crate::reference::vignette;

pub(super) const OPS: &[Op] = &[
    ("lgg", |case| {
        let grade =
            LiftGammaGain { lift: case.part_rgb("lift"), gamma: case.part_rgb("gamma"), gain: case.part_rgb("gain") };
        grade.apply(case.part_rgb("rgb")).to_vec()
    }),
    ("asc_cdl", |case| {
        let list = Cdl {
            slope: case.part_rgb("slope"),
            offset: case.part_rgb("offset"),
            power: case.part_rgb("power"),
            saturation: case.part_number("sat"),
        };
        list.apply(case.part_rgb("rgb")).to_vec()
    }),
    ("brightness_contrast_gamma_balance", simple),
    ("vignette", |case| {
        let [u, v, intensity, smoothness] = case.array();
        vec![vignette::factor([u, v], intensity, smoothness, 1.0)]
    }),
];

fn simple(case: &Case) -> Vec<f64> {
    let (x, k) = (case.part("x"), case.part("k"));
    match super::word(case.part("op")) {
        "brightness" => vec![brightness(number(x), number(k))],
        "contrast" => vec![contrast(number(x), number(k), case.part_number("pivot"))],
        "contrast_log" => vec![contrast_log(number(x), number(k), case.part_number("pivot"))],
        "gamma" => vec![gamma(number(x), number(k))],
        "balance" => balance(case.part_rgb("x"), case.part_rgb("k")).to_vec(),
        other => panic!("no operator is called `{other}`"),
    }
}

#[test]
fn grade_references_agree_with_the_vectors() {
    super::check(OPS);
}
