// Transfer functions. Every argument must be finite; each function states its range.
import package::math::power;

// The end of sRGB's linear part.
const SRGB_LINE: f32 = 0.0031308;

// Linear 0..1 to sRGB, by the exact definition (IEC 61966-2-1).
fn srgb_encode(x: f32) -> f32 {
    return select(1.055 * pow(max(x, SRGB_LINE), 1.0 / 2.4) - 0.055, 12.92 * x, x <= SRGB_LINE);
}

fn srgb_encode3(v: vec3f) -> vec3f {
    return vec3f(srgb_encode(v.x), srgb_encode(v.y), srgb_encode(v.z));
}

// sRGB 0..1 to linear, by the exact definition.
fn srgb_decode(x: f32) -> f32 {
    return select(pow((max(x, 0.04045) + 0.055) / 1.055, 2.4), x / 12.92, x <= 0.04045);
}

const PQ_M1: f32 = 0.1593017578125;
const PQ_M2: f32 = 78.84375;
const PQ_C1: f32 = 0.8359375;
const PQ_C3: f32 = 18.6875;

// log(1 - d) for d < 1. The built-in loses all digits for small d.
fn log_one_minus(d: f32) -> f32 {
    let series = -d * (1.0 + d * (1.0 / 2.0 + d * (1.0 / 3.0 + d * (1.0 / 4.0 + d * (1.0 / 5.0 + d / 6.0)))));
    return select(log(max(1.0 - d, 1e-30)), series, abs(d) < 0.05);
}

// Luminance in cd/m2, 0 or more, to PQ (SMPTE ST 2084); 10000 gives 1. The quotient of the standard is 1 - d, because
// C1 = C3 - C2 + 1. Its 79th power through log(1 - d) is 75 times more accurate in 32 bits.
fn pq_encode(nits: f32) -> f32 {
    let y = power(nits * 1e-4, PQ_M1);
    let d = (1.0 - PQ_C1) * (1.0 - y) / (1.0 + PQ_C3 * y);
    return exp(PQ_M2 * log_one_minus(d));
}

// PQ to cd/m2. Up to 1 by the standard, up to 1.2 by the same curve, constant beyond. q is 1 - v^(1/M2), by series.
fn pq_decode(v: f32) -> f32 {
    let w = -log(clamp(v, 7.4e-7, 1.2)) / PQ_M2;
    let q = w * (1.0 - w / 2.0 * (1.0 - w / 3.0 * (1.0 - w / 4.0 * (1.0 - w / 5.0 * (1.0 - w / 6.0)))));
    return 10000.0 * power((1.0 - PQ_C1 - q) / (1.0 - PQ_C1 + PQ_C3 * q), 1.0 / PQ_M1);
}

const HLG_A: f32 = 0.17883277;
const HLG_B: f32 = 0.28466892;
const HLG_C: f32 = 0.55991073;

// Linear scene light 0..1 to HLG (ITU-R BT.2100).
fn hlg_encode(e: f32) -> f32 {
    return select(HLG_A * log(max(12.0 * e - HLG_B, 1e-3)) + HLG_C, sqrt(3.0 * max(e, 0.0)), e <= 1.0 / 12.0);
}

// HLG, 0..1, to linear scene light.
fn hlg_decode(v: f32) -> f32 {
    return select((exp((v - HLG_C) / HLG_A) + HLG_B) / 12.0, v * v / 3.0, v <= 0.5);
}
