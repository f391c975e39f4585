// The Purkinje shift: rods share the pathways of the cones, so that colors turn blue and lose their differences in the
// dark. Cao, Pokorny and Smith (2008) for the retina, Kirk and O'Brien (2011) for images, Patry (2021) for games.
import afterimage::color::extended_light;
import afterimage::math::smooth_step;
import afterimage::sanitize::HALF_MAX;

struct Purkinje {
    // Rows from the model: the input of each cone's gain, the response of the rods, and their effect on Rec.709.
    drive0: vec3f,
    drive1: vec3f,
    drive2: vec3f,
    rods: vec3f,
    effect0: vec3f,
    effect1: vec3f,
    effect2: vec3f,
    strength: f32,
}

const PURKINJE_LOG10_2: f32 = 0.30102999566;

fn purkinje_seen(source: vec4f, strength: f32, params: Purkinje) -> vec4f {
    let light = max(source.rgb, vec3f(0.0));
    let drive = vec3f(dot(params.drive0, light), dot(params.drive1, light), dot(params.drive2, light));
    let gain = inverseSqrt(1.0 + max(drive, vec3f(0.0)));
    let change = vec3f(dot(params.effect0, gain), dot(params.effect1, gain), dot(params.effect2, gain));
    let shift = strength * dot(params.rods, light) * change;
    // No component becomes more negative than the light is.
    let seen = clamp(source.rgb + shift, min(source.rgb, vec3f(0.0)), vec3f(HALF_MAX));
    return vec4f(extended_light(seen), source.a);
}

fn purkinje(source: vec4f, params: Purkinje) -> vec4f {
    return purkinje_seen(source, params.strength, params);
}

// `meter` is an exposure's result: lux in z, 1 in w if it is valid. The ramp is a Hermite step in log10 of lux from
// 0.01 to 10, because mesopic vision spans decades.
fn purkinje_metered(source: vec4f, meter: vec4f, params: Purkinje) -> vec4f {
    let lux = clamp(meter.z, 1e-6, 1e6);
    // Negated, so that nothing cancels where the effect is weak.
    let dark = smooth_step(-1.0, 2.0, -log2(lux) * PURKINJE_LOG10_2);
    let strength = select(0.0, params.strength * dark, meter.w > 0.0 && lux < 10.0);
    if strength <= 0.0 { return source; }
    return purkinje_seen(source, strength, params);
}
