// One step from the coarsest level of a pyramid to the finest: combines a level with the result of all coarser ones.
#import sanitize
#import tent

struct Upsample {
    radius: f32,
    own: f32,   // weight of the level
    rest: f32,  // weight of the coarser levels
}

// Limited, because sums of levels without normalization may exceed the largest half float.
fn upsample_join(level: vec4f, rest: vec4f, params: Upsample) -> vec4f {
    return clamp(params.own * level + params.rest * rest, vec4f(-HALF_MAX), vec4f(HALF_MAX));
}

fn upsample_bilinear(
    level: vec4f,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
) -> vec4f {
    return upsample_join(level, tap(coarser, coarser_sampler, at.uv), params);
}

fn upsample_tent(
    level: vec4f,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Upsample,
) -> vec4f {
    return upsample_join(level, tap_tent(coarser, coarser_sampler, at.uv, params.radius), params);
}
