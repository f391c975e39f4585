//! Sanitizing, the Hermite step, transfer functions, quantization and dither.

use super::Op;
use crate::reference::{math, sanitize, transfer};

pub(super) const OPS: &[Op] = &[
    ("sanitize", |case| sanitize::sanitize_rgb(case.rgb()).to_vec()),
    ("smoothstep_guarded", |case| {
        let [low, high, x] = case.array();
        vec![math::smooth_step(low, high, x)]
    }),
    ("srgb_oetf", |case| vec![transfer::srgb_encode(case.number())]),
    ("srgb_eotf", |case| vec![transfer::srgb_decode(case.number())]),
    ("gamma22_encode", |case| vec![transfer::gamma_encode(case.number(), 2.2)]),
    ("pq_oetf", |case| vec![transfer::pq_encode(case.number())]),
    ("pq_eotf", |case| vec![transfer::pq_decode(case.number())]),
    ("hlg_oetf", |case| vec![transfer::hlg_oetf(case.number())]),
    ("hlg_encode_display", |case| transfer::hlg_encode(case.rgb(), 1000.0).to_vec()),
    ("quantize_unorm8", |case| vec![transfer::quantize(case.number(), 8)]),
    ("dither_tpdf_8bit", |case| {
        let [v, u1, u2] = case.array();
        vec![transfer::dither(v, u1, u2, 8)]
    }),
];

#[test]
fn transfer_references_agree_with_the_vectors() {
    super::check(OPS);
}
