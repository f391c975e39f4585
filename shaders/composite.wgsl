// Light laid over a picture. Alpha is the picture's.
#import guard

struct Composite {
    strength: f32,
    radius: f32,
}

// Nine taps, `radius` texels of the bloom apart, with the weights of a tent.
fn composite_tap9(bloom: texture_2d<f32>, bloom_sampler: sampler, at: Point, radius: f32) -> vec3f {
    let step = radius / vec2f(textureDimensions(bloom));
    var sum = vec3f();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let weight = f32((2 - abs(x)) * (2 - abs(y))) / 16.0;
            sum += weight * tap(bloom, bloom_sampler, at.uv + vec2f(f32(x), f32(y)) * step).rgb;
        }
    }
    return sum;
}

// Bounded, because a sum of bright lights may pass the largest half float.
fn composite_sum(base: vec4f, light: vec3f, params: Composite) -> vec4f {
    return vec4f(min(base.rgb + params.strength * light, vec3f(GUARD_MAX)), base.a);
}

fn composite_mean(base: vec4f, light: vec3f, params: Composite) -> vec4f {
    return vec4f(mix(base.rgb, light, params.strength), base.a);
}

fn composite_add_bilinear(base: vec4f, bloom: texture_2d<f32>, bloom_sampler: sampler, at: Point, params: Composite) -> vec4f {
    return composite_sum(base, tap(bloom, bloom_sampler, at.uv).rgb, params);
}

fn composite_add_tent(base: vec4f, bloom: texture_2d<f32>, bloom_sampler: sampler, at: Point, params: Composite) -> vec4f {
    return composite_sum(base, composite_tap9(bloom, bloom_sampler, at, params.radius), params);
}

fn composite_mix_bilinear(base: vec4f, bloom: texture_2d<f32>, bloom_sampler: sampler, at: Point, params: Composite) -> vec4f {
    return composite_mean(base, tap(bloom, bloom_sampler, at.uv).rgb, params);
}

fn composite_mix_tent(base: vec4f, bloom: texture_2d<f32>, bloom_sampler: sampler, at: Point, params: Composite) -> vec4f {
    return composite_mean(base, composite_tap9(bloom, bloom_sampler, at, params.radius), params);
}
