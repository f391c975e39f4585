import afterimage::math::smooth_step;
import package::lib::oklab_rgb::oklab_from_rgb;

struct ColorKey { color: vec3f, tolerance: f32, softness: f32 }

// The opponent colors of a light in units of its lightness. Black is gray.
fn color_key_tint(rgb: vec3f) -> vec2f {
    let lab = oklab_from_rgb(rgb);
    return lab.yz / max(lab.x, 1e-3);
}

fn color_key(source: vec4f, params: ColorKey) -> vec4f {
    let distance = length(color_key_tint(source.rgb) - color_key_tint(params.color));
    let mask = smooth_step(-params.tolerance - params.softness, -params.tolerance, -distance);
    return vec4f(vec3f(mask), 1.0);
}
