// Colors outside of a gamut are moved into it.
import package::color::brightest;

// Moves a color toward the gray of its luminance, until no channel is below 0. `reach` is 1 where the least channel is
// 0. Up to the knee nothing changes. Beyond it, x/(1+x) compresses the rest, so that a color approaches the border and
// never passes it. Then light above `peak` becomes darker and keeps its chromaticity: toward gray, bright yellow would
// lose its color within a few codes, because there is little room above its luminance. `weights` are the luminance
// weights of the gamut's primaries.
fn gamut_compress(rgb: vec3f, weights: vec3f, peak: f32, knee: f32) -> vec3f {
    let gray = max(dot(rgb, weights), 0.0);
    let reach = (gray - min(rgb.r, min(rgb.g, rgb.b))) / max(gray, 1e-7);
    let rest = 1.0 - knee;
    let over = max(reach - knee, 0.0);
    let pulled = knee + over * rest / max(rest + over, 1e-7);
    let share = select(pulled / max(reach, 1e-7), 1.0, reach <= knee);
    let inside = max(gray + (rgb - gray) * share, vec3f(0.0));
    return inside * (peak / max(brightest(inside), peak));
}
