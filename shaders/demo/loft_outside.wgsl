// The view through the loft's window: a low sun, a clear sky, hills and a city in haze.
import package::loft_lamps::{LOFT_SUN, LOFT_SUN_DISC, LOFT_SUN_RADIUS, LoftLamps};
import afterimage::noise::{hash_cell, noise_cell};

fn loft_sky(direction: vec3f) -> vec3f {
    let height = max(direction.y, 0.0);
    let base = mix(vec3f(8.5, 5.3, 3.1), vec3f(1.1, 2.3, 4.6), 1.0 - exp(-5.0 * height));
    let away = acos(clamp(dot(direction, LOFT_SUN), -1.0, 1.0));
    return base + vec3f(7.0, 4.6, 2.2) * exp(-5.0 * away) + vec3f(60.0, 46.0, 30.0) * exp(-60.0 * away);
}

// The disc of the sun, with limb darkening.
fn loft_sun(direction: vec3f) -> vec3f {
    let away = length(direction - LOFT_SUN) / LOFT_SUN_RADIUS;
    return LOFT_SUN_DISC * (0.6 + 0.4 * sqrt(max(1.0 - away * away, 0.0))) * step(away, 1.0);
}

// One of five rows of houses, the nearest last; coverage in w. `at` is the tangent of the horizontal and vertical
// angle.
fn loft_street(at: vec2f, row: i32, haze: vec3f) -> vec4f {
    let rank = f32(row);
    let width = 0.026 * exp2(0.62 * rank);
    let across = at.x / width + 0.37 * rank;
    let house = noise_cell(vec2f(across, rank));
    let chance = hash_cell(house);
    let top = 0.022 - 0.042 * rank + width * (0.1 + 1.5 * chance * chance);
    let story = vec2f(fract(across) * 8.0, (top - at.y) / width * 6.0);
    let glazed = step(0.3, fract(story.x)) * step(0.35, fract(story.y)) * step(0.5, story.y);
    let lit = step(0.92, hash_cell(noise_cell(story) + vec2i(house.x * 13, row * 71)));
    let corner = 0.7 + 0.6 * step(0.5, fract(across)) * chance;
    let wall = mix(vec3f(0.55, 0.46, 0.43), vec3f(0.14, 0.17, 0.23), fract(chance * 7.0)) * corner;
    let glass = mix(wall * 0.55, vec3f(2.4, 1.7, 0.9), lit * 0.7);
    return vec4f(mix(haze, mix(wall, glass, glazed), 0.22 + 0.15 * rank), step(at.y, top));
}

// Radiance from outside. Everything is far away, so it depends only on the direction.
fn loft_view(direction: vec3f, lamps: LoftLamps) -> vec3f {
    let at = direction.xy / max(-direction.z, 1e-3);
    var color = loft_sky(direction) * lamps.sky;
    let haze = loft_sky(vec3f(direction.x, 0.02, direction.z)) * 0.42;
    let ridge = 0.066 + 0.025 * sin(at.x * 2.3 + 0.6) + 0.012 * sin(at.x * 6.1) + 0.004 * sin(at.x * 17.0);
    let near = ridge - 0.02 - 0.016 * sin(at.x * 3.7 + 2.0);
    if at.y < ridge { color = haze * vec3f(0.92, 1.0, 1.12) * lamps.sky; }
    if at.y < near { color = haze * vec3f(0.66, 0.78, 0.92) * lamps.sky; }
    for (var row = 0; row < 5; row++) {
        let street = loft_street(at, row, haze * vec3f(0.75, 0.75, 0.8));
        color = mix(color, street.rgb * lamps.sky, street.w);
    }
    return color + loft_sun(direction) * lamps.sun * step(ridge, at.y);
}
