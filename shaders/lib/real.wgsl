// Sums of weighted colors: in half floats where the host asks for them and the device has them, otherwise in `f32`. The framework sets
// the first alias and the constant for each module.
// A half float ends at 65504, which a color may be. So sums are of quarters: four colors can be added before they are weighted, and
// rounded weights that sum to a little more than 1 do no harm. At most four colors may share a weight: compilers may add them up first
// and apply the weight to the sum, whatever the order in the text.
#import sanitize

alias real = f32;
alias real2 = vec2<real>;
alias real3 = vec3<real>;
alias real4 = vec4<real>;
// Whether `real` is a half float. If not, the functions below change nothing.
const REAL_IS_HALF: bool = false;

// A colour on its way into a sum.
fn to_real(v: vec4f) -> real4 {
    if REAL_IS_HALF { return real4(0.25 * v); }
    return real4(v);
}

// The colour that a sum of weighted ones has become.
fn of_real(v: real4) -> vec4f {
    if REAL_IS_HALF { return clamp(4.0 * vec4f(v), vec4f(-HALF_MAX), vec4f(HALF_MAX)); }
    return vec4f(v);
}

// Two weights that sum to 1, and still do where they are rounded.
fn real_shares(shares: vec2f) -> real2 {
    if REAL_IS_HALF { return real2(real(shares.x), 1.0 - real(shares.x)); }
    return real2(shares);
}
