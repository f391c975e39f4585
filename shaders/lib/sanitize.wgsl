// Makes numbers of host images finite by bit tests: a WGSL compiler may assume that NaN and infinity do not occur,
// so `x != x` and `max(x, 0)` are not reliable.
import package::color::extended_light;

// The largest finite half float: the limit of all images that kernels read.
const HALF_MAX: f32 = 65504.0;

// Its bits. The bits of positive floats have the order of the floats, with infinity and NaN last.
const HALF_MAX_BITS: u32 = 0x477fe000u;
const INFINITY_BITS: u32 = 0x7f800000u;
const SIGN_BIT: u32 = 0x80000000u;

// NaN becomes 0, infinity and large values become the limit, negatives become 0. A NaN gets here only if no neighbor
// of its pixel is finite: see `sanitize_texel`. The bits of negatives and of NaN are greater than those of infinity.
fn sanitize(v: vec4f) -> vec4f {
    let bits = bitcast<vec4u>(v);
    let bounded = min(bits, vec4u(HALF_MAX_BITS));
    return bitcast<vec4f>(select(bounded, vec4u(), bits > vec4u(INFINITY_BITS)));
}

// True if each number is neither infinite nor NaN.
fn is_finite(bits: vec4u) -> vec4<bool> {
    return (bits & vec4u(INFINITY_BITS)) != vec4u(INFINITY_BITS);
}

// For data and logarithms, which may be negative.
fn sanitize_signed(v: vec4f) -> vec4f {
    let bits = bitcast<vec4u>(v);
    let magnitude = bits & vec4u(~SIGN_BIT);
    let bounded = min(magnitude, vec4u(HALF_MAX_BITS)) | (bits & vec4u(SIGN_BIT));
    return bitcast<vec4f>(select(bounded, vec4u(), magnitude > vec4u(INFINITY_BITS)));
}

// For scene light, which may have negative components: see `extended_light`. NaN and negative infinity become 0.
fn sanitize_light(v: vec4f) -> vec4f {
    let is_lost = bitcast<vec4u>(v) == vec4u(INFINITY_BITS | SIGN_BIT);
    let bounded = select(sanitize_signed(v), vec4f(), is_lost);
    return vec4f(extended_light(bounded.rgb), max(bounded.a, 0.0));
}
