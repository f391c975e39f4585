import afterimage::grade::bounded_scene;
import afterimage::math::smooth_step;
import package::lib::monotone::{monotone_cubic, monotone_slope};
import package::lib::oklab_rgb::{oklab_from_rgb, oklab_to_rgb};

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

// The values at the first four points, and at the last four. No array: llvmpipe makes a branch of each element for each
// index, and took four seconds to compile this instead of a third of one.
struct HueCurve { low: vec4f, high: vec4f }

// The hues of the points in degrees.
const HUE_CURVES_LOW: vec4f = vec4f(29.0, 65.0, 110.0, 142.0);
const HUE_CURVES_HIGH: vec4f = vec4f(195.0, 264.0, 303.0, 328.0);

// A point of a closed curve, by an index from -8 to 15.
fn hue_curves_point(curve: HueCurve, index: i32) -> vec2f {
    let turn = select(select(0.0, 1.0, index >= 8), -1.0, index < 0);
    let is_high = (index & 4) != 0;
    let hues = select(HUE_CURVES_LOW, HUE_CURVES_HIGH, is_high);
    let values = select(curve.low, curve.high, is_high);
    let is_odd = (index & 1) != 0;
    let hue = select(select(hues.x, hues.y, is_odd), select(hues.z, hues.w, is_odd), (index & 2) != 0);
    let value = select(select(values.x, values.y, is_odd), select(values.z, values.w, is_odd), (index & 2) != 0);
    return vec2f(hue + 360.0 * turn, value);
}

// The closed curve at a hue of 29 to 389 degrees that is not before the point `index`, but before the next.
fn hue_curves_value(curve: HueCurve, index: i32, hue: f32) -> f32 {
    let a = hue_curves_point(curve, index - 1);
    let b = hue_curves_point(curve, index);
    let c = hue_curves_point(curve, index + 1);
    let d = hue_curves_point(curve, index + 2);
    return monotone_cubic(b, c, monotone_slope(a, b, c), monotone_slope(b, c, d), hue);
}

fn hue_curves_is_all(curve: HueCurve, value: f32) -> bool {
    return all(curve.low == vec4f(value)) && all(curve.high == vec4f(value));
}

// The share of its chroma in the lightness from which on a color is brightened in full.
const HUE_CURVES_FULL: f32 = 0.05;

fn hue_curves(source: vec4f, params: HueCurves) -> vec4f {
    let turns = HueCurve(
        vec4f(params.hue_red, params.hue_orange, params.hue_yellow, params.hue_green),
        vec4f(params.hue_cyan, params.hue_blue, params.hue_purple, params.hue_magenta),
    );
    let chromas = HueCurve(
        vec4f(params.saturation_red, params.saturation_orange, params.saturation_yellow, params.saturation_green),
        vec4f(params.saturation_cyan, params.saturation_blue, params.saturation_purple, params.saturation_magenta),
    );
    let stops = HueCurve(
        vec4f(params.lightness_red, params.lightness_orange, params.lightness_yellow, params.lightness_green),
        vec4f(params.lightness_cyan, params.lightness_blue, params.lightness_purple, params.lightness_magenta),
    );
    if hue_curves_is_all(turns, 0.0) && hue_curves_is_all(chromas, 1.0) && hue_curves_is_all(stops, 0.0) {
        return source;
    }
    let lab = oklab_from_rgb(source.rgb);
    let chroma = length(lab.yz);
    if chroma <= 1e-6 { return source; }
    let angle = degrees(atan2(lab.z, lab.y));
    let hue = angle + select(0.0, 360.0, angle < HUE_CURVES_LOW.x);
    let passed = vec4i(vec4f(hue) >= HUE_CURVES_LOW) + vec4i(vec4f(hue) >= HUE_CURVES_HIGH);
    let index = max(passed.x + passed.y + passed.z + passed.w - 1, 0);
    let turn = radians(hue_curves_value(turns, index, hue));
    let turned = vec2f(lab.y * cos(turn) - lab.z * sin(turn), lab.y * sin(turn) + lab.z * cos(turn));
    let chroma_scale = max(hue_curves_value(chromas, index, hue), 0.0);
    let share = smooth_step(0.0, HUE_CURVES_FULL * max(lab.x, 1e-6), chroma);
    let light_scale = exp2(share * hue_curves_value(stops, index, hue));
    return vec4f(bounded_scene(light_scale * oklab_to_rgb(vec3f(lab.x, chroma_scale * turned))), source.a);
}
