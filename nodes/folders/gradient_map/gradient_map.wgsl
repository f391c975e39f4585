import afterimage::color::luminance;
import afterimage::grade::bounded_light;
import afterimage::math::between3;
import package::lib::oklab_rgb::{oklab_from_rgb, oklab_to_rgb};
import package::lib::srgb::srgb_to_code;

struct GradientMap {
    black: vec3f,
    shadows: vec3f,
    middle: vec3f,
    highlights: vec3f,
    white: vec3f,
    amount: f32,
}

fn gradient_map(source: vec4f, params: GradientMap) -> vec4f {
    if params.amount == 0.0 { return source; }
    let light = luminance(source.rgb);
    let place = clamp(4.0 * srgb_to_code(vec3f(light)).x, 0.0, 3.999999);
    let is_high = place >= 2.0;
    let is_odd = fract(0.5 * place) >= 0.5;
    let middle = select(params.shadows, params.highlights, is_high);
    let first = select(select(params.black, params.middle, is_high), middle, is_odd);
    let last = select(params.middle, params.white, is_high);
    let second = select(middle, last, is_odd);
    let mixed = between3(oklab_from_rgb(first), oklab_from_rgb(second), fract(place));
    let at_end = select(oklab_to_rgb(mixed), params.white * light, light >= 1.0);
    return vec4f(bounded_light(between3(source.rgb, at_end, params.amount)), source.a);
}
