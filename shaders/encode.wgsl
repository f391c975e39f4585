import afterimage::gamut::gamut_compress;
import afterimage::math::{power, power3};
import afterimage::transfer::{hlg_encode, pq_encode, srgb_encode3};

struct Encode {
    row0: vec4f,           // the primaries of the source to those of the result
    row1: vec4f,
    row2: vec4f,
    luminance_weights: vec3f,
    limit: f32,            // the brightest light of the result
    compresses: f32,       // 1: colors are compressed into the gamut, 0: they are clipped
    gamma: f32,
    white_nits: f32,
    peak_nits: f32,
    system_power: f32,     // HLG: (1 - gamma) / gamma of the display
}

// True if the source has the primaries of the result. The rows are then the identity.
const ENCODE_SAME_PRIMARIES: bool = false;

// Up to this share of the distance from gray to the border of the gamut, compressed colors stay the same.
const ENCODE_GAMUT_KNEE: f32 = 0.8;

// Negative light becomes 0. Each transfer function limits bright light itself.
fn encode_primaries(source: vec4f, params: Encode) -> vec3f {
    if ENCODE_SAME_PRIMARIES { return max(source.rgb, vec3f(0.0)); }
    let rgb = vec3f(
        dot(params.row0.xyz, source.rgb),
        dot(params.row1.xyz, source.rgb),
        dot(params.row2.xyz, source.rgb),
    );
    if params.compresses > 0.0 {
        return gamut_compress(rgb, params.luminance_weights, params.limit, ENCODE_GAMUT_KNEE);
    }
    return max(rgb, vec3f(0.0));
}

fn encode_linear(source: vec4f, params: Encode) -> vec4f {
    return vec4f(min(encode_primaries(source, params), vec3f(1.0)), source.a);
}

fn encode_srgb(source: vec4f, params: Encode) -> vec4f {
    let rgb = min(encode_primaries(source, params), vec3f(1.0));
    return vec4f(srgb_encode3(rgb), source.a);
}

fn encode_gamma(source: vec4f, params: Encode) -> vec4f {
    let rgb = min(encode_primaries(source, params), vec3f(1.0));
    return vec4f(power3(rgb, 1.0 / params.gamma), source.a);
}

fn encode_pq(source: vec4f, params: Encode) -> vec4f {
    let nits = min(encode_primaries(source, params) * params.white_nits, vec3f(params.peak_nits));
    return vec4f(pq_encode(nits.r), pq_encode(nits.g), pq_encode(nits.b), source.a);
}

// Display light to HLG scene light: inverts the system gamma, which depends on the display's luminance.
fn encode_hlg(source: vec4f, params: Encode) -> vec4f {
    let light = min(encode_primaries(source, params) * (params.white_nits / params.peak_nits), vec3f(1.0));
    let y = dot(light, vec3f(0.262700212011, 0.677998071519, 0.059301716470));
    let scene = min(light * power(max(y, 1e-30), params.system_power), vec3f(1.0));
    return vec4f(hlg_encode(scene.r), hlg_encode(scene.g), hlg_encode(scene.b), source.a);
}
