// Limits for grading steps: results that a half float can hold, for all parameters.
import package::color::extended_light;
import package::sanitize::HALF_MAX;

// Limits the magnitude to the largest half float and keeps the sign.
fn bounded(v: vec3f) -> vec3f {
    return clamp(v, vec3f(-HALF_MAX), vec3f(HALF_MAX));
}

// Limits light to 0 and the largest half float.
fn bounded_light(v: vec3f) -> vec3f {
    return clamp(v, vec3f(0.0), vec3f(HALF_MAX));
}

// Limits scene light to the largest half float. Negative components stay as long as the luminance is 0 or more.
fn bounded_scene(v: vec3f) -> vec3f {
    return extended_light(bounded(v));
}

// x^y for x up to 2^17 and y above 0. 0 for x at or below 0, the limit where the power is too large, and x itself for y
// = 1, where an exponential of a logarithm is not exact.
fn bounded_power(x: f32, y: f32) -> f32 {
    let stops = min(y * log2(max(x, 1e-30)), 16.0);
    let powered = select(exp2(max(stops, -149.0)), x, y == 1.0);
    return select(min(powered, HALF_MAX), 0.0, x <= 0.0);
}

fn bounded_power3(v: vec3f, y: vec3f) -> vec3f {
    return vec3f(bounded_power(v.x, y.x), bounded_power(v.y, y.y), bounded_power(v.z, y.z));
}
