import afterimage::color::luminance;
import afterimage::math::between3;
import package::lib::monotone::{MonotonePoints, monotone_curve, monotone_points};
import package::lib::srgb::{srgb_from_code, srgb_to_code};

struct Curves {
    luminance_black: vec2f,
    luminance_shadows: vec2f,
    luminance_middle: vec2f,
    luminance_highlights: vec2f,
    luminance_white: vec2f,
    rgb_black: vec2f,
    rgb_shadows: vec2f,
    rgb_middle: vec2f,
    rgb_highlights: vec2f,
    rgb_white: vec2f,
    red_black: vec2f,
    red_shadows: vec2f,
    red_middle: vec2f,
    red_highlights: vec2f,
    red_white: vec2f,
    green_black: vec2f,
    green_shadows: vec2f,
    green_middle: vec2f,
    green_highlights: vec2f,
    green_white: vec2f,
    blue_black: vec2f,
    blue_shadows: vec2f,
    blue_middle: vec2f,
    blue_highlights: vec2f,
    blue_white: vec2f,
    amount: f32,
}

// True if all points lie on the diagonal, where the curve is straight.
fn curves_is_straight(p: MonotonePoints) -> bool {
    return p.p0.x == p.p0.y && p.p1.x == p.p1.y && p.p2.x == p.p2.y && p.p3.x == p.p3.y && p.p4.x == p.p4.y;
}

// Light with another luminance: scaled, and by gray where the scale is beyond reason.
fn curves_relight(rgb: vec3f, own: f32, other: f32) -> vec3f {
    let scale = min(other / max(own, 1e-6), 64.0);
    return scale * rgb + (other - scale * own);
}

fn curves(source: vec4f, params: Curves) -> vec4f {
    let luminance_curve = monotone_points(
        params.luminance_black,
        params.luminance_shadows,
        params.luminance_middle,
        params.luminance_highlights,
        params.luminance_white,
    );
    let rgb_curve = monotone_points(
        params.rgb_black,
        params.rgb_shadows,
        params.rgb_middle,
        params.rgb_highlights,
        params.rgb_white,
    );
    let red = monotone_points(
        params.red_black,
        params.red_shadows,
        params.red_middle,
        params.red_highlights,
        params.red_white,
    );
    let green = monotone_points(
        params.green_black,
        params.green_shadows,
        params.green_middle,
        params.green_highlights,
        params.green_white,
    );
    let blue = monotone_points(
        params.blue_black,
        params.blue_shadows,
        params.blue_middle,
        params.blue_highlights,
        params.blue_white,
    );
    var rgb = source.rgb;
    if !curves_is_straight(luminance_curve) {
        let seen = max(luminance(rgb), 0.0);
        let bent = monotone_curve(luminance_curve, srgb_to_code(vec3f(seen)).x);
        rgb = curves_relight(rgb, seen, srgb_from_code(vec3f(bent)).x);
    }
    let is_straight = vec3<bool>(curves_is_straight(red), curves_is_straight(green), curves_is_straight(blue));
    if !(curves_is_straight(rgb_curve) && all(is_straight)) {
        var code = srgb_to_code(rgb);
        code = vec3f(
            monotone_curve(rgb_curve, code.r),
            monotone_curve(rgb_curve, code.g),
            monotone_curve(rgb_curve, code.b),
        );
        code = vec3f(monotone_curve(red, code.r), monotone_curve(green, code.g), monotone_curve(blue, code.b));
        rgb = srgb_from_code(code);
    }
    return vec4f(between3(source.rgb, rgb, params.amount), source.a);
}
