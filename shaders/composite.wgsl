// Combines light with an image. Light that is added covers nothing, and a tent reads it as open at its border; light
// that is mixed is a mean, and takes its alpha with it.
import afterimage::sanitize::HALF_MAX;
import afterimage::math::between;
import afterimage::tent::{TentTaps, tap_narrow_tent, tap_tent, tap_whole_tent};

struct Composite {
    strength: f32,
    radius: f32,
    texels: i32,
    outer: vec4f,
    inner: vec4f,
}

// True if the radius is at most 1.
const COMPOSITE_NARROW: bool = false;

fn composite_taps(params: Composite) -> TentTaps {
    return TentTaps(params.texels, params.outer, params.inner);
}

fn composite_tap_tent(t: texture_2d<f32>, s: sampler, uv: vec2f, radius: f32, is_open: bool) -> vec4f {
    if COMPOSITE_NARROW { return tap_narrow_tent(t, s, uv, radius, is_open); }
    return tap_tent(t, s, uv, radius, is_open);
}

// Limited, because a sum of bright lights may exceed the largest half float.
fn composite_sum(base: vec4f, light: vec3f, params: Composite) -> vec4f {
    return vec4f(clamp(base.rgb + params.strength * light, vec3f(-HALF_MAX), vec3f(HALF_MAX)), base.a);
}

fn composite_mean(base: vec4f, light: vec4f, params: Composite) -> vec4f {
    return between(base, light, params.strength);
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
    return composite_screen(base, composite_tap_tent(bloom, bloom_sampler, at.uv, params.radius, true).rgb, params);
}

fn composite_add_pixel(base: vec4f, bloom: vec4f, params: Composite) -> vec4f {
    return composite_sum(base, bloom.rgb, params);
}

fn composite_mix_pixel(base: vec4f, bloom: vec4f, params: Composite) -> vec4f {
    return composite_mean(base, bloom, params);
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
    return composite_sum(base, composite_tap_tent(bloom, bloom_sampler, at.uv, params.radius, true).rgb, params);
}

fn composite_mix_bilinear(
    base: vec4f,
    bloom: texture_2d<f32>,
    bloom_sampler: sampler,
    at: Point,
    params: Composite,
) -> vec4f {
    return composite_mean(base, tap(bloom, bloom_sampler, at.uv), params);
}

fn composite_mix_tent(
    base: vec4f,
    bloom: texture_2d<f32>,
    bloom_sampler: sampler,
    at: Point,
    params: Composite,
) -> vec4f {
    return composite_mean(base, composite_tap_tent(bloom, bloom_sampler, at.uv, params.radius, false), params);
}

// For light of exactly half or a quarter of the size of the image.
fn composite_add_whole(
    base: vec4f,
    bloom: texture_2d<f32>,
    bloom_sampler: sampler,
    at: Point,
    params: Composite,
) -> vec4f {
    let light = tap_whole_tent(bloom, bloom_sampler, at, composite_taps(params), true).rgb;
    return composite_sum(base, light, params);
}

fn composite_screen_whole(
    base: vec4f,
    bloom: texture_2d<f32>,
    bloom_sampler: sampler,
    at: Point,
    params: Composite,
) -> vec4f {
    let light = tap_whole_tent(bloom, bloom_sampler, at, composite_taps(params), true).rgb;
    return composite_screen(base, light, params);
}

fn composite_mix_whole(
    base: vec4f,
    bloom: texture_2d<f32>,
    bloom_sampler: sampler,
    at: Point,
    params: Composite,
) -> vec4f {
    let light = tap_whole_tent(bloom, bloom_sampler, at, composite_taps(params), false);
    return composite_mean(base, light, params);
}
