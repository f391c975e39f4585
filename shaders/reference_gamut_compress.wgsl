import afterimage::color::brightest;
import afterimage::math::power3;

struct ReferenceGamutCompress {
    enter0: vec4f,  // rows: Rec.709 to AP1
    enter1: vec4f,
    enter2: vec4f,
    leave0: vec4f,  // and back
    leave1: vec4f,
    leave2: vec4f,
    threshold: vec3f,
    distance_scale: vec3f,
}

const POWER: f32 = 1.2;

fn rows(row0: vec4f, row1: vec4f, row2: vec4f, v: vec3f) -> vec3f {
    return vec3f(dot(row0.xyz, v), dot(row1.xyz, v), dot(row2.xyz, v));
}

// The distance of each channel from the largest one is 0 for gray and 1 at the border of AP1.
fn reference_gamut_compress(source: vec4f, params: ReferenceGamutCompress) -> vec4f {
    let v = rows(params.enter0, params.enter1, params.enter2, source.rgb);
    let most = brightest(v);
    let distance = (most - v) / max(abs(most), 1e-30);
    let over = clamp((distance - params.threshold) / params.distance_scale, vec3f(0.0), vec3f(1e6));
    let bent = params.threshold + params.distance_scale * over / power3(1.0 + power3(over, POWER), 1.0 / POWER);
    let compressed = select(v, most - bent * abs(most), distance >= params.threshold);
    let result = rows(params.leave0, params.leave1, params.leave2, compressed);
    // Light in Rec.709 stays there; rounding may leave it.
    let is_inside = min(source.r, min(source.g, source.b)) >= 0.0;
    return vec4f(select(result, max(result, vec3f(0.0)), is_inside), source.a);
}
