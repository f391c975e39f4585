//! Encode.

use super::{ARITHMETIC, TRANSCENDENTAL, Tolerance, compare, light, tolerance, unit};
use crate::reference::color::{P3_D65, REC709, REC2020, Space, conversion};
use crate::reference::math::{Rgb, diagonal, transform};
use crate::reference::transfer::*;

fn clamped(rgb: Rgb, high: f64) -> Rgb {
    rgb.map(|x| x.clamp(0.0, high))
}

/// A power has no linear part near black: it turns the rounding of a matrix, 1e-11 of a bright channel, into 3e-5.
const NEAR_BLACK: Tolerance = Tolerance {
    absolute: 3e-5,
    reason: "a pure power amplifies the rounding of the matrix near black",
    ..TRANSCENDENTAL
};

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn sdr_transfer_functions_match_in_all_primaries() {
    let primaries: [(&str, Space); 3] = [("Rec709", REC709), ("DisplayP3", P3_D65), ("Rec2020", REC2020)];
    for (name, space) in primaries {
        let matrix = if space == REC709 { diagonal([1.0; 3]) } else { conversion(&REC709, &space) };
        let check = |transfer: &str, tolerance: Tolerance, reference: fn(f64) -> f64| {
            let node = format!("Encode(primaries: {name}, transfer: {transfer})");
            for picture in [unit, light] {
                compare("DisplayLinear", &node, picture, tolerance, |rgb| {
                    clamped(transform(&matrix, rgb), 1.0).map(reference)
                });
            }
        };
        check("Linear", ARITHMETIC, |x| x);
        check("Srgb", TRANSCENDENTAL, srgb_encode);
        check("Gamma", NEAR_BLACK, |x| gamma_encode(x, 2.2));
        check("Gamma, gamma: 2.4", NEAR_BLACK, |x| gamma_encode(x, 2.4));
    }
}

/// PQ in 32 bits by the quotient would be 1.2e-5 off; by the logarithm it has the tolerance of every other function.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn pq_is_exact_in_32_bits() {
    for (white, peak) in [(203.0, 1000.0), (100.0, 10000.0), (400.0, 100.0)] {
        let node = format!("Encode(transfer: Pq, primaries: Rec2020, white_nits: {white:?}, peak_nits: {peak:?})");
        let matrix = conversion(&REC709, &REC2020);
        for picture in [unit, light] {
            compare("DisplayLinear", &node, picture, TRANSCENDENTAL, |rgb| {
                clamped(transform(&matrix, rgb).map(|x| x * white), peak).map(pq_encode)
            });
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn hlg_matches_at_every_peak() {
    for (white, peak) in [(203.0, 1000.0), (203.0, 400.0), (100.0, 100.0), (203.0, 4000.0)] {
        let node = format!("Encode(transfer: Hlg, primaries: Rec2020, white_nits: {white:?}, peak_nits: {peak:?})");
        let matrix = conversion(&REC709, &REC2020);
        for picture in [unit, light] {
            let reason = "the logarithm is steep at black, where the system gamma is a power of a small number";
            let tolerance = tolerance(1e-5, 2e-5, reason);
            compare("DisplayLinear", &node, picture, tolerance, |rgb| {
                let nits = clamped(transform(&matrix, rgb).map(|x| x * white), peak);
                clamped(hlg_encode_clipped(nits, peak), 1.0)
            });
        }
    }
}

/// The CPU reference, for displays whose scene light would exceed the range of the signal.
fn hlg_encode_clipped(nits: Rgb, peak: f64) -> Rgb {
    hlg_encode(nits, peak).map(|x| x.min(hlg_oetf(1.0)))
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn reference_white_has_the_levels_of_bt_2408() {
    let white = crate::support::gpu::Picture::new(1, 1, |_, _| [1.0; 4]);
    let level = |transfer: &str| {
        let node = format!("Encode(transfer: {transfer}, primaries: Rec2020)");
        f64::from(super::run("DisplayLinear", &node, &afterimage_graph::check::NoFiles, &white).at(0, 0)[1])
    };
    assert!((level("Hlg") - 0.749877365).abs() < 1e-5, "{}", level("Hlg"));
    assert!((level("Pq") - 0.580688881).abs() < 1e-5, "{}", level("Pq"));
}
