import package::lib::gauss::gauss_along;

struct Haze { amount: f32, width: f32 }

// The mean of the pixels under a texel.
fn haze_levels(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    return tap(source, source_sampler, at.uv);
}

fn haze_across(levels: texture_2d<f32>, at: Point) -> vec4f {
    return gauss_along(levels, at.pixel, vec2i(1, 0), 1.0);
}

fn haze_soft(across: texture_2d<f32>, at: Point) -> vec4f {
    return gauss_along(across, at.pixel, vec2i(0, 1), 1.0);
}

fn haze_wide(
    soft: vec4f,
    coarser: texture_2d<f32>,
    coarser_sampler: sampler,
    at: Point,
    params: Haze,
) -> vec4f {
    return mix(soft, tap(coarser, coarser_sampler, at.uv), params.width);
}

fn haze(source: vec4f, wide: texture_2d<f32>, wide_sampler: sampler, at: Point, params: Haze) -> vec4f {
    return vec4f(mix(source, tap(wide, wide_sampler, at.uv), params.amount).rgb, source.a);
}

fn haze_glow(wide: texture_2d<f32>, wide_sampler: sampler, at: Point, params: Haze) -> vec4f {
    return params.amount * tap(wide, wide_sampler, at.uv);
}
