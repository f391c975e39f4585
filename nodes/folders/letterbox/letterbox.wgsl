import afterimage::math::between3;

struct Letterbox { aspect: f32, color: vec3f, amount: f32 }

fn letterbox(source: vec4f, at: Point, params: Letterbox) -> vec4f {
    let half_size = 0.5 * at.size;
    let inner = min(half_size, half_size.yx * vec2f(params.aspect, 1.0 / params.aspect));
    // The distance of the pixel's center beyond the edge of the nearest bar.
    let beyond = abs(vec2f(at.pixel) + 0.5 - half_size) - half_size + params.amount * (half_size - inner);
    let covered = clamp(max(beyond.x, beyond.y) + 0.5, 0.0, 1.0);
    return vec4f(between3(source.rgb, params.color, covered), source.a + covered * (1.0 - source.a));
}
