import afterimage::math::smooth_step;

struct GradientMask {
    start: vec2f,
    end: vec2f,
    level: f32,
    mirror: u32,
    invert: u32,
}

fn gradient_mask(source: vec4f, at: Point, params: GradientMask) -> vec4f {
    let way = (params.end - params.start) * at.size;
    let place = vec2f(at.pixel) + 0.5 - params.start * at.size;
    let along = dot(place, way) / max(dot(way, way), 1e-6);
    let share = smooth_step(params.level, 1.0, select(along, abs(along), params.mirror != 0u));
    return vec4f(vec3f(select(share, 1.0 - share, params.invert != 0u)), 1.0);
}
