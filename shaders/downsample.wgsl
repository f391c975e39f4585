// Halves an image. Offsets are in texels of the source. At exactly 2:1 every tap falls on a corner between four texels
// and is their mean. The weights of every filter sum to 1; alpha is filtered like color.
#import color
#import tent

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

fn downsample_tap(source: texture_2d<f32>, source_sampler: sampler, at: Point, x: f32, y: f32) -> vec4f {
    return tap(source, source_sampler, at.uv + vec2f(x, y) / vec2f(textureDimensions(source)));
}

// The mean of four taps at 1 texel from (x, y) along both axes.
fn downsample_square(source: texture_2d<f32>, source_sampler: sampler, at: Point, x: f32, y: f32) -> vec4f {
    let upper = downsample_tap(source, source_sampler, at, x - 1.0, y - 1.0)
        + downsample_tap(source, source_sampler, at, x + 1.0, y - 1.0);
    let lower = downsample_tap(source, source_sampler, at, x - 1.0, y + 1.0)
        + downsample_tap(source, source_sampler, at, x + 1.0, y + 1.0);
    return 0.25 * (upper + lower);
}

fn downsample_groups(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> DownsampleGroups {
    // Rows from the top; each at x = -2, 0 and 2 texels.
    let a = downsample_tap(source, source_sampler, at, -2.0, -2.0);
    let b = downsample_tap(source, source_sampler, at, 0.0, -2.0);
    let c = downsample_tap(source, source_sampler, at, 2.0, -2.0);
    let d = downsample_tap(source, source_sampler, at, -2.0, 0.0);
    let e = downsample_tap(source, source_sampler, at, 0.0, 0.0);
    let f = downsample_tap(source, source_sampler, at, 2.0, 0.0);
    let g = downsample_tap(source, source_sampler, at, -2.0, 2.0);
    let h = downsample_tap(source, source_sampler, at, 0.0, 2.0);
    let i = downsample_tap(source, source_sampler, at, 2.0, 2.0);
    let corners = array(0.25 * (a + b + d + e), 0.25 * (b + c + e + f), 0.25 * (d + e + g + h), 0.25 * (e + f + h + i));
    return DownsampleGroups(downsample_square(source, source_sampler, at, 0.0, 0.0), corners);
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

fn downsample_tap4(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    return downsample_square(source, source_sampler, at, 0.0, 0.0);
}

fn downsample_tap9(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    return tap_tent(source, source_sampler, at.uv, 1.0);
}

fn downsample_tap13(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    let groups = downsample_groups(source, source_sampler, at);
    let upper = groups.corners[0] + groups.corners[1];
    let around = upper + groups.corners[2] + groups.corners[3];
    return 0.5 * groups.center + 0.125 * around;
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

fn downsample_tap4_taps(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    var sum = DownsampleSum();
    for (var y = -1; y <= 1; y += 2) {
        for (var x = -1; x <= 1; x += 2) {
            downsample_add(&sum, downsample_tap(source, source_sampler, at, f32(x), f32(y)), 0.25);
        }
    }
    return sum.color / sum.weight;
}

fn downsample_tap9_taps(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    var sum = DownsampleSum();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            downsample_add(&sum, downsample_tap(source, source_sampler, at, f32(x), f32(y)), tent_weight(x, y));
        }
    }
    return sum.color / sum.weight;
}

fn downsample_tap13_taps(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    var sum = DownsampleSum();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let spread = downsample_tap(source, source_sampler, at, 2.0 * f32(x), 2.0 * f32(y));
            downsample_add(&sum, spread, 0.5 * tent_weight(x, y));
        }
    }
    for (var y = -1; y <= 1; y += 2) {
        for (var x = -1; x <= 1; x += 2) {
            downsample_add(&sum, downsample_tap(source, source_sampler, at, f32(x), f32(y)), 0.125);
        }
    }
    return sum.color / sum.weight;
}

fn downsample_tap13_groups(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    let groups = downsample_groups(source, source_sampler, at);
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
fn downsample_tap4_groups(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    let middle = 0.8 * tap(source, source_sampler, at.uv);
    var sum = DownsampleSum();
    for (var y = -1; y <= 1; y += 2) {
        for (var x = -1; x <= 1; x += 2) {
            let corner = downsample_tap(source, source_sampler, at, f32(x), f32(y));
            downsample_add_among(&sum, corner, 0.2 * corner + middle, 0.25);
        }
    }
    return sum.color / sum.weight;
}
