#import grade
#import math
#import monotone
#import oklab_rgb

struct HueCurves {
    hue_red: f32,
    hue_orange: f32,
    hue_yellow: f32,
    hue_green: f32,
    hue_cyan: f32,
    hue_blue: f32,
    hue_purple: f32,
    hue_magenta: f32,
    saturation_red: f32,
    saturation_orange: f32,
    saturation_yellow: f32,
    saturation_green: f32,
    saturation_cyan: f32,
    saturation_blue: f32,
    saturation_purple: f32,
    saturation_magenta: f32,
    lightness_red: f32,
    lightness_orange: f32,
    lightness_yellow: f32,
    lightness_green: f32,
    lightness_cyan: f32,
    lightness_blue: f32,
    lightness_purple: f32,
    lightness_magenta: f32,
}

// The hues of the points in degrees.
const HUE_CURVES_AT: array<f32, 8> = array(29.0, 65.0, 110.0, 142.0, 195.0, 264.0, 303.0, 328.0);

// A point of a closed curve, by an index from -8 to 15.
fn hue_curves_point(values: array<f32, 8>, index: i32) -> vec2f {
    var all = values;
    let turn = (index + 8) / 8 - 1;
    let at = index - 8 * turn;
    return vec2f(HUE_CURVES_AT[at] + 360.0 * f32(turn), all[at]);
}

// The closed curve at a hue of 29 to 389 degrees that is not before the point `index`, but before the next.
fn hue_curves_value(values: array<f32, 8>, index: i32, hue: f32) -> f32 {
    let a = hue_curves_point(values, index - 1);
    let b = hue_curves_point(values, index);
    let c = hue_curves_point(values, index + 1);
    let d = hue_curves_point(values, index + 2);
    return monotone_cubic(b, c, monotone_slope(a, b, c), monotone_slope(b, c, d), hue);
}

fn hue_curves_is_all(values: array<f32, 8>, value: f32) -> bool {
    var all = values;
    var found = true;
    for (var index = 0; index < 8; index++) {
        found = found && all[index] == value;
    }
    return found;
}

// The share of its chroma in the lightness from which on a color is brightened in full.
const HUE_CURVES_FULL: f32 = 0.05;

fn hue_curves(source: vec4f, params: HueCurves) -> vec4f {
    let turns = array(
        params.hue_red,
        params.hue_orange,
        params.hue_yellow,
        params.hue_green,
        params.hue_cyan,
        params.hue_blue,
        params.hue_purple,
        params.hue_magenta,
    );
    let chromas = array(
        params.saturation_red,
        params.saturation_orange,
        params.saturation_yellow,
        params.saturation_green,
        params.saturation_cyan,
        params.saturation_blue,
        params.saturation_purple,
        params.saturation_magenta,
    );
    let stops = array(
        params.lightness_red,
        params.lightness_orange,
        params.lightness_yellow,
        params.lightness_green,
        params.lightness_cyan,
        params.lightness_blue,
        params.lightness_purple,
        params.lightness_magenta,
    );
    if hue_curves_is_all(turns, 0.0) && hue_curves_is_all(chromas, 1.0) && hue_curves_is_all(stops, 0.0) {
        return source;
    }
    let lab = oklab_from_rgb(source.rgb);
    let chroma = length(lab.yz);
    if chroma <= 1e-6 { return source; }
    let angle = degrees(atan2(lab.z, lab.y));
    let hue = angle + select(0.0, 360.0, angle < HUE_CURVES_AT[0]);
    var index = 0;
    for (var next = 1; next < 8; next++) {
        index = select(index, next, hue >= HUE_CURVES_AT[next]);
    }
    let turn = radians(hue_curves_value(turns, index, hue));
    let turned = vec2f(lab.y * cos(turn) - lab.z * sin(turn), lab.y * sin(turn) + lab.z * cos(turn));
    let chroma_scale = max(hue_curves_value(chromas, index, hue), 0.0);
    let share = smooth_step(0.0, HUE_CURVES_FULL * max(lab.x, 1e-6), chroma);
    let light_scale = exp2(share * hue_curves_value(stops, index, hue));
    return vec4f(bounded_scene(light_scale * oklab_to_rgb(vec3f(lab.x, chroma_scale * turned))), source.a);
}
