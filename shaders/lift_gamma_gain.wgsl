import afterimage::grade::bounded_power3;

struct LiftGammaGain {
    lift: vec3f,
    power: vec3f,  // 1 / gamma
    gain: vec3f,
    luminance_weights: vec3f,
}

// The lift fades with luminance. Above white it is 0, or it would change its sign.
fn lift_gamma_gain(source: vec4f, params: LiftGammaGain) -> vec4f {
    let gained = source.rgb * params.gain;
    let shade = clamp(1.0 - dot(gained, params.luminance_weights), 0.0, 1.0);
    return vec4f(bounded_power3(gained + params.lift * shade, params.power), source.a);
}

fn lift_gamma_gain_channels(source: vec4f, params: LiftGammaGain) -> vec4f {
    let lifted = source.rgb + params.lift * (1.0 - min(source.rgb, vec3f(1.0)));
    return vec4f(bounded_power3(lifted * params.gain, params.power), source.a);
}
