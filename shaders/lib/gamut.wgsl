// Colors outside of a gamut are moved into it.
#import color

// Moves a color toward the gray of its luminance. `reach` is 1 at the border of the gamut, whose channels go from 0
// to `peak`. Up to the knee nothing changes. Beyond it, x/(1+x) compresses the rest, so that a color approaches the
// border and never passes it. `weights` are the luminance weights of the gamut's primaries.
fn gamut_compress(rgb: vec3f, weights: vec3f, peak: f32, knee: f32) -> vec3f {
    let gray = clamp(dot(rgb, weights), 0.0, peak);
    let away = rgb - gray;
    let room = select(vec3f(gray), vec3f(peak - gray), away > vec3f(0.0));
    let reach = brightest(abs(away) / max(room, vec3f(1e-7)));
    let rest = 1.0 - knee;
    let over = max(reach - knee, 0.0);
    let pulled = knee + over * rest / max(rest + over, 1e-7);
    let share = select(pulled / max(reach, 1e-7), 1.0, reach <= knee);
    return clamp(gray + away * share, vec3f(0.0), vec3f(peak));
}
