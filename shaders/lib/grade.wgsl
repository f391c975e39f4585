// What every grading step needs: results that a half float can hold, whatever the controls are.
#import sanitize

// The largest magnitude that a picture may have; the sign is kept.
fn bounded(v: vec3f) -> vec3f {
    return clamp(v, vec3f(-HALF_MAX), vec3f(HALF_MAX));
}

// No light below black.
fn bounded_light(v: vec3f) -> vec3f {
    return clamp(v, vec3f(0.0), vec3f(HALF_MAX));
}

// x^y for any x up to 2^17 and any y above 0: 0 for what is not positive, the bound where the power would be too large,
// and x itself for y = 1, where an exponential of a logarithm is not exact.
fn bounded_power(x: f32, y: f32) -> f32 {
    let stops = min(y * log2(max(x, 1e-30)), 16.0);
    let powered = select(exp2(max(stops, -149.0)), x, y == 1.0);
    return select(min(powered, HALF_MAX), 0.0, x <= 0.0);
}

fn bounded_power3(v: vec3f, y: vec3f) -> vec3f {
    return vec3f(bounded_power(v.x, y.x), bounded_power(v.y, y.y), bounded_power(v.z, y.z));
}
