// Halves an image whose sides are not exactly twice those of the result, such as 5 texels to 2. The filters are those
// of `downsample.wgsl`, defined in texels of the result: a tap is a box of one texel, a square of four taps a box of
// two, and nine taps are a tent. A filter is integrated over each texel of the source, and texels at its ends count in
// part. Boxes of whole texels of the result cover the source evenly, so the weights of each texel of the source, except
// at the border, add up to the same sum: energy is kept, and a light that moves does not flicker.
import afterimage::color::brightest;
import afterimage::tent::tent_weight;

struct DownsampleAnyBorder {
    edge: f32,   // 1 if the nearest texel lies beyond the border, and 0 if the image is open
}

// A texel of the result in the source. Positions are relative to `base`, which keeps them exact in large images.
struct DownsampleAny {
    base: vec2i,     // the texel of the source that contains the center
    center: vec2f,   // in [0, 1)
    scale: vec2f,    // texels of the source in one of the result
    across: vec2f,   // where texels begin to count a half, and cease to: at the border, or far beyond it
    down: vec2f,
}

fn downsample_any_at(source: texture_2d<f32>, at: Point, params: DownsampleAnyBorder) -> DownsampleAny {
    let size = vec2i(textureDimensions(source));
    // Half of a side is rounded down: the source has one texel more than twice the result, or none, or one less if the
    // side is a single texel. So whole numbers need not be divided, which takes longer than all else here.
    let more = size - 2 * vec2i(at.size);
    let odd = 2 * at.pixel + 1;
    let base = select(odd, vec2i(), more < vec2i());
    let center = select(vec2f(odd * more) / (2.0 * at.size), vec2f(0.5), more < vec2i());
    let beyond = 1e6 * params.edge;
    let low = -vec2f(base) - beyond;
    let high = vec2f(size - base) + beyond;
    let scale = vec2f(size) / at.size;
    return DownsampleAny(base, center, scale, vec2f(low.x, high.x), vec2f(low.y, high.y));
}

// The first texel that a filter reaches, and the first one beyond it.
struct DownsampleAnyReach {
    first: vec2i,
    end: vec2i,
}

// Reaches are in texels of the result.
fn downsample_any_reach(place: DownsampleAny, center: vec2f, reach: f32) -> DownsampleAnyReach {
    let low = floor(center - reach * place.scale);
    let high = ceil(center + reach * place.scale);
    return DownsampleAnyReach(vec2i(low), vec2i(high));
}

// The lengths of a texel within a box, along both axes; half of them beyond the border of an open image.
fn downsample_any_within(place: DownsampleAny, texel: vec2f, center: vec2f, half_width: vec2f) -> vec2f {
    let length = max(min(texel + 1.0, center + half_width) - max(texel, center - half_width), vec2f());
    let begin = vec2f(place.across.x, place.down.x);
    let end = vec2f(place.across.y, place.down.y);
    return length * select(vec2f(0.5), vec2f(1.0), (texel >= begin) & (texel < end));
}

// The mean over a box. The offset of its center and half of its width are in texels of the result.
fn downsample_any_mean(source: texture_2d<f32>, place: DownsampleAny, offset: vec2f, half_width: f32) -> vec4f {
    let center = place.center + offset * place.scale;
    let half = half_width * place.scale;
    let reach = downsample_any_reach(place, center, half_width);
    var sum = vec4f();
    for (var y = reach.first.y; y < reach.end.y; y++) {
        var row = vec4f();
        for (var x = reach.first.x; x < reach.end.x; x++) {
            let within = downsample_any_within(place, vec2f(vec2i(x, y)), center, half);
            row += within.x * texel(source, place.base + vec2i(x, y));
        }
        sum += downsample_any_within(place, vec2f(0.0, f32(y)), center, half).y * row;
    }
    return sum / (4.0 * half.x * half.y);
}

// A tap of the filter; (x, y) are in halves of a texel of the result.
fn downsample_any_tap(source: texture_2d<f32>, place: DownsampleAny, x: i32, y: i32) -> vec4f {
    return downsample_any_mean(source, place, 0.5 * vec2f(vec2i(x, y)), 0.5);
}

// The five boxes of the thirteen taps.
struct DownsampleAnyGroups {
    center: vec4f,
    corners: array<vec4f, 4>,
}

fn downsample_any_groups(source: texture_2d<f32>, place: DownsampleAny) -> DownsampleAnyGroups {
    let reach = downsample_any_reach(place, place.center, 1.5);
    let low = place.center - 0.5 * place.scale;
    let high = place.center + 0.5 * place.scale;
    var groups = DownsampleAnyGroups();
    for (var y = reach.first.y; y < reach.end.y; y++) {
        // Of a row of texels: its sums within the middle, the left and the right boxes.
        var middle = vec4f();
        var left = vec4f();
        var right = vec4f();
        for (var x = reach.first.x; x < reach.end.x; x++) {
            let color = texel(source, place.base + vec2i(x, y));
            let column = vec2f(f32(x), 0.0);
            middle += downsample_any_within(place, column, place.center, place.scale).x * color;
            left += downsample_any_within(place, column, low, place.scale).x * color;
            right += downsample_any_within(place, column, high, place.scale).x * color;
        }
        let row = vec2f(0.0, f32(y));
        let upper = downsample_any_within(place, row, low, place.scale).y;
        let lower = downsample_any_within(place, row, high, place.scale).y;
        groups.center += downsample_any_within(place, row, place.center, place.scale).y * middle;
        groups.corners[0] += upper * left;
        groups.corners[1] += upper * right;
        groups.corners[2] += lower * left;
        groups.corners[3] += lower * right;
    }
    let share = 0.25 / (place.scale.x * place.scale.y);
    groups.center *= share;
    for (var i = 0; i < 4; i++) { groups.corners[i] *= share; }
    return groups;
}

// A weighted sum of colors.
struct DownsampleAnySum {
    color: vec4f,
    weight: f32,
}

// Adds a color with the weight 1 / (1 + brightness of `around`).
fn downsample_any_add(sum: ptr<function, DownsampleAnySum>, color: vec4f, around: vec4f, share: f32) {
    let weight = share / (1.0 + max(brightest(around.rgb), 0.0));
    (*sum).color += color * weight;
    (*sum).weight += weight;
}

// A filter along one axis: pairs of texels as taps between them, with the weights of both.
struct DownsampleAnyTaps {
    weight: vec4f,
    at: vec4f,
}

// The first texel of a filter. Texels outside of the image are equal to the border: one stands for those before it.
fn downsample_any_first(place: DownsampleAny, reach: f32) -> vec2f {
    return max(floor(place.center - reach * place.scale), vec2f(-1 - place.base));
}

// The first texels of the pairs of a filter.
fn downsample_any_pairs(first: f32) -> vec4f {
    return first + vec4f(0.0, 2.0, 4.0, 6.0);
}

// The shares of a filter that are below the middles and the ends of its pairs, and far below all of them.
struct DownsampleAnyPairs {
    lowest: f32,
    middle: vec4f,
    end: vec4f,
}

// The shares of texels that count: half beyond the border of an open image.
fn downsample_any_shares(texels: vec4f, ends: vec2f) -> vec4f {
    return select(vec4f(0.5), vec4f(1.0), (texels >= vec4f(ends.x)) & (texels < vec4f(ends.y)));
}

// The taps of a filter with these shares. What is before the first pair belongs to it: it is equal to the border.
fn downsample_any_taps(first: f32, below: DownsampleAnyPairs, ends: vec2f) -> DownsampleAnyTaps {
    let pairs = downsample_any_pairs(first);
    let start = vec4f(below.lowest, below.end.xyz);
    let left = (below.middle - start) * downsample_any_shares(pairs, ends);
    let right = (below.end - below.middle) * downsample_any_shares(pairs + 1.0, ends);
    let weight = left + right;
    return DownsampleAnyTaps(weight, pairs + 0.5 + right / max(weight, vec4f(1e-6)));
}

// The share of a box that is below a place.
fn downsample_any_below(at: vec4f, center: f32, width: f32) -> vec4f {
    return clamp((at - center) / width + 0.5, vec4f(), vec4f(1.0));
}

fn downsample_any_box_along(first: f32, center: f32, width: f32, ends: vec2f) -> DownsampleAnyTaps {
    let pairs = downsample_any_pairs(first);
    let below = DownsampleAnyPairs(
        0.0,
        downsample_any_below(pairs + 1.0, center, width),
        downsample_any_below(pairs + 2.0, center, width),
    );
    return downsample_any_taps(first, below, ends);
}

// The mean of two boxes of two texels of the result, half such a texel to each side.
fn downsample_any_below_wide(at: vec4f, center: f32, scale: f32) -> vec4f {
    let low = downsample_any_below(at, center - 0.5 * scale, 2.0 * scale);
    return 0.5 * (low + downsample_any_below(at, center + 0.5 * scale, 2.0 * scale));
}

fn downsample_any_wide_along(first: f32, center: f32, scale: f32, ends: vec2f) -> DownsampleAnyTaps {
    let pairs = downsample_any_pairs(first);
    let below = DownsampleAnyPairs(
        0.0,
        downsample_any_below_wide(pairs + 1.0, center, scale),
        downsample_any_below_wide(pairs + 2.0, center, scale),
    );
    return downsample_any_taps(first, below, ends);
}

// The mean of five boxes of a texel of the result, half such a texel apart, with the weights 1 4 6 4 1. `inverse` is 1
// over the texels of the source in one of the result.
fn downsample_any_below_binomial(at: vec4f, center: f32, inverse: f32) -> vec4f {
    let place = (at - center) * inverse;
    let inner = saturate(place) + saturate(place + 1.0);
    let outer = saturate(place - 0.5) + saturate(place + 1.5);
    return 0.375 * saturate(place + 0.5) + 0.25 * inner + 0.0625 * outer;
}

fn downsample_any_binomial_along(first: f32, center: f32, scale: f32, ends: vec2f) -> DownsampleAnyTaps {
    let pairs = downsample_any_pairs(first);
    let inverse = 1.0 / scale;
    let below = DownsampleAnyPairs(
        0.0,
        downsample_any_below_binomial(pairs + 1.0, center, inverse),
        downsample_any_below_binomial(pairs + 2.0, center, inverse),
    );
    return downsample_any_taps(first, below, ends);
}

// The share of a tent that is below a place, from its middle.
fn downsample_any_below_tent(at: vec4f, center: f32, scale: f32) -> vec4f {
    let within = clamp((at - center) / scale, vec4f(-1.0), vec4f(1.0));
    return within - 0.5 * within * abs(within);
}

fn downsample_any_tent_along(first: f32, center: f32, scale: f32, ends: vec2f) -> DownsampleAnyTaps {
    let pairs = downsample_any_pairs(first);
    let below = DownsampleAnyPairs(
        -0.5,
        downsample_any_below_tent(pairs + 1.0, center, scale),
        downsample_any_below_tent(pairs + 2.0, center, scale),
    );
    return downsample_any_taps(first, below, ends);
}

// The taps of both axes.
struct DownsampleAnyGrid {
    across: vec4f,
    down: vec4f,
    u: vec4f,
    v: vec4f,
}

fn downsample_any_grid(
    source: texture_2d<f32>,
    place: DownsampleAny,
    across: DownsampleAnyTaps,
    down: DownsampleAnyTaps,
) -> DownsampleAnyGrid {
    let size = vec2f(textureDimensions(source));
    let u = (f32(place.base.x) + across.at) / size.x;
    let v = (f32(place.base.y) + down.at) / size.y;
    return DownsampleAnyGrid(across.weight, down.weight, u, v);
}

// Sums of the first taps of a row, and of rows. Loops take twice as long: drivers do not unroll so many reads.
fn downsample_any_row2(source: texture_2d<f32>, source_sampler: sampler, grid: DownsampleAnyGrid, v: f32) -> vec4f {
    let first = grid.across.x * tap(source, source_sampler, vec2f(grid.u.x, v));
    return first + grid.across.y * tap(source, source_sampler, vec2f(grid.u.y, v));
}

fn downsample_any_row3(source: texture_2d<f32>, source_sampler: sampler, grid: DownsampleAnyGrid, v: f32) -> vec4f {
    let first = downsample_any_row2(source, source_sampler, grid, v);
    return first + grid.across.z * tap(source, source_sampler, vec2f(grid.u.z, v));
}

fn downsample_any_row4(source: texture_2d<f32>, source_sampler: sampler, grid: DownsampleAnyGrid, v: f32) -> vec4f {
    let first = downsample_any_row3(source, source_sampler, grid, v);
    return first + grid.across.w * tap(source, source_sampler, vec2f(grid.u.w, v));
}

fn downsample_any_sum2(source: texture_2d<f32>, source_sampler: sampler, grid: DownsampleAnyGrid) -> vec4f {
    let first = grid.down.x * downsample_any_row2(source, source_sampler, grid, grid.v.x);
    return first + grid.down.y * downsample_any_row2(source, source_sampler, grid, grid.v.y);
}

fn downsample_any_sum3(source: texture_2d<f32>, source_sampler: sampler, grid: DownsampleAnyGrid) -> vec4f {
    let first = grid.down.x * downsample_any_row3(source, source_sampler, grid, grid.v.x);
    let second = grid.down.y * downsample_any_row3(source, source_sampler, grid, grid.v.y);
    return first + second + grid.down.z * downsample_any_row3(source, source_sampler, grid, grid.v.z);
}

fn downsample_any_sum4(source: texture_2d<f32>, source_sampler: sampler, grid: DownsampleAnyGrid) -> vec4f {
    let first = grid.down.x * downsample_any_row4(source, source_sampler, grid, grid.v.x);
    let second = grid.down.y * downsample_any_row4(source, source_sampler, grid, grid.v.y);
    let third = grid.down.z * downsample_any_row4(source, source_sampler, grid, grid.v.z);
    return first + second + third + grid.down.w * downsample_any_row4(source, source_sampler, grid, grid.v.w);
}

fn downsample_any_box(
    source: texture_2d<f32>,
    source_sampler: sampler,
    at: Point,
    params: DownsampleAnyBorder,
) -> vec4f {
    let place = downsample_any_at(source, at, params);
    let first = downsample_any_first(place, 0.5);
    let across = downsample_any_box_along(first.x, place.center.x, place.scale.x, place.across);
    let down = downsample_any_box_along(first.y, place.center.y, place.scale.y, place.down);
    return downsample_any_sum2(source, source_sampler, downsample_any_grid(source, place, across, down));
}

fn downsample_any_tap4(
    source: texture_2d<f32>,
    source_sampler: sampler,
    at: Point,
    params: DownsampleAnyBorder,
) -> vec4f {
    let place = downsample_any_at(source, at, params);
    let first = downsample_any_first(place, 1.0);
    let across = downsample_any_box_along(first.x, place.center.x, 2.0 * place.scale.x, place.across);
    let down = downsample_any_box_along(first.y, place.center.y, 2.0 * place.scale.y, place.down);
    return downsample_any_sum3(source, source_sampler, downsample_any_grid(source, place, across, down));
}

fn downsample_any_tap9(
    source: texture_2d<f32>,
    source_sampler: sampler,
    at: Point,
    params: DownsampleAnyBorder,
) -> vec4f {
    let place = downsample_any_at(source, at, params);
    let first = downsample_any_first(place, 1.0);
    let across = downsample_any_tent_along(first.x, place.center.x, place.scale.x, place.across);
    let down = downsample_any_tent_along(first.y, place.center.y, place.scale.y, place.down);
    return downsample_any_sum3(source, source_sampler, downsample_any_grid(source, place, across, down));
}

// Half of the box in the middle and half of the mean of the other four, which has the same weights along x in each row.
fn downsample_any_tap13(
    source: texture_2d<f32>,
    source_sampler: sampler,
    at: Point,
    params: DownsampleAnyBorder,
) -> vec4f {
    let place = downsample_any_at(source, at, params);
    let middle = downsample_any_tap4(source, source_sampler, at, params);
    let first = downsample_any_first(place, 1.5);
    let across = downsample_any_wide_along(first.x, place.center.x, place.scale.x, place.across);
    let down = downsample_any_wide_along(first.y, place.center.y, place.scale.y, place.down);
    let around = downsample_any_sum4(source, source_sampler, downsample_any_grid(source, place, across, down));
    return 0.5 * middle + 0.5 * around;
}

fn downsample_any_binomial(
    source: texture_2d<f32>,
    source_sampler: sampler,
    at: Point,
    params: DownsampleAnyBorder,
) -> vec4f {
    let place = downsample_any_at(source, at, params);
    let first = downsample_any_first(place, 1.5);
    let across = downsample_any_binomial_along(first.x, place.center.x, place.scale.x, place.across);
    let down = downsample_any_binomial_along(first.y, place.center.y, place.scale.y, place.down);
    return downsample_any_sum4(source, source_sampler, downsample_any_grid(source, place, across, down));
}

// A box is a single tap, so its texels are weighted instead.
fn downsample_any_box_taps(source: texture_2d<f32>, at: Point, params: DownsampleAnyBorder) -> vec4f {
    let place = downsample_any_at(source, at, params);
    let reach = downsample_any_reach(place, place.center, 0.5);
    var sum = DownsampleAnySum();
    for (var y = reach.first.y; y < reach.end.y; y++) {
        for (var x = reach.first.x; x < reach.end.x; x++) {
            let within = downsample_any_within(place, vec2f(vec2i(x, y)), place.center, 0.5 * place.scale);
            let color = texel(source, place.base + vec2i(x, y));
            downsample_any_add(&sum, color, color, within.x * within.y);
        }
    }
    return sum.color / sum.weight;
}

fn downsample_any_tap4_taps(source: texture_2d<f32>, at: Point, params: DownsampleAnyBorder) -> vec4f {
    let place = downsample_any_at(source, at, params);
    var sum = DownsampleAnySum();
    for (var y = -1; y <= 1; y += 2) {
        for (var x = -1; x <= 1; x += 2) {
            let color = downsample_any_tap(source, place, x, y);
            downsample_any_add(&sum, color, color, 0.25);
        }
    }
    return sum.color / sum.weight;
}

fn downsample_any_tap9_taps(source: texture_2d<f32>, at: Point, params: DownsampleAnyBorder) -> vec4f {
    let place = downsample_any_at(source, at, params);
    var sum = DownsampleAnySum();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let color = downsample_any_tap(source, place, x, y);
            downsample_any_add(&sum, color, color, tent_weight(x, y));
        }
    }
    return sum.color / sum.weight;
}

fn downsample_any_tap13_taps(source: texture_2d<f32>, at: Point, params: DownsampleAnyBorder) -> vec4f {
    let place = downsample_any_at(source, at, params);
    var sum = DownsampleAnySum();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let color = downsample_any_tap(source, place, 2 * x, 2 * y);
            downsample_any_add(&sum, color, color, 0.5 * tent_weight(x, y));
        }
    }
    for (var y = -1; y <= 1; y += 2) {
        for (var x = -1; x <= 1; x += 2) {
            let color = downsample_any_tap(source, place, x, y);
            downsample_any_add(&sum, color, color, 0.125);
        }
    }
    return sum.color / sum.weight;
}

fn downsample_any_tap13_groups(source: texture_2d<f32>, at: Point, params: DownsampleAnyBorder) -> vec4f {
    let groups = downsample_any_groups(source, downsample_any_at(source, at, params));
    var sum = DownsampleAnySum();
    downsample_any_add(&sum, groups.center, groups.center, 0.5);
    for (var i = 0; i < 4; i++) {
        downsample_any_add(&sum, groups.corners[i], groups.corners[i], 0.125);
    }
    return sum.color / sum.weight;
}

// As `downsample_tap4_groups`.
fn downsample_any_tap4_groups(source: texture_2d<f32>, at: Point, params: DownsampleAnyBorder) -> vec4f {
    let place = downsample_any_at(source, at, params);
    let middle = 0.8 * downsample_any_tap(source, place, 0, 0);
    var sum = DownsampleAnySum();
    for (var y = -1; y <= 1; y += 2) {
        for (var x = -1; x <= 1; x += 2) {
            let corner = downsample_any_tap(source, place, x, y);
            downsample_any_add(&sum, corner, 0.2 * corner + middle, 0.25);
        }
    }
    return sum.color / sum.weight;
}
