import afterimage::grade::bounded_light;

struct ColorBalance {
    multiply: vec3f,
    shadows: vec3f,
    midtones: vec3f,
    highlights: vec3f,
    luminance_weights: vec3f,
}

// The weights (1 - y)^2, 2y(1 - y) and y^2 are smooth, and their sum is 1: three equal shifts are one constant shift.
fn color_balance(source: vec4f, params: ColorBalance) -> vec4f {
    let rgb = source.rgb * params.multiply;
    let y = clamp(dot(rgb, params.luminance_weights), 0.0, 1.0);
    let shift = mix(mix(params.shadows, params.midtones, y), mix(params.midtones, params.highlights, y), y);
    return vec4f(bounded_light(rgb + shift), source.a);
}
