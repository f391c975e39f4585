import afterimage::grade::{bounded_light, bounded_scene};

struct Saturation {
    amount: f32,
    luminance_weights: vec3f,
}

fn saturation_moved(source: vec4f, params: Saturation) -> vec3f {
    let gray = vec3f(dot(source.rgb, params.luminance_weights));
    return gray + params.amount * (source.rgb - gray);
}

fn saturation_scene(source: vec4f, params: Saturation) -> vec4f {
    return vec4f(bounded_scene(saturation_moved(source, params)), source.a);
}

fn saturation_display(source: vec4f, params: Saturation) -> vec4f {
    return vec4f(bounded_light(saturation_moved(source, params)), source.a);
}
