// Halves an image. Offsets are in texels of the source. At exactly 2:1 every tap falls on a corner between four texels
// and is their mean. The weights of every filter sum to 1; alpha is filtered like color.
import afterimage::color::brightest;
import afterimage::tent::tent_weight;

struct Downsample {
    edge: f32,   // 1 if the nearest texel lies beyond the border, and 0 if the image is open
}

// A weighted sum of colors.
struct DownsampleSum {
    color: vec4f,
    weight: f32,
}

// The thirteen taps as five overlapping squares of four: Jimenez, "Next Generation Post Processing in Call of Duty:
// Advanced Warfare", SIGGRAPH 2014.
struct DownsampleGroups {
    center: vec4f,
    corners: array<vec4f, 4>,
}

fn downsample_tap(
    source: texture_2d<f32>,
    source_sampler: sampler,
    at: Point,
    x: f32,
    y: f32,
    params: Downsample,
) -> vec4f {
    let size = vec2f(textureDimensions(source));
    let place = at.uv * size + vec2f(x, y);
    let inside = max(tap_inside(place, size), vec2f(params.edge));
    return inside.x * inside.y * tap(source, source_sampler, place / size);
}

// The mean of four taps at 1 texel from (x, y) along both axes.
fn downsample_square(
    source: texture_2d<f32>,
    source_sampler: sampler,
    at: Point,
    x: f32,
    y: f32,
    params: Downsample,
) -> vec4f {
    let upper = downsample_tap(source, source_sampler, at, x - 1.0, y - 1.0, params)
        + downsample_tap(source, source_sampler, at, x + 1.0, y - 1.0, params);
    let lower = downsample_tap(source, source_sampler, at, x - 1.0, y + 1.0, params)
        + downsample_tap(source, source_sampler, at, x + 1.0, y + 1.0, params);
    return 0.25 * (upper + lower);
}

fn downsample_groups(
    source: texture_2d<f32>,
    source_sampler: sampler,
    at: Point,
    params: Downsample,
) -> DownsampleGroups {
    // Rows from the top; each at x = -2, 0 and 2 texels.
    let a = downsample_tap(source, source_sampler, at, -2.0, -2.0, params);
    let b = downsample_tap(source, source_sampler, at, 0.0, -2.0, params);
    let c = downsample_tap(source, source_sampler, at, 2.0, -2.0, params);
    let d = downsample_tap(source, source_sampler, at, -2.0, 0.0, params);
    let e = downsample_tap(source, source_sampler, at, 0.0, 0.0, params);
    let f = downsample_tap(source, source_sampler, at, 2.0, 0.0, params);
    let g = downsample_tap(source, source_sampler, at, -2.0, 2.0, params);
    let h = downsample_tap(source, source_sampler, at, 0.0, 2.0, params);
    let i = downsample_tap(source, source_sampler, at, 2.0, 2.0, params);
    let corners = array(0.25 * (a + b + d + e), 0.25 * (b + c + e + f), 0.25 * (d + e + g + h), 0.25 * (e + f + h + i));
    return DownsampleGroups(downsample_square(source, source_sampler, at, 0.0, 0.0, params), corners);
}

// Adds a color with the weight 1 / (1 + brightness of `around`).
fn downsample_add_among(sum: ptr<function, DownsampleSum>, color: vec4f, around: vec4f, share: f32) {
    let weight = share / (1.0 + max(brightest(around.rgb), 0.0));
    (*sum).color += color * weight;
    (*sum).weight += weight;
}

// Adds a color with the weight 1 / (1 + brightness), so that one very bright pixel does not flicker in all levels:
// Karis, "Tone Mapping", 2013.
fn downsample_add(sum: ptr<function, DownsampleSum>, color: vec4f, share: f32) {
    downsample_add_among(sum, color, color, share);
}

fn downsample_box(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    return tap(source, source_sampler, at.uv);
}

fn downsample_tap4(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Downsample) -> vec4f {
    return downsample_square(source, source_sampler, at, 0.0, 0.0, params);
}

// Weights 1 3 3 1 of texels along each axis: a tap 3/4 of a texel from the center weighs two as 3 to 1.
fn downsample_tap9(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Downsample) -> vec4f {
    let upper = downsample_tap(source, source_sampler, at, -0.75, -0.75, params)
        + downsample_tap(source, source_sampler, at, 0.75, -0.75, params);
    let lower = downsample_tap(source, source_sampler, at, -0.75, 0.75, params)
        + downsample_tap(source, source_sampler, at, 0.75, 0.75, params);
    return 0.25 * (upper + lower);
}

fn downsample_tap13(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Downsample) -> vec4f {
    let groups = downsample_groups(source, source_sampler, at, params);
    let upper = groups.corners[0] + groups.corners[1];
    let around = upper + groups.corners[2] + groups.corners[3];
    return 0.5 * groups.center + 0.125 * around;
}

// Weights 1 5 10 10 5 1 of texels along each axis: a tap between two texels weighs both, and those at the ends are 5/3
// texels from the center.
fn downsample_binomial(
    source: texture_2d<f32>,
    source_sampler: sampler,
    at: Point,
    params: Downsample,
) -> vec4f {
    let low = downsample_binomial_row(source, source_sampler, at, -5.0 / 3.0, params);
    let high = downsample_binomial_row(source, source_sampler, at, 5.0 / 3.0, params);
    return 0.1875 * (low + high) + 0.625 * downsample_binomial_row(source, source_sampler, at, 0.0, params);
}

fn downsample_binomial_row(
    source: texture_2d<f32>,
    source_sampler: sampler,
    at: Point,
    y: f32,
    params: Downsample,
) -> vec4f {
    let left = downsample_tap(source, source_sampler, at, -5.0 / 3.0, y, params);
    let right = downsample_tap(source, source_sampler, at, 5.0 / 3.0, y, params);
    return 0.1875 * (left + right) + 0.625 * downsample_tap(source, source_sampler, at, 0.0, y, params);
}

// A box is a single read, so its four texels are weighted instead.
fn downsample_box_taps(source: texture_2d<f32>, at: Point) -> vec4f {
    let p = at.uv * vec2f(textureDimensions(source)) - 0.5;
    let base = floor(p);
    let right = p - base;
    var sum = DownsampleSum();
    for (var y = 0; y <= 1; y++) {
        for (var x = 0; x <= 1; x++) {
            let share = select(1.0 - right, right, vec2(x, y) == vec2i(1));
            downsample_add(&sum, texel(source, vec2i(base) + vec2i(x, y)), share.x * share.y);
        }
    }
    return sum.color / sum.weight;
}

fn downsample_tap4_taps(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Downsample) -> vec4f {
    var sum = DownsampleSum();
    for (var y = -1; y <= 1; y += 2) {
        for (var x = -1; x <= 1; x += 2) {
            downsample_add(&sum, downsample_tap(source, source_sampler, at, f32(x), f32(y), params), 0.25);
        }
    }
    return sum.color / sum.weight;
}

fn downsample_tap9_taps(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Downsample) -> vec4f {
    var sum = DownsampleSum();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let color = downsample_tap(source, source_sampler, at, f32(x), f32(y), params);
            downsample_add(&sum, color, tent_weight(x, y));
        }
    }
    return sum.color / sum.weight;
}

fn downsample_tap13_taps(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Downsample) -> vec4f {
    var sum = DownsampleSum();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let spread = downsample_tap(source, source_sampler, at, 2.0 * f32(x), 2.0 * f32(y), params);
            downsample_add(&sum, spread, 0.5 * tent_weight(x, y));
        }
    }
    for (var y = -1; y <= 1; y += 2) {
        for (var x = -1; x <= 1; x += 2) {
            downsample_add(&sum, downsample_tap(source, source_sampler, at, f32(x), f32(y), params), 0.125);
        }
    }
    return sum.color / sum.weight;
}

fn downsample_tap13_groups(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Downsample) -> vec4f {
    let groups = downsample_groups(source, source_sampler, at, params);
    var sum = DownsampleSum();
    downsample_add(&sum, groups.center, 0.5);
    downsample_add(&sum, groups.corners[0], 0.125);
    downsample_add(&sum, groups.corners[1], 0.125);
    downsample_add(&sum, groups.corners[2], 0.125);
    downsample_add(&sum, groups.corners[3], 0.125);
    return sum.color / sum.weight;
}

// The look of `downsample_tap13_groups` from five taps. Each corner has the weight of a square that it shares with the
// center, which counts four times. A bright pixel at the center is in all squares and is kept; one at a corner is in
// one square and is reduced. The factor four is nearest to the thirteen taps on images of rooms, streets and suns.
fn downsample_tap4_groups(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Downsample) -> vec4f {
    let middle = 0.8 * tap(source, source_sampler, at.uv);
    var sum = DownsampleSum();
    for (var y = -1; y <= 1; y += 2) {
        for (var x = -1; x <= 1; x += 2) {
            let corner = downsample_tap(source, source_sampler, at, f32(x), f32(y), params);
            downsample_add_among(&sum, corner, 0.2 * corner + middle, 0.25);
        }
    }
    return sum.color / sum.weight;
}
