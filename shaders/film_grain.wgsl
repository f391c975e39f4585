#import math
#import noise

struct FilmGrain {
    amount: f32,
    size: f32,
    color: f32,
    shadows: f32,
    highlights: f32,
    pivot: f32,
    seed: u32,
    luminance_weights: vec3f,
}

// A random number in (-1, 1) for each lattice point, with the triangular distribution of a sum of two uniform numbers.
fn film_grain_point(cell: vec2i, seed: u32) -> f32 {
    let h = hash(bitcast<u32>(cell.x) ^ hash(bitcast<u32>(cell.y) ^ hash(seed)));
    return (f32(h >> 16u) + f32(h & 0xffffu)) * (1.0 / 65536.0) - 1.0;
}

// Interpolates the lattice. Interpolation reduces the variance, so the result is scaled back to that of the points.
fn film_grain_lattice(p: vec2f, seed: u32) -> f32 {
    let base = floor(p);
    let i = vec2i(base);
    let f = p - base;
    let w = f * f * (3.0 - 2.0 * f);
    let low = mix(film_grain_point(i, seed), film_grain_point(i + vec2i(1, 0), seed), w.x);
    let high = mix(film_grain_point(i + vec2i(0, 1), seed), film_grain_point(i + vec2i(1, 1), seed), w.x);
    let power = (w.x * w.x + (1.0 - w.x) * (1.0 - w.x)) * (w.y * w.y + (1.0 - w.y) * (1.0 - w.y));
    return clamp(mix(low, high, w.y) * inverseSqrt(power), -1.0, 1.0);
}

// Strength of the grain at a luminance.
fn film_grain_response(y: f32, params: FilmGrain) -> f32 {
    let rising = mix(params.shadows, 1.0, smooth_step(0.0, params.pivot, y));
    return mix(rising, params.highlights, smooth_step(params.pivot, 1.0, y));
}

// The distance to black and white limits the grain: x + n * x * (1 - x) is in 0..1 for every n in -1..1, and its mean
// is x.
fn film_grain_with(source: vec4f, at: Point, params: FilmGrain, seed: u32) -> vec4f {
    let p = vec2f(at.pixel) / params.size;
    let grey = film_grain_lattice(p, seed * 4u);
    let tinted = vec3f(
        film_grain_lattice(p, seed * 4u + 1u),
        film_grain_lattice(p, seed * 4u + 2u),
        film_grain_lattice(p, seed * 4u + 3u),
    );
    let grain = mix(vec3f(grey), tinted, params.color);
    let rgb = clamp(source.rgb, vec3f(0.0), vec3f(1.0));
    let strength = params.amount * film_grain_response(dot(rgb, params.luminance_weights), params);
    return vec4f(source.rgb + strength * grain * rgb * (1.0 - rgb), source.a);
}

fn film_grain(source: vec4f, at: Point, params: FilmGrain) -> vec4f {
    return film_grain_with(source, at, params, params.seed);
}

fn film_grain_animated(source: vec4f, at: Point, frame: Frame, params: FilmGrain) -> vec4f {
    return film_grain_with(source, at, params, params.seed + frame.index);
}
