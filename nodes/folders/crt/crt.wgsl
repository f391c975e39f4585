
struct Crt {
    lines: f32,
    line_depth: f32,
    stripe_depth: f32,
    stripe_width: f32,
    curvature: f32,
    softness: f32,
}

// The image, blurred along its lines by the width of the beam.
fn crt_soft(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Crt) -> vec4f {
    let spread = params.softness / params.lines * at.size.y / at.size.x;
    let near = tap(source, source_sampler, at.uv - vec2f(spread, 0.0))
        + tap(source, source_sampler, at.uv + vec2f(spread, 0.0));
    let far = tap(source, source_sampler, at.uv - vec2f(2.0 * spread, 0.0))
        + tap(source, source_sampler, at.uv + vec2f(2.0 * spread, 0.0));
    return 0.375 * tap(source, source_sampler, at.uv) + 0.25 * near + 0.0625 * far;
}

// The place on a flat image that is seen at a place on the bulging glass.
fn crt_glass(uv: vec2f, params: Crt) -> vec2f {
    let place = 2.0 * uv - 1.0;
    let bulge = 1.0 + params.curvature * vec2f(place.y * place.y, place.x * place.x) * 0.5;
    return 0.5 + 0.5 * place * bulge;
}

// 1 on a stripe of phosphor of this color, less on the other two. The mean of three stripes stays the same.
fn crt_stripe(x: f32, params: Crt) -> vec3f {
    let index = i32(x / params.stripe_width) % 3;
    let own = vec3f(vec3i(index) == vec3i(0, 1, 2));
    return mix(vec3f(1.0), 3.0 * own, params.stripe_depth);
}

fn crt(soft: texture_2d<f32>, soft_sampler: sampler, at: Point, params: Crt) -> vec4f {
    let uv = crt_glass(at.uv, params);
    let inside = min(uv, 1.0 - uv) * at.size;
    let edge = clamp(min(inside.x, inside.y) + 0.5, 0.0, 1.0);
    let color = tap(soft, soft_sampler, uv);
    // The mean over a line is 1.
    let line = 1.0 - params.line_depth * cos(6.28318531 * uv.y * params.lines);
    let light = color.rgb * line * crt_stripe(f32(at.pixel.x), params) * edge;
    return vec4f(light, color.a);
}
