// Halation: light that passes the emulsion of a film, is reflected by the back of its base and exposes the film again
// around the place where it arrived.
import afterimage::grade::bounded_scene;
import afterimage::math::mean3;
import afterimage::tent::tap_tent;

struct Halation {
    strength: f32,
    tint: vec3f,
}

// The sum of all light stays the same: what arrives elsewhere is missing here.
fn halation_spread(source: vec4f, glow: vec4f, params: Halation) -> vec4f {
    let share = params.strength * params.tint;
    let alpha = source.a + mean3(share) * (glow.a - source.a);
    return vec4f(bounded_scene(source.rgb * (1.0 - share) + glow.rgb * share), alpha);
}

fn halation(
    source: vec4f,
    glow: texture_2d<f32>,
    glow_sampler: sampler,
    at: Point,
    params: Halation,
) -> vec4f {
    return halation_spread(source, tap_tent(glow, glow_sampler, at.uv, 1.0, false), params);
}

fn halation_pixel(source: vec4f, glow: vec4f, params: Halation) -> vec4f {
    return halation_spread(source, glow, params);
}
