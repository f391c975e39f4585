// Odd sides of the source of a 2x downsample in strips. Filters are sums of boxes that begin and end at
// halves of a texel of the result, so the means over such halves are all that they need: the source, resampled to twice
// the size of the result. Of 2m + 1 texels, half k covers a part of the texels k and k + 1 alone.
import package::math::between;

const HALVES_INVOCATIONS: u32 = 64u;

// The left texels of the squares of two steps, as half floats, so that none is replaced while another invocation still
// reads it.
var<workgroup> halves_handed: array<u32, 8u * HALVES_INVOCATIONS>;

fn halves_put(slot: u32, v: vec4f) {
    halves_handed[slot] = pack2x16float(v.xy);
    halves_handed[slot + HALVES_INVOCATIONS] = pack2x16float(v.zw);
}

fn halves_take(slot: u32) -> vec4f {
    return vec4f(unpack2x16float(halves_handed[slot]), unpack2x16float(halves_handed[slot + HALVES_INVOCATIONS]));
}

// The shares of the latter of two texels in both halves of a texel of the result, one of `count`. Beyond the border the
// two are equal.
fn halves_shares(index: i32, count: i32) -> vec2f {
    return (f32(2 * index) + vec2f(1.0, 2.0)) / f32(2 * count + 1);
}

// The halves across of a column of the result, one of `count`. All invocations must call it, with one `step` that grows
// by 1 from call to call.
fn halves_across(square: Square, column: i32, count: i32, step: i32, invocation: u32) -> Square {
    let slot = u32(step & 1) * 4u * HALVES_INVOCATIONS;
    halves_put(slot + invocation, square.upper_left);
    halves_put(slot + 2u * HALVES_INVOCATIONS + invocation, square.lower_left);
    workgroupBarrier();
    let after = slot + min(invocation + 1u, HALVES_INVOCATIONS - 1u);
    let is_inside = column < count;
    let upper = select(square.upper_right, halves_take(after), is_inside);
    let lower = select(square.lower_right, halves_take(after + 2u * HALVES_INVOCATIONS), is_inside);
    let shares = halves_shares(column, count);
    return Square(
        between(square.upper_left, square.upper_right, shares.x),
        between(square.upper_right, upper, shares.y),
        between(square.lower_left, square.lower_right, shares.x),
        between(square.lower_right, lower, shares.y),
    );
}

// The halves down of a row of the result, one of `count`, from the square of that row, which was given by the call
// before, and the one below it.
fn halves_down(above: ptr<function, Square>, square: Square, row: i32, count: i32) -> Square {
    let shares = halves_shares(row, count);
    let halves = Square(
        between((*above).upper_left, (*above).lower_left, shares.x),
        between((*above).upper_right, (*above).lower_right, shares.x),
        between((*above).lower_left, square.upper_left, shares.y),
        between((*above).lower_right, square.upper_right, shares.y),
    );
    (*above) = square;
    return halves;
}
