// One step of the way back from a pyramid's coarsest level: a level joined with what all coarser ones have become.
#import guard

struct Upsample {
    radius: f32,
    own: f32,   // share of the level
    rest: f32,  // share of the coarser ones
}

// Bounded, because sums of levels that are not normalised may pass the largest half float.
fn upsample_join(level: vec4f, rest: vec4f, params: Upsample) -> vec4f {
    return min(params.own * level + params.rest * rest, vec4f(GUARD_MAX));
}

fn upsample_bilinear(level: vec4f, coarser: texture_2d<f32>, coarser_sampler: sampler, at: Point, params: Upsample) -> vec4f {
    return upsample_join(level, tap(coarser, coarser_sampler, at.uv), params);
}

// Nine taps, `radius` texels of the coarser image apart, with the weights of a tent.
fn upsample_tent(level: vec4f, coarser: texture_2d<f32>, coarser_sampler: sampler, at: Point, params: Upsample) -> vec4f {
    let step = params.radius / vec2f(textureDimensions(coarser));
    var sum = vec4f();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let weight = f32((2 - abs(x)) * (2 - abs(y))) / 16.0;
            sum += weight * tap(coarser, coarser_sampler, at.uv + vec2f(f32(x), f32(y)) * step);
        }
    }
    return upsample_join(level, sum, params);
}
