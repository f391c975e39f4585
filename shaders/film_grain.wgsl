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
// Where `period` is above 0, the same cells follow each other after so many.
fn film_grain_at(p: vec2f, period: i32, seed: u32) -> vec4f {
    let base = vec2i(floor(p));
    var sum = vec4f();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let cell = base + vec2i(x, y);
            let own = select(cell, (cell + period) % max(period, 1), period > 0);
            let place = hash(bitcast<u32>(own.x) ^ hash(bitcast<u32>(own.y) ^ hash(seed)));
            let inside = vec2f(vec2u(place & 0xffffu, place >> 16u)) * (1.0 / 65536.0);
            let away = vec2f(cell) + inside - p;
            let shape = max(1.0 - dot(away, away), 0.0);
            sum += film_grain_weights(hash(place ^ 0x9e3779b9u)) * (shape * shape);
        }
    }
    return sum * FILM_GRAIN_SCALE;
}

struct FilmGrainTiles {
    size: f32,
}

// Sides of two square tiles of grain, each periodic and the second below the first. Their sum repeats after the product
// of the sides.
const FILM_GRAIN_FIRST: u32 = 256u;
const FILM_GRAIN_SECOND: u32 = 239u;

// A texel of the tiles: a quarter of the grain around 0.5, because images of light hold no negative numbers. Sizes are
// rounded so that a whole number of cells fits.
fn film_grain_tiles(at: Point, params: FilmGrainTiles) -> vec4f {
    let first = i32(FILM_GRAIN_FIRST);
    let is_second = at.pixel.y >= first;
    let side = f32(select(FILM_GRAIN_FIRST, FILM_GRAIN_SECOND, is_second));
    let pixel = vec2i(at.pixel.x, select(at.pixel.y, at.pixel.y - first, is_second));
    let cells = max(round(side / params.size), 1.0);
    let grain = film_grain_at(vec2f(pixel) * (cells / side), i32(cells), select(0u, 1u, is_second));
    return saturate(0.25 * grain + 0.5);
}

// The mixture of the tiles turns by this share of a circle for each pixel away from both axes of the image. From a tile
// to the next it turns differently in each row, once around in 360, so what comes back comes back as its negative as
// often: in images of 720, 1080 and 2160 rows nothing is repeated.
const FILM_GRAIN_TURN: f32 = 1.0 / (360.0 * 256.0);

// Grain from the tiles, moved by random offsets: a sum whose squared weights are 1, so it has the variance of one.
fn film_grain_from(tiles: texture_2d<f32>, at: Point, seed: u32) -> vec4f {
    let offset = vec2u(hash(seed), hash(seed ^ 0x9e3779b9u));
    let pixel = vec2u(at.pixel);
    let first = (pixel + (offset & vec2u(0xffffu))) % FILM_GRAIN_FIRST;
    let second = (pixel + (offset >> vec2u(16u))) % FILM_GRAIN_SECOND + vec2u(0u, FILM_GRAIN_FIRST);
    let away = (at.uv - 0.5) * at.size;
    let angle = 6.2831853 * (fract(away.x * away.y * FILM_GRAIN_TURN) - 0.5);
    return (textureLoad(tiles, first, 0) - 0.5) * (4.0 * cos(angle))
        + (textureLoad(tiles, second, 0) - 0.5) * (4.0 * sin(angle));
}

// Monochrome and colored grain. The squares of the factors sum to 1, so the variance is the same for every `color`.
fn film_grain_density(grain: vec4f, color: f32) -> vec3f {
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
fn film_grain_with(source: vec4f, params: FilmGrain, grain: vec4f) -> vec4f {
    let density = film_grain_density(grain, params.color);
    let rgb = clamp(source.rgb, vec3f(0.0), vec3f(1.0));
    let strength = params.amount * film_grain_response(dot(rgb, params.luminance_weights), params);
    return vec4f(source.rgb + strength * density * rgb * (1.0 - rgb), source.a);
}

fn film_grain(source: vec4f, at: Point, params: FilmGrain) -> vec4f {
    return film_grain_with(source, params, film_grain_at(vec2f(at.pixel) / params.size, 0, params.seed));
}

fn film_grain_animated(source: vec4f, at: Point, frame: Frame, params: FilmGrain) -> vec4f {
    let seed = params.seed + frame.index;
    return film_grain_with(source, params, film_grain_at(vec2f(at.pixel) / params.size, 0, seed));
}

fn film_grain_tiled(source: vec4f, tiles: texture_2d<f32>, at: Point, params: FilmGrain) -> vec4f {
    return film_grain_with(source, params, film_grain_from(tiles, at, params.seed));
}

fn film_grain_tiled_animated(
    source: vec4f,
    tiles: texture_2d<f32>,
    at: Point,
    frame: Frame,
    params: FilmGrain,
) -> vec4f {
    return film_grain_with(source, params, film_grain_from(tiles, at, params.seed + frame.index));
}
