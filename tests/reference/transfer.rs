//! Transfer functions, quantization and dither (formula book, 3).

use super::color::REC2020;
use super::math::{Rgb, dot, mix};

/// Linear to sRGB (IEC 61966-2-1), for x ≥ 0.
pub(crate) fn srgb_encode(x: f64) -> f64 {
    if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// sRGB to linear (IEC 61966-2-1), for v ≥ 0.
pub(crate) fn srgb_decode(v: f64) -> f64 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// `x^(1/gamma)` of a non-negative x.
pub(crate) fn gamma_encode(x: f64, gamma: f64) -> f64 {
    x.max(0.0).powf(1.0 / gamma)
}

/// `v^gamma` of a non-negative v.
pub(crate) fn gamma_decode(v: f64, gamma: f64) -> f64 {
    v.max(0.0).powf(gamma)
}

const PQ_M1: f64 = 2610.0 / 16384.0;
const PQ_M2: f64 = 2523.0 / 32.0;
const PQ_C1: f64 = 3424.0 / 4096.0;
const PQ_C2: f64 = 2413.0 / 128.0;
const PQ_C3: f64 = 2392.0 / 128.0;

/// cd/m² to PQ (SMPTE ST 2084); 10000 cd/m² is 1.
pub(crate) fn pq_encode(nits: f64) -> f64 {
    let y = (nits.max(0.0) / 10000.0).powf(PQ_M1);
    ((PQ_C1 + PQ_C2 * y) / (1.0 + PQ_C3 * y)).powf(PQ_M2)
}

/// PQ to cd/m² (SMPTE ST 2084).
pub(crate) fn pq_decode(v: f64) -> f64 {
    let root = v.max(0.0).powf(1.0 / PQ_M2);
    10000.0 * ((root - PQ_C1).max(0.0) / (PQ_C2 - PQ_C3 * root)).powf(1.0 / PQ_M1)
}

/// Scene-linear in [0, 1] to HLG (ITU-R BT.2100).
pub(crate) fn hlg_oetf(e: f64) -> f64 {
    let a = 0.17883277;
    let b = 1.0 - 4.0 * a;
    // The standard rounds c to eight digits; so do the published signal levels.
    let c = 0.55991073;
    if e <= 1.0 / 12.0 { (3.0 * e).sqrt() } else { a * (12.0 * e - b).ln() + c }
}

/// The system gamma of an HLG display with a peak of `nits` (ITU-R BT.2100 and BT.2390).
pub(crate) fn hlg_gamma(nits: f64) -> f64 {
    if (400.0..=2000.0).contains(&nits) {
        1.2 + 0.42 * (nits / 1000.0).log10()
    } else {
        1.2 * 1.111_f64.powf((nits / 1000.0).log2())
    }
}

/// Rec.2020 in cd/m², for a display with a peak of `peak` cd/m², to HLG (ITU-R BT.2100).
pub(crate) fn hlg_encode(nits: Rgb, peak: f64) -> Rgb {
    let display = nits.map(|x| x / peak);
    let y = dot(display, super::color::to_xyz(&REC2020)[1]);
    let gamma = hlg_gamma(peak);
    let scale = if y > 0.0 { y.powf((1.0 - gamma) / gamma) } else { 0.0 };
    display.map(|x| hlg_oetf(x * scale))
}

/// The code of `v` in `bits` bits, rounded to nearest.
pub(crate) fn quantize(v: f64, bits: u32) -> f64 {
    (v.clamp(0.0, 1.0) * largest_code(bits) + 0.5).floor()
}

/// The code of `v` in `bits` bits with noise from two uniform numbers in [0, 1): triangular
/// inside, fading to rectangular within half a code of black and white.
pub(crate) fn dither(v: f64, u1: f64, u2: f64, bits: u32) -> f64 {
    let largest = largest_code(bits);
    let inside = (v.min(1.0 - v) * largest / 0.5).clamp(0.0, 1.0);
    let noise = mix(u1 - 0.5, u1 + u2 - 1.0, inside);
    ((v * largest + noise).clamp(0.0, largest) + 0.5).floor()
}

fn largest_code(bits: u32) -> f64 {
    f64::from((1_u32 << bits) - 1)
}

#[test]
fn decoding_undoes_encoding() {
    for i in 0..=1000 {
        let x = f64::from(i) / 1000.0;
        assert!((srgb_decode(srgb_encode(x)) - x).abs() < 1e-7, "{x}");
        assert!((gamma_decode(gamma_encode(x, 2.2), 2.2) - x).abs() < 1e-14, "{x}");
        assert!((pq_decode(pq_encode(10000.0 * x)) - 10000.0 * x).abs() < 1e-7, "{x}");
    }
}

#[test]
fn the_mean_of_dithered_codes_is_the_value() {
    let steps = 200;
    for v in [0.4 / 255.0, 100.3 / 255.0, 254.9 / 255.0, 3.9 / 1023.0] {
        let bits = if v == 3.9 / 1023.0 { 10 } else { 8 };
        let mut sum = 0.0;
        for i in 0..steps * steps {
            let (u1, u2) = (f64::from(i % steps), f64::from(i / steps));
            let at = |u: f64| (u + 0.5) / f64::from(steps);
            sum += dither(v, at(u1), at(u2), bits);
        }
        let mean = sum / f64::from(steps * steps);
        let wanted = v * largest_code(bits);
        // Close to black and white the clamp pulls the mean inwards a little.
        assert!((mean - wanted).abs() < 0.06, "{wanted}: {mean}");
    }
}
