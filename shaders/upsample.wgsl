// One step from the coarsest level of a pyramid to the finest: combines a level with the result of all coarser ones.
// Beyond their border, these are open, or with `edge` their nearest texel.
import afterimage::sanitize::HALF_MAX;
import afterimage::tent::{TentTaps, tap_narrow_tent, tap_tent, tap_whole_tent};
import afterimage::workgroup::Invocation;

struct Upsample {
    radius: f32,
    own: f32,   // weight of the level
    rest: f32,  // weight of the coarser levels
    texels: i32,
    outer: vec4f,
    inner: vec4f,
}

// True if the radius is at most 1.
const UPSAMPLE_NARROW: bool = false;

fn upsample_taps(params: Upsample) -> TentTaps {
    return TentTaps(params.texels, params.outer, params.inner);
}

fn upsample_tap_tent(t: texture_2d<f32>, s: sampler, uv: vec2f, radius: f32, is_open: bool) -> vec4f {
    if UPSAMPLE_NARROW { return tap_narrow_tent(t, s, uv, radius, is_open); }
    return tap_tent(t, s, uv, radius, is_open);
}

// Limited, because sums of levels without normalization may exceed the largest half float.
fn upsample_join(level: vec4f, rest: vec4f, params: Upsample) -> vec4f {
    return clamp(params.own * level + params.rest * rest, vec4f(-HALF_MAX), vec4f(HALF_MAX));
}

// Three taps of a row, each with its weight.
fn upsample_row(t: texture_2d<f32>, s: sampler, x: vec3f, y: f32, across: vec3f) -> vec4f {
    let sides = across.x * tap(t, s, vec2f(x.x, y)) + across.z * tap(t, s, vec2f(x.z, y));
    return sides + across.y * tap(t, s, vec2f(x.y, y));
}

// The mean of nine taps 14/11 of a texel apart: weights of 1/11 8/33 1/3 8/33 1/11 along each axis.
fn upsample_mean(t: texture_2d<f32>, s: sampler, at: Point, is_open: bool) -> vec4f {
    let size = vec2f(textureDimensions(t));
    let here = at.uv * size;
    let before = here - 14.0 / 11.0;
    let after = here + 14.0 / 11.0;
    var across = vec3f(1.0 / 3.0);
    var down = across;
    if is_open {
        let first = tap_inside(before, size);
        let middle = tap_inside(here, size);
        let last = tap_inside(after, size);
        across *= vec3f(first.x, middle.x, last.x);
        down *= vec3f(first.y, middle.y, last.y);
    }
    let x = vec3f(before.x, here.x, after.x) / size.x;
    let y = vec3f(before.y, here.y, after.y) / size.y;
    let rows = down.x * upsample_row(t, s, x, y.x, across) + down.y * upsample_row(t, s, x, y.y, across);
    return rows + down.z * upsample_row(t, s, x, y.z, across);
}

fn upsample_smooth(joined: texture_2d<f32>, joined_sampler: sampler, at: Point) -> vec4f {
    return upsample_mean(joined, joined_sampler, at, true);
}

fn upsample_edge_smooth(joined: texture_2d<f32>, joined_sampler: sampler, at: Point) -> vec4f {
    return upsample_mean(joined, joined_sampler, at, false);
}

fn upsample_bilinear(
    level: vec4f,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
) -> vec4f {
    return upsample_join(level, tap_open(coarser, coarser_sampler, at.uv), params);
}

fn upsample_tent(
    level: vec4f,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
) -> vec4f {
    return upsample_join(level, upsample_tap_tent(coarser, coarser_sampler, at.uv, params.radius, true), params);
}

fn upsample_edge_bilinear(
    level: vec4f,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
) -> vec4f {
    return upsample_join(level, tap(coarser, coarser_sampler, at.uv), params);
}

fn upsample_edge_tent(
    level: vec4f,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
) -> vec4f {
    return upsample_join(level, upsample_tap_tent(coarser, coarser_sampler, at.uv, params.radius, false), params);
}

// For a level of exactly twice or four times the size of the coarser one.
fn upsample_whole(
    level: vec4f,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
) -> vec4f {
    return upsample_join(level, tap_whole_tent(coarser, coarser_sampler, at, upsample_taps(params), true), params);
}

fn upsample_edge_whole(
    level: vec4f,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
) -> vec4f {
    return upsample_join(level, tap_whole_tent(coarser, coarser_sampler, at, upsample_taps(params), false), params);
}

// The last enlargement and its smoothing in one pass. A workgroup makes 16x16 texels, from those and two more to each
// side in its memory: on an H200, 960x540 texels take 18.7 us so, and 12.5 and 16.1 us in two passes.
const UPSAMPLE_TILE: u32 = 16u;
const UPSAMPLE_AROUND: u32 = 2u;
const UPSAMPLE_WIDE: u32 = UPSAMPLE_TILE + 2u * UPSAMPLE_AROUND;

var<workgroup> upsample_joined: array<vec4f, UPSAMPLE_WIDE * UPSAMPLE_WIDE>;
var<workgroup> upsample_across: array<vec4f, UPSAMPLE_WIDE * UPSAMPLE_TILE>;

// The weights of `upsample_mean` along an axis.
fn upsample_five(a: vec4f, b: vec4f, c: vec4f, d: vec4f, e: vec4f) -> vec4f {
    return (a + e) * (1.0 / 11.0) + (b + d) * (8.0 / 33.0) + c * (1.0 / 3.0);
}

// Puts the texel at an index of the tile, whose upper left one is `first`, into the memory of the workgroup.
fn upsample_fill(
    level: texture_2d<f32>,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    first: vec2i,
    size: vec2f,
    params: Upsample,
    index: u32,
    is_open: bool,
) {
    let place = first + vec2i(vec2u(index % UPSAMPLE_WIDE, index / UPSAMPLE_WIDE));
    let pixel = clamp(place, vec2i(), vec2i(size) - 1);
    let at = Point(pixel, (vec2f(pixel) + 0.5) / size, size);
    let rest = tap_whole_tent(coarser, coarser_sampler, at, upsample_taps(params), is_open);
    // As of `tap_inside`.
    let share = select(vec2f(1.0), vec2f(0.5), vec2<bool>(is_open) & (pixel != place));
    upsample_joined[index] = share.x * share.y * upsample_join(texel(level, pixel), rest, params);
}

fn upsample_tile(
    level: texture_2d<f32>,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
    invocation: Invocation,
    is_open: bool,
) -> vec4f {
    let own = invocation.index;
    let local = vec2u(own % UPSAMPLE_TILE, own / UPSAMPLE_TILE);
    let first = at.pixel - vec2i(local + UPSAMPLE_AROUND);
    for (var i = own; i < UPSAMPLE_WIDE * UPSAMPLE_WIDE; i += UPSAMPLE_TILE * UPSAMPLE_TILE) {
        upsample_fill(level, coarser, coarser_sampler, first, at.size, params, i, is_open);
    }
    workgroupBarrier();
    for (var i = own; i < UPSAMPLE_WIDE * UPSAMPLE_TILE; i += UPSAMPLE_TILE * UPSAMPLE_TILE) {
        let row = (i / UPSAMPLE_TILE) * UPSAMPLE_WIDE + i % UPSAMPLE_TILE;
        upsample_across[i] = upsample_five(
            upsample_joined[row],
            upsample_joined[row + 1u],
            upsample_joined[row + 2u],
            upsample_joined[row + 3u],
            upsample_joined[row + 4u],
        );
    }
    workgroupBarrier();
    return upsample_five(
        upsample_across[own],
        upsample_across[own + UPSAMPLE_TILE],
        upsample_across[own + 2u * UPSAMPLE_TILE],
        upsample_across[own + 3u * UPSAMPLE_TILE],
        upsample_across[own + 4u * UPSAMPLE_TILE],
    );
}

fn upsample_whole_smooth(
    level: texture_2d<f32>,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
    invocation: Invocation,
) -> vec4f {
    return upsample_tile(level, coarser, coarser_sampler, at, params, invocation, true);
}

fn upsample_edge_whole_smooth(
    level: texture_2d<f32>,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
    invocation: Invocation,
) -> vec4f {
    return upsample_tile(level, coarser, coarser_sampler, at, params, invocation, false);
}
