// Combines light with an image. Alpha is that of the image.
#import sanitize
#import math
#import tent

struct Composite {
    strength: f32,
    radius: f32,
}

// Limited, because a sum of bright lights may exceed the largest half float.
fn composite_sum(base: vec4f, light: vec3f, params: Composite) -> vec4f {
    return vec4f(clamp(base.rgb + params.strength * light, vec3f(-HALF_MAX), vec3f(HALF_MAX)), base.a);
}

fn composite_mean(base: vec4f, light: vec3f, params: Composite) -> vec4f {
    return vec4f(between3(base.rgb, light, params.strength), base.a);
}

// The light reaches at most white, and takes a share of the distance that the image has to it.
fn composite_screen(base: vec4f, light: vec3f, params: Composite) -> vec4f {
    let share = clamp(params.strength * light, vec3f(0.0), vec3f(1.0));
    return vec4f(base.rgb + share * max(1.0 - base.rgb, vec3f(0.0)), base.a);
}

fn composite_screen_pixel(base: vec4f, bloom: vec4f, params: Composite) -> vec4f {
    return composite_screen(base, bloom.rgb, params);
}

fn composite_screen_bilinear(
    base: vec4f,
    bloom: texture_2d<f32>,
    bloom_sampler: sampler,
    at: Point,
    params: Composite,
) -> vec4f {
    return composite_screen(base, tap(bloom, bloom_sampler, at.uv).rgb, params);
}

fn composite_screen_tent(
    base: vec4f,
    bloom: texture_2d<f32>,
    bloom_sampler: sampler,
    at: Point,
    params: Composite,
) -> vec4f {
    return composite_screen(base, tap_tent(bloom, bloom_sampler, at.uv, params.radius).rgb, params);
}

fn composite_add_pixel(base: vec4f, bloom: vec4f, params: Composite) -> vec4f {
    return composite_sum(base, bloom.rgb, params);
}

fn composite_mix_pixel(base: vec4f, bloom: vec4f, params: Composite) -> vec4f {
    return composite_mean(base, bloom.rgb, params);
}

fn composite_add_bilinear(
    base: vec4f,
    bloom: texture_2d<f32>,
    bloom_sampler: sampler,
    at: Point,
    params: Composite,
) -> vec4f {
    return composite_sum(base, tap(bloom, bloom_sampler, at.uv).rgb, params);
}

fn composite_add_tent(
    base: vec4f,
    bloom: texture_2d<f32>,
    bloom_sampler: sampler,
    at: Point,
    params: Composite,
) -> vec4f {
    return composite_sum(base, tap_tent(bloom, bloom_sampler, at.uv, params.radius).rgb, params);
}

fn composite_mix_bilinear(
    base: vec4f,
    bloom: texture_2d<f32>,
    bloom_sampler: sampler,
    at: Point,
    params: Composite,
) -> vec4f {
    return composite_mean(base, tap(bloom, bloom_sampler, at.uv).rgb, params);
}

fn composite_mix_tent(
    base: vec4f,
    bloom: texture_2d<f32>,
    bloom_sampler: sampler,
    at: Point,
    params: Composite,
) -> vec4f {
    return composite_mean(base, tap_tent(bloom, bloom_sampler, at.uv, params.radius).rgb, params);
}
