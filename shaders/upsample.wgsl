// One step of the way back from a pyramid's coarsest level: a level joined with what all coarser ones have become.
#import sanitize
#import tent

struct Upsample {
    radius: f32,
    own: f32,   // share of the level
    rest: f32,  // share of the coarser ones
}

// Bounded, because sums of levels that are not normalised may pass the largest half float.
fn upsample_join(level: vec4f, rest: vec4f, params: Upsample) -> vec4f {
    return min(params.own * level + params.rest * rest, vec4f(HALF_MAX));
}

fn upsample_bilinear(level: vec4f, coarser: texture_2d<f32>, coarser_sampler: sampler, at: Point, params: Upsample) -> vec4f {
    return upsample_join(level, tap(coarser, coarser_sampler, at.uv), params);
}

fn upsample_tent(level: vec4f, coarser: texture_2d<f32>, coarser_sampler: sampler, at: Point, params: Upsample) -> vec4f {
    return upsample_join(level, tap_tent(coarser, coarser_sampler, at.uv, params.radius), params);
}
