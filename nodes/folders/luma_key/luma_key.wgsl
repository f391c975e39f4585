import afterimage::color::luminance;
import afterimage::math::smooth_step;
import package::lib::srgb::srgb_to_code;

struct LumaKey { low: f32, high: f32, softness: f32 }

fn luma_key(source: vec4f, params: LumaKey) -> vec4f {
    let code = srgb_to_code(vec3f(luminance(source.rgb))).x;
    let above = smooth_step(params.low - params.softness, params.low, code);
    let below = smooth_step(-params.high - params.softness, -params.high, -code);
    return vec4f(vec3f(above * below), 1.0);
}
