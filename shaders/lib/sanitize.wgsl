// Makes an outside value finite by looking at its bits: a WGSL compiler may assume that no NaN or infinity happens,
// so `x != x` and `max(x, 0)` prove nothing.

// The largest finite half float, the bound of every image that kernels read.
const HALF_MAX: f32 = 65504.0;

// Its bits. Bits of positive floats are in the order of the floats, infinity and NaN last.
const HALF_MAX_BITS: u32 = 0x477fe000u;
const INFINITY_BITS: u32 = 0x7f800000u;
const SIGN_BIT: u32 = 0x80000000u;

// NaN becomes 0, infinities and large values the bound, negatives 0. All negatives and NaN have bits above those of infinity.
fn sanitize(v: vec4f) -> vec4f {
    let bits = bitcast<vec4u>(v);
    let bounded = min(bits, vec4u(HALF_MAX_BITS));
    return bitcast<vec4f>(select(bounded, vec4u(), bits > vec4u(INFINITY_BITS)));
}

// The same for data and wide-gamut colour, which may be negative.
fn sanitize_signed(v: vec4f) -> vec4f {
    let bits = bitcast<vec4u>(v);
    let magnitude = bits & vec4u(~SIGN_BIT);
    let bounded = min(magnitude, vec4u(HALF_MAX_BITS)) | (bits & vec4u(SIGN_BIT));
    return bitcast<vec4f>(select(bounded, vec4u(), magnitude > vec4u(INFINITY_BITS)));
}
