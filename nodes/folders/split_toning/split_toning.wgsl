import afterimage::grade::bounded_light;
import afterimage::math::smooth_step;
import package::lib::oklab_rgb::{oklab_from_rgb, oklab_to_rgb};

struct SplitToning {
    shadow_hue: f32,
    shadow_amount: f32,
    highlight_hue: f32,
    highlight_amount: f32,
    balance: f32,
}

// The lightness to both sides of the balance over which one tint fades into the other.
const SPLIT_TONING_FADE: f32 = 0.25;

fn split_toning_tint(hue: f32, amount: f32) -> vec2f {
    let angle = radians(hue);
    return 0.1 * amount * vec2f(cos(angle), sin(angle));
}

fn split_toning(source: vec4f, params: SplitToning) -> vec4f {
    if params.shadow_amount == 0.0 && params.highlight_amount == 0.0 { return source; }
    let lab = oklab_from_rgb(source.rgb);
    let lightness = clamp(lab.x, 0.0, 1.0);
    let weight = 4.0 * lightness * (1.0 - lightness);
    let share = smooth_step(params.balance - SPLIT_TONING_FADE, params.balance + SPLIT_TONING_FADE, lightness);
    let shadow = split_toning_tint(params.shadow_hue, params.shadow_amount);
    let highlight = split_toning_tint(params.highlight_hue, params.highlight_amount);
    let tint = weight * mix(shadow, highlight, share);
    return vec4f(bounded_light(oklab_to_rgb(vec3f(lab.x, lab.yz + tint))), source.a);
}
