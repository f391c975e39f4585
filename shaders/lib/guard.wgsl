// Makes an outside value finite by looking at its bits: a WGSL compiler may assume that no NaN or infinity happens,
// so `x != x` and `max(x, 0)` prove nothing.

// The largest finite half float, the bound of every image that kernels read.
const GUARD_MAX: f32 = 65504.0;

fn guard_channel(x: f32, lowest: f32) -> f32 {
    let magnitude = bitcast<u32>(x) & 0x7fffffffu;
    let is_nan = magnitude > 0x7f800000u;
    let is_infinite = magnitude == 0x7f800000u;
    let is_negative = (bitcast<u32>(x) >> 31u) == 1u;
    let bound = select(GUARD_MAX, lowest, is_negative);
    let finite = clamp(select(x, 0.0, is_infinite), lowest, GUARD_MAX);
    return select(select(finite, bound, is_infinite), 0.0, is_nan);
}

// NaN becomes 0, infinities and large values the bound, negatives 0.
fn guard(v: vec4f) -> vec4f {
    return vec4f(guard_channel(v.x, 0.0), guard_channel(v.y, 0.0), guard_channel(v.z, 0.0), guard_channel(v.w, 0.0));
}

// The same for data and wide-gamut colour, which may be negative.
fn guard_signed(v: vec4f) -> vec4f {
    return vec4f(
        guard_channel(v.x, -GUARD_MAX),
        guard_channel(v.y, -GUARD_MAX),
        guard_channel(v.z, -GUARD_MAX),
        guard_channel(v.w, -GUARD_MAX),
    );
}
