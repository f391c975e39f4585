// Sums of weighted colours in half floats, where the host has asked for them and the device has them; in floats of 32 bits, and then
// nothing is done here at all. The composer defines before this text
// `real`, `real2`, `real3`, `real4`   the numbers of such sums and vectors of them;
// REAL_IS_HALF                        whether they are half floats.
// A half float ends at 65504, which a colour may be. So sums are of quarters: four colours can be added before they are weighed, and
// rounded weights that sum to a little more than 1 do no harm. More than four colours must not share a weight: compilers may add them
// up first and weigh the sum, whatever is written.
#import sanitize

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
