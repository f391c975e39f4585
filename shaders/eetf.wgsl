import afterimage::color::brightest;
import afterimage::math::power3;
import afterimage::oklab::oklab_lightness;
import afterimage::transfer::{pq_decode, pq_encode};

struct Eetf {
    white_nits: f32,
    source_nits: f32,
    range: f32,        // PQ of the source's peak
    top: f32,          // the display's peak, as a share of it
    bottom: f32,       // the display's black, as a share of it
    knee: f32,
    to_lms0: vec4f,    // rows: the primaries of the light to the cone responses of Oklab
    to_lms1: vec4f,
    to_lms2: vec4f,
    from_lms0: vec4f,  // and back
    from_lms1: vec4f,
    from_lms2: vec4f,
}

// The curve on a share of the range. A lifted black would raise the brightest light above the top.
fn eetf_curve(e: f32, params: Eetf) -> f32 {
    let rest = max(1.0 - params.knee, 1e-6);
    let t = clamp((e - params.knee) / rest, 0.0, 1.0);
    let t2 = t * t;
    let t3 = t2 * t;
    let start = (2.0 * t3 - 3.0 * t2 + 1.0) * params.knee + (t3 - 2.0 * t2 + t) * rest;
    let bent = select(start + (3.0 * t2 - 2.0 * t3) * params.top, e, e < params.knee);
    let dark = 1.0 - bent;
    return min(bent + params.bottom * dark * dark * dark * dark, params.top);
}

// Display-linear light, 0 or more, through the curve.
fn eetf_light(x: f32, params: Eetf) -> f32 {
    let e = pq_encode(min(x * params.white_nits, params.source_nits)) / params.range;
    return pq_decode(params.range * eetf_curve(e, params)) / params.white_nits;
}

// The chroma of Oklab in units of the lightness keeps the share of the saturation that the curve leaves between the
// smallest and the largest channel. Oklab's hue does not depend on brightness, so that the color can then be scaled.
fn eetf_extremes(source: vec4f, params: Eetf) -> vec4f {
    let v = max(source.rgb, vec3f(0.0));
    let most = brightest(v);
    let least = min(v.r, min(v.g, v.b));
    let shown = eetf_light(most, params);
    let kept = (shown - eetf_light(least, params)) * most / max((most - least) * shown, 1e-30);
    let lms = vec3f(dot(params.to_lms0.xyz, v), dot(params.to_lms1.xyz, v), dot(params.to_lms2.xyz, v));
    let roots = power3(max(lms, vec3f(0.0)), 1.0 / 3.0);
    let paler = mix(vec3f(oklab_lightness(roots)), roots, clamp(kept, 0.0, 1.0));
    let cones = paler * paler * paler;
    let rgb = vec3f(
        dot(params.from_lms0.xyz, cones),
        dot(params.from_lms1.xyz, cones),
        dot(params.from_lms2.xyz, cones),
    );
    let scaled = max(rgb, vec3f(0.0)) * (shown / max(brightest(rgb), 1e-30));
    return vec4f(select(vec3f(shown), scaled, most > 1e-12), source.a);
}

// Where the lifted black dominates, light becomes gray.
fn eetf_largest(source: vec4f, params: Eetf) -> vec4f {
    let most = brightest(source.rgb);
    let shown = eetf_light(max(most, 0.0), params);
    let scaled = source.rgb * (min(shown, most) / max(most, 1e-30));
    return vec4f(select(vec3f(0.0), scaled, most > 0.0) + max(shown - max(most, 0.0), 0.0), source.a);
}
