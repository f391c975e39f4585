import afterimage::grade::bounded_scene;
import package::lib::monotone::{monotone_curve, monotone_points};
import package::lib::oklab_rgb::{oklab_from_rgb, oklab_to_rgb};

struct SaturationCurves {
    vibrance: f32,
    black: f32,
    shadows: f32,
    middle: f32,
    highlights: f32,
    white: f32,
}

// The share of its lightness that the chroma of a color has from which on it is not muted.
const SATURATION_CURVES_STRONG: f32 = 0.5;

fn saturation_curves(source: vec4f, params: SaturationCurves) -> vec4f {
    let ends = vec3f(params.black, params.middle, params.white);
    let is_neutral = all(ends == vec3f(1.0)) && params.shadows == 1.0 && params.highlights == 1.0;
    if is_neutral && params.vibrance == 0.0 { return source; }
    let lab = oklab_from_rgb(source.rgb);
    let points = monotone_points(
        vec2f(0.0, params.black),
        vec2f(0.25, params.shadows),
        vec2f(0.5, params.middle),
        vec2f(0.75, params.highlights),
        vec2f(1.0, params.white),
    );
    let factor = monotone_curve(points, clamp(lab.x, 0.0, 1.0));
    let strength = length(lab.yz) / max(lab.x, 1e-6);
    let muted = max(1.0 - strength / SATURATION_CURVES_STRONG, 0.0);
    let chroma = factor * (1.0 + params.vibrance * muted * muted);
    return vec4f(bounded_scene(oklab_to_rgb(vec3f(lab.x, chroma * lab.yz))), source.a);
}
