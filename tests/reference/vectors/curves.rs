//! Tone curves, by channel, by color and in a working space.

use super::Op;
use crate::reference::color::{AP1, CUSTOM};
use crate::reference::curves::{
    UCHIMURA, Uchimura, exponential, hable, hill, in_space, narkowicz, pbr_neutral, reinhard, reinhard_extended,
    reinhard_luminance, uchimura,
};
use crate::reference::{agx, gt7};

/// The parameters of the vectors named after a book.
const BOOK: Uchimura = Uchimura { contrast: 1.05, start: 0.1, length: 0.8, toe: 3.0, ..UCHIMURA };

pub(super) const OPS: &[Op] = &[
    ("tm_reinhard", |case| vec![reinhard(case.number())]),
    ("tm_reinhard_ext_rgb_W4", |case| vec![reinhard_extended(case.number(), 4.0)]),
    ("tm_reinhard_ext_lum_W4", |case| reinhard_luminance(case.rgb(), 4.0).to_vec()),
    ("tm_exposure_curve_e1", |case| vec![exponential(case.number(), 1.0)]),
    ("tm_narkowicz", |case| vec![narkowicz(case.number())]),
    ("tm_hill", |case| hill(case.rgb()).to_vec()),
    ("tm_hable_b2_W11.2", |case| vec![hable(case.number(), 2.0, 11.2)]),
    ("tm_uchimura_default", |case| vec![uchimura(case.number(), &UCHIMURA)]),
    ("tm_uchimura_book", |case| vec![uchimura(case.number(), &BOOK)]),
    ("tm_pbr_neutral", |case| pbr_neutral(case.rgb(), 0.8, 0.15).to_vec()),
    ("agx_sigmoid_exact", |case| vec![agx::sigmoid(case.number())]),
    ("agx_poly6", |case| vec![agx::polynomial6(case.number())]),
    ("agx_poly7", |case| vec![agx::polynomial7(case.number())]),
    ("agx_poly6_constrained", |case| vec![agx::polynomial6_constrained(case.number())]),
    ("tm_agx_encoded", |case| agx::encoded(case.rgb(), agx::sigmoid, &agx::BASE).to_vec()),
    ("tm_agx_linear", |case| agx::linear(case.rgb(), agx::sigmoid, &agx::BASE).to_vec()),
    ("tm_agx_punchy_linear", |case| agx::linear(case.rgb(), agx::sigmoid, &agx::PUNCHY).to_vec()),
    ("tm_agx_golden_linear", |case| agx::linear(case.rgb(), agx::sigmoid, &agx::GOLDEN).to_vec()),
    ("tm_gt7_curve_250nit", |case| vec![gt7::curve(case.number(), 2.5)]),
    ("tm_gt7_curve_1000nit", |case| vec![gt7::curve(case.number(), 10.0)]),
    ("tm_gt7_sdr_rec2020", |case| gt7::sdr(case.rgb()).to_vec()),
    ("tm_gt7_hdr1000_rec2020", |case| gt7::hdr(case.rgb(), 1000.0).to_vec()),
    ("tm_narkowicz_custom_space", |case| in_space(case.rgb(), &CUSTOM, narkowicz).to_vec()),
    ("tm_uchimura_custom_space", |case| in_space(case.rgb(), &CUSTOM, |x| uchimura(x, &UCHIMURA)).to_vec()),
    ("tm_uchimura_ap1", |case| in_space(case.rgb(), &AP1, |x| uchimura(x, &UCHIMURA)).to_vec()),
];

#[test]
fn curve_references_agree_with_the_vectors() {
    super::check(OPS);
}
