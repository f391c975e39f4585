// Sums of weighted colors in half floats, if the options ask for them and the device supports them. Otherwise in
// 32-bit floats without conversion: the linker sets `real` and REAL_IS_HALF.
// The largest half float is 65504, and a color may have this value. So sums are of quarters: four colors can be added
// before they are weighted, and rounded weights whose sum is slightly above 1 do not overflow. More than four colors
// must not share a weight, because a compiler may add them before it applies the weight.
#import sanitize

// The scalar and vector types of such sums.
alias real = f32;
alias real2 = vec2<real>;
alias real3 = vec3<real>;
alias real4 = vec4<real>;
// Whether they are half floats.
const REAL_IS_HALF: bool = false;

// Converts a color for a sum.
fn to_real(v: vec4f) -> real4 {
    if REAL_IS_HALF { return real4(0.25 * v); }
    return real4(v);
}

// Converts a weighted sum back to a color.
fn of_real(v: real4) -> vec4f {
    if REAL_IS_HALF { return clamp(4.0 * vec4f(v), vec4f(-HALF_MAX), vec4f(HALF_MAX)); }
    return vec4f(v);
}

// Two weights that sum to 1, also after rounding.
fn real_shares(shares: vec2f) -> real2 {
    if REAL_IS_HALF { return real2(real(shares.x), 1.0 - real(shares.x)); }
    return real2(shares);
}
