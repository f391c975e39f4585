import afterimage::color::brightest;
import afterimage::grade::bounded_scene;

struct GodRays {
    light: vec2f,
    spread: f32,
    strength: f32,
    length: f32,
    falloff: f32,
    limit: f32,
    color: vec3f,
}

// Reads of a pass, and of both passes.
const GOD_RAYS_READS: i32 = 8;
const GOD_RAYS_SAMPLES: f32 = 64.0;

// The share of a bright place that belongs to the light: a lamp elsewhere makes no shafts from it.
fn god_rays_share(from_light: vec2f, size: vec2f, params: GodRays) -> f32 {
    let apart = from_light * size / size.y;
    let share = exp2(-dot(apart, apart) / max(params.spread * params.spread, 1e-6));
    return select(1.0, share, params.spread > 0.0);
}

// The mean of places on the way to the light: each is `step` samples nearer to it than the one before. The distance
// shrinks by the same factor with each sample, and so does the weight; hence a pass over the result of another makes
// the samples of both. The first pass reads the bright image.
fn god_rays_along(t: texture_2d<f32>, s: sampler, uv: vec2f, step: f32, params: GodRays) -> vec4f {
    let shrink = pow(1.0 - params.length, step / GOD_RAYS_SAMPLES);
    let fade = pow(params.falloff, step / GOD_RAYS_SAMPLES);
    var from_light = uv - params.light;
    var weight = 1.0;
    var sum = vec3f();
    var total = 0.0;
    for (var read = 0; read < GOD_RAYS_READS; read++) {
        let place = params.light + from_light;
        let is_inside = all(place == clamp(place, vec2f(0.0), vec2f(1.0)));
        let seen = tap(t, s, place).rgb;
        let near = select(1.0, god_rays_share(from_light, vec2f(textureDimensions(t)), params), step == 1.0);
        let share = near * min(params.limit / max(brightest(seen), 1e-6), 1.0);
        sum += select(0.0, weight * share, is_inside) * seen;
        total += weight;
        weight *= fade;
        from_light *= shrink;
    }
    return vec4f(sum / total, 1.0);
}

fn god_rays_near(bright: texture_2d<f32>, bright_sampler: sampler, at: Point, params: GodRays) -> vec4f {
    return god_rays_along(bright, bright_sampler, at.uv, 1.0, params);
}

fn god_rays_rays(near: texture_2d<f32>, near_sampler: sampler, at: Point, params: GodRays) -> vec4f {
    return god_rays_along(near, near_sampler, at.uv, f32(GOD_RAYS_READS), params);
}

fn god_rays(source: vec4f, rays: texture_2d<f32>, rays_sampler: sampler, at: Point, params: GodRays) -> vec4f {
    if params.strength == 0.0 { return source; }
    let light = params.strength * params.color * max(tap(rays, rays_sampler, at.uv).rgb, vec3f(0.0));
    return vec4f(bounded_scene(source.rgb + light), source.a);
}
