import afterimage::math::smooth_step;
import afterimage::noise::hash;

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

// The variance of a grain's density becomes 1/8: more would be clipped by more than 2 %. A grain covers the integral of
// its squared shape, pi / 5 cells, and a uniform weight has the variance 1/3.
const FILM_GRAIN_SCALE: f32 = 0.77254844;

// The bytes of a random number as weights in (-1, 1).
fn film_grain_weights(h: u32) -> vec4f {
    let bytes = vec4u(h, h >> 8u, h >> 16u, h >> 24u) & vec4u(0xffu);
    return (vec4f(bytes) + 0.5) * (1.0 / 128.0) - 1.0;
}

// One grain in each cell, at a random position: the sum of their round shapes (1 - r^2)^2 with random weights.
// Positions are uniform, so the variance is the same everywhere, and weights are independent, so the spectrum is that
// of one grain and has no direction. Red to blue of the result have weights of their own, and w those of gray grain.
fn film_grain_at(p: vec2f, seed: u32) -> vec4f {
    let base = vec2i(floor(p));
    var sum = vec4f();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let cell = base + vec2i(x, y);
            let place = hash(bitcast<u32>(cell.x) ^ hash(bitcast<u32>(cell.y) ^ hash(seed)));
            let inside = vec2f(vec2u(place & 0xffffu, place >> 16u)) * (1.0 / 65536.0);
            let away = vec2f(cell) + inside - p;
            let shape = max(1.0 - dot(away, away), 0.0);
            sum += film_grain_weights(hash(place ^ 0x9e3779b9u)) * (shape * shape);
        }
    }
    return sum * FILM_GRAIN_SCALE;
}

// Monochrome and colored grain. The squares of the factors sum to 1, so the variance is the same for every `color`.
fn film_grain_density(p: vec2f, seed: u32, color: f32) -> vec3f {
    let grain = film_grain_at(p, seed);
    let density = sqrt(1.0 - color) * vec3f(grain.w) + sqrt(color) * grain.rgb;
    return clamp(density, vec3f(-1.0), vec3f(1.0));
}

// Strength of the grain at a luminance.
fn film_grain_response(y: f32, params: FilmGrain) -> f32 {
    let rising = mix(params.shadows, 1.0, smooth_step(0.0, params.pivot, y));
    return mix(rising, params.highlights, smooth_step(params.pivot, 1.0, y));
}

// The distance to black and white limits the grain: x + n * x * (1 - x) is in 0..1 for every n in -1..1, and its mean
// is x.
fn film_grain_with(source: vec4f, at: Point, params: FilmGrain, seed: u32) -> vec4f {
    let grain = film_grain_density(vec2f(at.pixel) / params.size, seed, params.color);
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
