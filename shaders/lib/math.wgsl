// Functions that are defined where the WGSL built-ins are not.

// Hermite step from 0 at `lo` to 1 at `hi`. A hard step if the edges are equal or reversed, for which `smoothstep` is
// undefined.
fn smooth_step(lo: f32, hi: f32, x: f32) -> f32 {
    let width = hi - lo;
    let t = clamp((x - lo) / max(width, 1e-30), 0.0, 1.0);
    return select(t * t * (3.0 - 2.0 * t), select(0.0, 1.0, x >= hi), width <= 0.0);
}

// Interpolates from `a` at 0 to `b` at 1, exact at both. `mix` may be a + (b - a) * t, which loses a small `b` beside a
// large `a`.
fn between(a: vec4f, b: vec4f, t: f32) -> vec4f {
    return a * (1.0 - t) + b * t;
}

fn between3(a: vec3f, b: vec3f, t: f32) -> vec3f {
    return a * (1.0 - t) + b * t;
}

// The nearest half floats of finite numbers, for devices that round toward zero where they store them. Of two that are
// equally near, the one with an even last bit; below 2^-14 a unit in the last place is not rounded.
fn nearest_half(v: vec4f) -> vec4f {
    let bits = bitcast<vec4u>(v);
    let rounded = bits + vec4u(0xfffu) + ((bits >> vec4u(13u)) & vec4u(1u));
    let is_less = (bits & vec4u(0x7fffffffu)) < vec4u(0x477fe000u);
    return select(v, bitcast<vec4f>(rounded), is_less);
}

// x^y for x >= 0, exactly 0 at 0: `pow` may be exp2(y * log2(x)).
fn power(x: f32, y: f32) -> f32 {
    return select(pow(max(x, 1e-30), y), 0.0, x <= 0.0);
}

fn power3(v: vec3f, y: f32) -> vec3f {
    return vec3f(power(v.x, y), power(v.y, y), power(v.z, y));
}

// Channels that are at least `least`, smoothly: from 2 * least on they stay the same, from 0 down they become `least`.
fn soft_floor(v: vec3f, least: f32) -> vec3f {
    let light = max(v, vec3f(0.0));
    let missing = max(2.0 * least - light, vec3f(0.0));
    return light + missing * missing * (0.25 / max(least, 1e-30));
}

fn mean3(v: vec3f) -> f32 {
    return dot(v, vec3f(1.0 / 3.0));
}
