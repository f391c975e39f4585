import afterimage::color::level_luminance;
import afterimage::grade::bounded_scene;
import afterimage::math::{between3, smooth_step};

struct LogWheels {
    shadows: vec3f,
    midtones: vec3f,
    highlights: vec3f,
    low: f32,
    high: f32,
    softness: f32,
}

fn log_wheels(source: vec4f, params: LogWheels) -> vec4f {
    let stops = log2(max(level_luminance(source.rgb), 1e-9) / 0.18);
    let half = 0.5 * params.softness;
    let above_low = smooth_step(params.low - half, params.low + half, stops);
    let above_high = smooth_step(params.high - half, params.high + half, stops);
    let own = between3(between3(params.shadows, params.midtones, above_low), params.highlights, above_high);
    if all(own == vec3f(0.0)) { return source; }
    return vec4f(bounded_scene(source.rgb * exp2(own)), source.a);
}
