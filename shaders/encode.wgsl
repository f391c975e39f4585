#import math
#import transfer

struct Encode {
    row0: vec4f,           // Rec.709 to the display's primaries
    row1: vec4f,
    row2: vec4f,
    gamma: f32,
    white_nits: f32,
    peak_nits: f32,
    system_power: f32,     // HLG: (1 - gamma) / gamma of the display
}

// Whether the display has the primaries of the scene. The rows are then the identity.
const ENCODE_SAME_PRIMARIES: bool = false;

// Negative light becomes 0. Each transfer function limits bright light itself.
fn encode_primaries(source: vec4f, params: Encode) -> vec3f {
    if ENCODE_SAME_PRIMARIES { return max(source.rgb, vec3f(0.0)); }
    let rgb = vec3f(
        dot(params.row0.xyz, source.rgb),
        dot(params.row1.xyz, source.rgb),
        dot(params.row2.xyz, source.rgb),
    );
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
