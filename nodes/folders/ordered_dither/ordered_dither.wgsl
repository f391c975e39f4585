import package::lib::bayer::bayer_threshold;
import afterimage::color::luminance;
import afterimage::math::between3;

struct OrderedDither {
    levels: i32,
    dot: i32,
    pattern: f32,
    gray: u32,
    amount: f32,
}

fn ordered_dither(source: vec4f, at: Point, params: OrderedDither) -> vec4f {
    let threshold = bayer_threshold(at.pixel / params.dot) - 0.5;
    let color = select(source.rgb, vec3f(luminance(source.rgb)), params.gray != 0u);
    let steps = f32(params.levels - 1);
    let level = floor(clamp(color, vec3f(0.0), vec3f(1.0)) * steps + 0.5 + params.pattern * threshold);
    return vec4f(between3(source.rgb, level / steps, params.amount), source.a);
}
