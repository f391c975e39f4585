import afterimage::grade::bounded_scene;

struct Exposure {
    stops: f32,
    gain: f32,
}

fn exposure(source: vec4f, params: Exposure) -> vec4f {
    return vec4f(bounded_scene(source.rgb * params.gain), source.a);
}

fn exposure_metered(source: vec4f, meter: f32, params: Exposure) -> vec4f {
    let gain = exp2(clamp(params.stops + meter, -24.0, 24.0));
    return vec4f(bounded_scene(source.rgb * gain), source.a);
}
