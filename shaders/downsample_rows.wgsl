// Halvings by a row of invocations that moves down the image. Each invocation has one column of squares: the four
// texels under one texel of the result. Every tap of the filter is the mean of a square, or of the four texels where
// four squares meet. Both are computed once and shared with the neighbors through workgroup memory, as half floats.

const DOWNSAMPLE_ROWS_INVOCATIONS: u32 = 64u;

// The state of an invocation: parts of the square above, and of the corner to its upper right.
struct DownsampleRows {
    lower_left: vec4f,
    lower_right: vec4f,
    mean: vec4f,
    inner: vec4f,   // of the four texels at the corner
    outer: vec4f,   // of the four squares around the corner, times its weight
    weight: f32,
}

// Values for the neighbors: two vectors to the left in slots 0 to 3; two vectors and a weight to the right in slots 4
// to 8. A slot has one number per invocation, contiguous, so that neighbors access different banks.
var<workgroup> downsample_rows_handed: array<u32, 9u * DOWNSAMPLE_ROWS_INVOCATIONS>;

const DOWNSAMPLE_ROWS_LEFT: u32 = 0u;
const DOWNSAMPLE_ROWS_LEFT_SECOND: u32 = 2u * DOWNSAMPLE_ROWS_INVOCATIONS;
const DOWNSAMPLE_ROWS_RIGHT: u32 = 4u * DOWNSAMPLE_ROWS_INVOCATIONS;
const DOWNSAMPLE_ROWS_RIGHT_SECOND: u32 = 6u * DOWNSAMPLE_ROWS_INVOCATIONS;
const DOWNSAMPLE_ROWS_RIGHT_WEIGHT: u32 = 8u * DOWNSAMPLE_ROWS_INVOCATIONS;

fn downsample_rows_put(slot: u32, v: vec4f) {
    downsample_rows_handed[slot] = pack2x16float(v.xy);
    downsample_rows_handed[slot + DOWNSAMPLE_ROWS_INVOCATIONS] = pack2x16float(v.zw);
}

fn downsample_rows_take(slot: u32) -> vec4f {
    let lower = unpack2x16float(downsample_rows_handed[slot]);
    return vec4f(lower, unpack2x16float(downsample_rows_handed[slot + DOWNSAMPLE_ROWS_INVOCATIONS]));
}

// A square and its mean.
struct DownsampleRowsSquare {
    upper_left: vec4f,
    upper_right: vec4f,
    lower_left: vec4f,
    lower_right: vec4f,
    mean: vec4f,
}

fn downsample_rows_square(square: Square) -> DownsampleRowsSquare {
    let mean = 0.25 * (square.upper_left + square.upper_right + (square.lower_left + square.lower_right));
    return DownsampleRowsSquare(square.upper_left, square.upper_right, square.lower_left, square.lower_right, mean);
}

// The neighbors of an invocation. The outermost ones have no neighbor on one side; their results are not used.
fn downsample_rows_after(invocation: u32) -> u32 {
    return min(invocation + 1u, DOWNSAMPLE_ROWS_INVOCATIONS - 1u);
}

fn downsample_rows_before(invocation: u32) -> u32 {
    return max(invocation, 1u) - 1u;
}

// These functions return the texel of the previous row. The mean of a square needs no neighbor.
fn downsample_rows_box(state: ptr<function, DownsampleRows>, texels: Square, invocation: u32) -> vec4f {
    let above = (*state).mean;
    (*state).mean = downsample_rows_square(texels).mean;
    return above;
}

// The mean of the four corners.
fn downsample_rows_tap4(state: ptr<function, DownsampleRows>, texels: Square, invocation: u32) -> vec4f {
    let square = downsample_rows_square(texels);
    downsample_rows_put(DOWNSAMPLE_ROWS_LEFT + invocation, 0.25 * ((*state).lower_left + square.upper_left));
    workgroupBarrier();
    let here = 0.25 * ((*state).lower_right + square.upper_right);
    let corner = 0.25 * (here + downsample_rows_take(DOWNSAMPLE_ROWS_LEFT + downsample_rows_after(invocation)));
    let edge = corner + (*state).inner;
    downsample_rows_put(DOWNSAMPLE_ROWS_RIGHT + invocation, edge);
    workgroupBarrier();
    (*state).lower_left = square.lower_left;
    (*state).lower_right = square.lower_right;
    (*state).inner = corner;
    return edge + downsample_rows_take(DOWNSAMPLE_ROWS_RIGHT + downsample_rows_before(invocation));
}

fn downsample_rows_tap13(state: ptr<function, DownsampleRows>, texels: Square, invocation: u32) -> vec4f {
    let square = downsample_rows_square(texels);
    let means = square.mean + (*state).mean;
    let edge_left = 0.25 * ((*state).lower_left + square.upper_left + means);
    downsample_rows_put(DOWNSAMPLE_ROWS_LEFT + invocation, edge_left);
    workgroupBarrier();
    let here = 0.25 * ((*state).lower_right + square.upper_right + means);
    let corner = 0.125 * (here + downsample_rows_take(DOWNSAMPLE_ROWS_LEFT + downsample_rows_after(invocation)));
    let edge = corner + (*state).inner;
    downsample_rows_put(DOWNSAMPLE_ROWS_RIGHT + invocation, edge);
    workgroupBarrier();
    (*state).lower_left = square.lower_left;
    (*state).lower_right = square.lower_right;
    (*state).mean = square.mean;
    (*state).inner = corner;
    return edge + downsample_rows_take(DOWNSAMPLE_ROWS_RIGHT + downsample_rows_before(invocation));
}

// 1 / (1 + brightness), as for the taps.
fn downsample_rows_weight(color: vec4f) -> f32 {
    return 1.0 / (1.0 + max(max(color.r, max(color.g, color.b)), 0.0));
}

// Thirteen taps with the five squares of the filter weighted against each other. The inner one counts four times.
fn downsample_rows_tap13_groups(state: ptr<function, DownsampleRows>, texels: Square, invocation: u32) -> vec4f {
    let square = downsample_rows_square(texels);
    let left = 0.25 * ((*state).lower_left + square.upper_left);
    let means = 0.25 * ((*state).mean + square.mean);
    downsample_rows_put(DOWNSAMPLE_ROWS_LEFT + invocation, left);
    downsample_rows_put(DOWNSAMPLE_ROWS_LEFT_SECOND + invocation, means);
    workgroupBarrier();
    let after = downsample_rows_after(invocation);
    let right = 0.25 * ((*state).lower_right + square.upper_right);
    let inner = right + downsample_rows_take(DOWNSAMPLE_ROWS_LEFT + after);
    let squares = means + downsample_rows_take(DOWNSAMPLE_ROWS_LEFT_SECOND + after);
    let weight = downsample_rows_weight(squares);
    let outer = squares * weight;
    let inner_edge = 0.25 * ((*state).inner + inner);
    let outer_edge = (*state).outer + outer;
    let weight_edge = (*state).weight + weight;
    downsample_rows_put(DOWNSAMPLE_ROWS_RIGHT + invocation, inner_edge);
    downsample_rows_put(DOWNSAMPLE_ROWS_RIGHT_SECOND + invocation, outer_edge);
    downsample_rows_handed[DOWNSAMPLE_ROWS_RIGHT_WEIGHT + invocation] = bitcast<u32>(weight_edge);
    workgroupBarrier();
    (*state) = DownsampleRows(square.lower_left, square.lower_right, square.mean, inner, outer, weight);
    let before = downsample_rows_before(invocation);
    let middle = inner_edge + downsample_rows_take(DOWNSAMPLE_ROWS_RIGHT + before);
    let middle_weight = 4.0 * downsample_rows_weight(middle);
    let sum = middle * middle_weight + outer_edge + downsample_rows_take(DOWNSAMPLE_ROWS_RIGHT_SECOND + before);
    let weight_before = bitcast<f32>(downsample_rows_handed[DOWNSAMPLE_ROWS_RIGHT_WEIGHT + before]);
    let weights = middle_weight + weight_edge + weight_before;
    return sum * (1.0 / weights);
}

// The weights 1 3 3 1 along each axis: down in each column of the square, with what the square before has left, then
// across.
fn downsample_rows_tap9(state: ptr<function, DownsampleRows>, texels: Square, invocation: u32) -> vec4f {
    let left = (*state).inner + texels.upper_left;
    let right = (*state).outer + texels.upper_right;
    (*state).inner = (*state).lower_left + 3.0 * (texels.upper_left + texels.lower_left);
    (*state).outer = (*state).lower_right + 3.0 * (texels.upper_right + texels.lower_right);
    (*state).lower_left = texels.lower_left;
    (*state).lower_right = texels.lower_right;
    let scale = 1.0 / 64.0;
    downsample_rows_put(DOWNSAMPLE_ROWS_LEFT + invocation, scale * left);
    downsample_rows_put(DOWNSAMPLE_ROWS_RIGHT + invocation, scale * right);
    workgroupBarrier();
    let after = downsample_rows_take(DOWNSAMPLE_ROWS_LEFT + downsample_rows_after(invocation));
    let before = downsample_rows_take(DOWNSAMPLE_ROWS_RIGHT + downsample_rows_before(invocation));
    workgroupBarrier();
    return 3.0 * scale * (left + right) + (after + before);
}

// The weights 1 5 10 10 5 1 along each axis: down in each column of the square, with what the squares before have left
// in `inner` and `lower_left` for the left column and in `outer` and `lower_right` for the right one, then across.
fn downsample_rows_binomial(state: ptr<function, DownsampleRows>, texels: Square, invocation: u32) -> vec4f {
    let left = (*state).inner + 5.0 * texels.upper_left + texels.lower_left;
    let right = (*state).outer + 5.0 * texels.upper_right + texels.lower_right;
    (*state).inner = (*state).lower_left + 10.0 * (texels.upper_left + texels.lower_left);
    (*state).outer = (*state).lower_right + 10.0 * (texels.upper_right + texels.lower_right);
    (*state).lower_left = texels.upper_left + 5.0 * texels.lower_left;
    (*state).lower_right = texels.upper_right + 5.0 * texels.lower_right;
    let scale = 1.0 / 1024.0;
    downsample_rows_put(DOWNSAMPLE_ROWS_LEFT + invocation, scale * (5.0 * left + right));
    downsample_rows_put(DOWNSAMPLE_ROWS_RIGHT + invocation, scale * (left + 5.0 * right));
    workgroupBarrier();
    let after = downsample_rows_take(DOWNSAMPLE_ROWS_LEFT + downsample_rows_after(invocation));
    let before = downsample_rows_take(DOWNSAMPLE_ROWS_RIGHT + downsample_rows_before(invocation));
    workgroupBarrier();
    return 10.0 * scale * (left + right) + (after + before);
}
