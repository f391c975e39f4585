// Dirt on the front glass: it scatters the light of bloom and flares, so that it is seen only where they are.
import afterimage::grade::bounded_scene;
import afterimage::math::smooth_step;
import afterimage::noise::{hash, hash3, noise_cell};

struct LensDirt {
    strength: f32,
    scale: f32,
    seed: u32,
    aspect: f32,
}

fn lens_dirt_lit(source: vec4f, dirt: vec3f, params: LensDirt) -> vec4f {
    return vec4f(bounded_scene(source.rgb * (1.0 + params.strength * max(dirt, vec3f(0.0)))), source.a);
}

// A smudge in a cell: a disc with a soft edge. Its place, its radius from 0.1 to 0.5 cells and its weight are random.
fn lens_dirt_smudge(p: vec2f, cell: vec2i, seed: u32) -> f32 {
    let random = vec3f(hash3(vec3u(bitcast<vec2u>(cell), seed)) >> vec3u(8u)) / 16777216.0;
    let more = f32(hash(seed ^ hash(bitcast<u32>(cell.x) ^ hash(bitcast<u32>(cell.y)))) >> 8u) / 16777216.0;
    let radius = 0.1 + 0.4 * random.z * random.z;
    let distance = length(vec2f(cell) + random.xy - p);
    return more * more * (1.0 - smooth_step(0.5 * radius, radius, distance));
}

// The smudges of the nine cells around a place.
fn lens_dirt_layer(p: vec2f, seed: u32) -> f32 {
    let center = noise_cell(p);
    var sum = 0.0;
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            sum += lens_dirt_smudge(p, center + vec2i(x, y), seed);
        }
    }
    return sum;
}

// Three layers, each with half the size and half the weight of the one before.
fn lens_dirt(source: vec4f, at: Point, params: LensDirt) -> vec4f {
    let p = at.uv * vec2f(params.aspect, 1.0) * params.scale;
    let coarse = lens_dirt_layer(p, params.seed);
    let medium = lens_dirt_layer(2.0 * p, params.seed + 1u);
    let fine = lens_dirt_layer(4.0 * p, params.seed + 2u);
    return lens_dirt_lit(source, vec3f(coarse + 0.5 * medium + 0.25 * fine), params);
}

fn lens_dirt_image(
    source: vec4f,
    dirt: texture_2d<f32>,
    dirt_sampler: sampler,
    at: Point,
    params: LensDirt,
) -> vec4f {
    return lens_dirt_lit(source, tap(dirt, dirt_sampler, at.uv).rgb, params);
}
