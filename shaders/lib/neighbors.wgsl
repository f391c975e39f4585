// The texels around one, in a 2x downsample that changes few texels by their neighbors: a square, the four texels under
// one texel of the result, shows which do not stand out.

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

// The number of a texel that was made at the place `at`, the nearest inside of the image: 0 if its own is beyond.
fn neighbors_known(number: f32, at: vec2i, place: vec2i) -> f32 {
    return select(0.0, number, all(at == place));
}

// Of the texels of a square what the others show: 0 for those that are unknown. Beyond the border of the image, two
// columns or two rows are the same.
fn neighbors_within(numbers: vec4f, are_same: vec2<bool>) -> array<Around, 4> {
    let across = select(numbers, vec4f(), vec4<bool>(are_same.x));
    let down = select(numbers, vec4f(), vec4<bool>(are_same.y));
    let both = select(numbers, vec4f(), vec4<bool>(all(are_same)));
    return array(
        Around(vec3f(), vec2f(0.0, across.y), vec3f(0.0, down.z, both.w)),
        Around(vec3f(), vec2f(across.x, 0.0), vec3f(both.z, down.w, 0.0)),
        Around(vec3f(0.0, down.x, both.y), vec2f(0.0, across.w), vec3f()),
        Around(vec3f(both.x, down.y, 0.0), vec2f(across.z, 0.0), vec3f()),
    );
}

// A texel of a square, in the order of its fields.
fn neighbors_texel(square: Square, index: i32) -> vec4f {
    let upper = select(square.upper_left, square.upper_right, index == 1);
    let lower = select(square.lower_left, square.lower_right, index == 3);
    return select(upper, lower, index > 1);
}

// The square with another texel there.
fn neighbors_put(square: Square, index: i32, texel: vec4f) -> Square {
    return Square(
        select(square.upper_left, texel, index == 0),
        select(square.upper_right, texel, index == 1),
        select(square.lower_left, texel, index == 2),
        select(square.lower_right, texel, index == 3),
    );
}
