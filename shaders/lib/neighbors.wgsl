// The texels around one, shared by the invocations of a 2x downsample in strips: each has a column of squares,
// the four texels under one texel of the result, and goes down by a square at a time.

// A number of each of the eight texels around one, from left to right: 0 beyond the border of the image.
struct Around {
    upper: vec3f,
    beside: vec2f,
    lower: vec3f,
}

// The largest of the numbers; 0 if all are negative.
fn largest_around(around: Around) -> f32 {
    let rows = max(around.upper, around.lower);
    let beside = max(around.beside.x, around.beside.y);
    return max(max(max(rows.x, rows.y), max(rows.z, beside)), 0.0);
}

const NEIGHBORS_INVOCATIONS: u32 = 64u;

// The places of the numbers of an invocation's square, and of the texels to the left and to the right of it. The four
// numbers of a square lie far apart, so that neighbors access different banks.
struct NeighborsPlace {
    own: u32,
    before: u32,
    after: u32,
    is_inside: bool,
    // Of the left and the right texels of a square, whether the image has them.
    has: vec2<bool>,
}

// The numbers of two steps, so that none is replaced while another invocation still reads it.
var<workgroup> neighbors_handed: array<f32, 8u * NEIGHBORS_INVOCATIONS>;

// The place of an invocation with that column of squares, of which `last` is the last one inside. A square next to the
// border consists of texels of the border, and of these the inner ones are treated as inside.
fn neighbors_place(column: i32, last: i32, invocation: u32) -> NeighborsPlace {
    let left = max(invocation, 1u) - 1u;
    let right = min(invocation + 1u, NEIGHBORS_INVOCATIONS - 1u);
    return NeighborsPlace(
        invocation,
        left + select(NEIGHBORS_INVOCATIONS, 0u, column > last),
        right + select(0u, NEIGHBORS_INVOCATIONS, column < 0),
        column >= 0 && column <= last,
        vec2<bool>(column >= 0 && column <= last + 1, column >= -1 && column <= last),
    );
}

// The numbers of a square, of which the image has the right and the lower texels or not.
fn neighbors_inside(numbers: vec4f, has: vec2<bool>) -> vec4f {
    return select(vec4f(), numbers, vec4<bool>(true, has.x, has.y, has.x && has.y));
}

// The numbers of four texels in each of two rows: the outer ones are the neighbors'.
struct NeighborsRows {
    upper: vec4f,
    lower: vec4f,
}

// Shares the numbers of a square: those of the upper texels, then those of the lower ones. All invocations must call
// it, with one `step` that grows by 1 from call to call. Of a row beyond the border no number is used.
fn neighbors_share(numbers: vec4f, is_row: bool, step: i32, place: NeighborsPlace) -> NeighborsRows {
    let slot = u32(step & 1) * 4u * NEIGHBORS_INVOCATIONS;
    let handed = select(vec4f(), numbers, place.is_inside && is_row);
    neighbors_handed[slot + place.own] = handed.x;
    neighbors_handed[slot + place.own + NEIGHBORS_INVOCATIONS] = handed.y;
    neighbors_handed[slot + place.own + 2u * NEIGHBORS_INVOCATIONS] = handed.z;
    neighbors_handed[slot + place.own + 3u * NEIGHBORS_INVOCATIONS] = handed.w;
    workgroupBarrier();
    let own = select(vec4f(), numbers, vec4<bool>(place.has, place.has) & vec4<bool>(is_row));
    let below = slot + 2u * NEIGHBORS_INVOCATIONS;
    return NeighborsRows(
        vec4f(neighbors_handed[slot + place.before], own.xy, neighbors_handed[slot + place.after]),
        vec4f(neighbors_handed[below + place.before], own.zw, neighbors_handed[below + place.after]),
    );
}

// A square, and the numbers in its rows and in the one above.
struct NeighborsSeen {
    square: Square,
    above: vec4f,
    rows: NeighborsRows,
}

// The surroundings of the texels of a square, with the numbers of the row below it.
fn neighbors_of(seen: NeighborsSeen, below: vec4f) -> array<Around, 4> {
    let upper = seen.rows.upper;
    let lower = seen.rows.lower;
    return array(
        Around(seen.above.xyz, upper.xz, lower.xyz),
        Around(seen.above.yzw, upper.yw, lower.yzw),
        Around(upper.xyz, lower.xz, below.xyz),
        Around(upper.yzw, lower.yw, below.yzw),
    );
}

// The upper row of a square twice: the square above the image, if it is the first one.
fn neighbors_upper(square: Square) -> Square {
    return Square(square.upper_left, square.upper_right, square.upper_left, square.upper_right);
}

// The lower row of a square twice: the square below the image, if it is the last one.
fn neighbors_lower(square: Square) -> Square {
    return Square(square.lower_left, square.lower_right, square.lower_left, square.lower_right);
}

// A square with the texels of the border in the place of those beyond it.
fn neighbors_clamped(square: Square, column: i32, last: i32) -> Square {
    if column < 0 {
        return Square(square.upper_right, square.upper_right, square.lower_right, square.lower_right);
    }
    if column > last {
        return Square(square.upper_left, square.upper_left, square.lower_left, square.lower_left);
    }
    return square;
}
