// A look, not a model of night vision: less saturated, bluer and brighter as the light fades.
import afterimage::color::{extended_light, luminance};
import afterimage::math::{between3, smooth_step};
import afterimage::sanitize::HALF_MAX;

struct PurkinjeSimple {
    gray: f32,
    blue: f32,
    boost: f32,
    strength: f32,
}

fn purkinje_simple_seen(source: vec4f, gray: f32, blue: f32, boost: f32) -> vec4f {
    let y = luminance(source.rgb);
    let faded = between3(source.rgb, vec3f(y), gray);
    let tinted = vec3f(mix(faded.r, 0.9 * y, blue), faded.g, mix(faded.b, 1.2 * y, blue));
    // No component becomes more negative than the light is.
    let seen = clamp(tinted + boost * y, min(source.rgb, vec3f(0.0)), vec3f(HALF_MAX));
    return vec4f(extended_light(seen), source.a);
}

fn purkinje_simple(source: vec4f, params: PurkinjeSimple) -> vec4f {
    return purkinje_simple_seen(source, params.gray, params.blue, params.boost);
}

// `meter` is an exposure's result: lux in z, 1 in w if it is valid.
fn purkinje_simple_metered(source: vec4f, meter: vec4f, params: PurkinjeSimple) -> vec4f {
    let lux = clamp(meter.z, 0.0, 1e6);
    if meter.w <= 0.0 || lux >= 10.0 { return source; }
    // Negated, so that nothing cancels where the effect is weak.
    let gray = 0.7 * smooth_step(-10.0, -0.01, -lux);
    let blue = 0.3 * smooth_step(-5.0, -0.01, -lux);
    let boost = 0.5 * smooth_step(-1.0, -0.001, -lux);
    return purkinje_simple_seen(source, params.strength * gray, params.strength * blue, params.strength * boost);
}
