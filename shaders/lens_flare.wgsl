// Reflections between the glass surfaces of a lens, from the image itself: ghosts on the line through the center, and a
// ring. After Chapman, "Pseudo Lens Flare", 2013; ghosts have magnifications, as in Hullin et al., "Physically-Based
// Real-Time Lens Flare Rendering", 2011.
import afterimage::color::brightest;
import afterimage::grade::bounded_scene;
import afterimage::math::smooth_step;

struct LensFlare {
    threshold: f32,
    limit: f32,
    ghosts: i32,
    spacing: f32,
    ghost_strength: f32,
    halo_radius: f32,
    halo_strength: f32,
    dispersion: f32,
    aspect: f32,
}

// The colors that coatings leave of the reflections; each has the luminance 1.
const LENS_FLARE_TINTS = array<vec3f, 4>(
    vec3f(0.6, 1.0785, 1.4),
    vec3f(1.6, 0.8418, 0.8),
    vec3f(0.8, 1.1099, 0.5),
    vec3f(1.1, 0.8996, 1.7),
);
// The share of the image at its border in which light fades: a light that leaves the image must not switch its ghosts
// off at once.
const LENS_FLARE_FADE: f32 = 0.1;

fn lens_flare_window(uv: vec2f) -> f32 {
    let inside = min(uv, 1.0 - uv);
    return smooth_step(0.0, LENS_FLARE_FADE, inside.x) * smooth_step(0.0, LENS_FLARE_FADE, inside.y);
}

// Light in its own color, the same up to half of the limit and below the limit from there on.
fn lens_flare_limited(light: vec3f, limit: f32) -> vec3f {
    let most = brightest(light);
    let knee = 0.5 * limit;
    let over = max(most, knee);
    return light * select((limit - knee * knee / over) / over, 1.0, most <= knee);
}

// The light at a place relative to the center, with red and blue read nearer to it and farther from it.
fn lens_flare_light(
    source: texture_2d<f32>,
    s: sampler,
    place: vec2f,
    dispersion: f32,
    params: LensFlare,
) -> vec3f {
    let red = 0.5 + place * (1.0 - dispersion);
    let green = 0.5 + place;
    let blue = 0.5 + place * (1.0 + dispersion);
    let light = vec3f(tap(source, s, red).r, tap(source, s, green).g, tap(source, s, blue).b);
    let window = vec3f(lens_flare_window(red), lens_flare_window(green), lens_flare_window(blue));
    return window * lens_flare_limited(max(light - params.threshold, vec3f(0.0)), params.limit);
}

// A ghost is the image with a magnification: -1, 2, -3, 4 and so on times the spacing.
fn lens_flare_ghosts(source: texture_2d<f32>, s: sampler, place: vec2f, params: LensFlare) -> vec3f {
    var sum = vec3f(0.0);
    for (var i = 0; i < min(params.ghosts, 8); i++) {
        let size = select(1.0, -1.0, (i & 1) == 0) * f32(i + 1) * params.spacing;
        let light = lens_flare_light(source, s, place / size, params.dispersion, params);
        sum += LENS_FLARE_TINTS[i & 3] * light;
    }
    return sum / f32(max(params.ghosts, 1));
}

fn lens_flare_halo(source: texture_2d<f32>, s: sampler, place: vec2f, params: LensFlare) -> vec3f {
    let stretch = vec2f(params.aspect, 1.0);
    let round = place * stretch;
    let outwards = round / max(length(round), 1e-6);
    let place_of_light = (params.halo_radius * outwards - round) / stretch;
    return lens_flare_light(source, s, place_of_light, 4.0 * params.dispersion, params);
}

fn lens_flare(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: LensFlare) -> vec4f {
    let place = at.uv - 0.5;
    let ghosts = params.ghost_strength * lens_flare_ghosts(source, source_sampler, place, params);
    let halo = params.halo_strength * lens_flare_halo(source, source_sampler, place, params);
    return vec4f(bounded_scene(ghosts + halo), 0.0);
}
