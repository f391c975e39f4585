// One step from the coarsest level of a pyramid to the finest: combines a level with the result of all coarser ones.
// Beyond their border, these are open, or with `edge` their nearest texel.
import afterimage::sanitize::HALF_MAX;
import afterimage::tent::{TentTaps, tap_narrow_tent, tap_tent, tap_whole_tent};

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

// The level with the weights 1 2 1 along each axis: four taps at the corners of a texel.
fn upsample_smoothed(t: texture_2d<f32>, s: sampler, at: Point, is_open: bool) -> vec4f {
    let half = 0.5 / vec2f(textureDimensions(t));
    var sum = vec4f();
    for (var corner = 0u; corner < 4u; corner++) {
        let uv = at.uv + (2.0 * vec2f(vec2u(corner & 1u, corner >> 1u)) - 1.0) * half;
        if is_open { sum += tap_open(t, s, uv); } else { sum += tap(t, s, uv); }
    }
    return 0.25 * sum;
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

fn upsample_smooth_bilinear(
    level: texture_2d<f32>,
    level_sampler: sampler,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
) -> vec4f {
    let rest = tap_open(coarser, coarser_sampler, at.uv);
    return upsample_join(upsample_smoothed(level, level_sampler, at, true), rest, params);
}

fn upsample_smooth_tent(
    level: texture_2d<f32>,
    level_sampler: sampler,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
) -> vec4f {
    let rest = upsample_tap_tent(coarser, coarser_sampler, at.uv, params.radius, true);
    return upsample_join(upsample_smoothed(level, level_sampler, at, true), rest, params);
}

fn upsample_smooth_whole(
    level: texture_2d<f32>,
    level_sampler: sampler,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
) -> vec4f {
    let rest = tap_whole_tent(coarser, coarser_sampler, at, upsample_taps(params), true);
    return upsample_join(upsample_smoothed(level, level_sampler, at, true), rest, params);
}

fn upsample_smooth_edge_bilinear(
    level: texture_2d<f32>,
    level_sampler: sampler,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
) -> vec4f {
    let rest = tap(coarser, coarser_sampler, at.uv);
    return upsample_join(upsample_smoothed(level, level_sampler, at, false), rest, params);
}

fn upsample_smooth_edge_tent(
    level: texture_2d<f32>,
    level_sampler: sampler,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
) -> vec4f {
    let rest = upsample_tap_tent(coarser, coarser_sampler, at.uv, params.radius, false);
    return upsample_join(upsample_smoothed(level, level_sampler, at, false), rest, params);
}

fn upsample_smooth_edge_whole(
    level: texture_2d<f32>,
    level_sampler: sampler,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
) -> vec4f {
    let rest = tap_whole_tent(coarser, coarser_sampler, at, upsample_taps(params), false);
    return upsample_join(upsample_smoothed(level, level_sampler, at, false), rest, params);
}
