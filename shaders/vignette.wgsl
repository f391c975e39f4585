import afterimage::math::smooth_step;

struct Vignette {
    amount: f32,
    intensity: f32,
    smoothness: f32,
    stretch: f32,
    center: vec2f,
}

fn vignette(source: vec4f, at: Point, params: Vignette) -> vec4f {
    let centered = (at.uv - params.center) * vec2f(params.stretch, 1.0);
    let radius = length(centered) * (1.0 + params.intensity);
    // A rising step, because smoothstep is undefined for reversed edges.
    let light = 1.0 - smooth_step(0.5 - params.smoothness, 0.5, radius);
    return vec4f(source.rgb * mix(1.0, light, params.amount), source.a);
}
