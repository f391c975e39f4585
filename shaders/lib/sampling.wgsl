// The functions that read textures. The linker sets both constants for each module.
#import sanitize
#import math

// 0 if every texture is known to be finite, 1 to sanitize signals and light of a display, 2 to sanitize signed data, 3
// to sanitize scene light.
const TEXEL_SANITIZE: u32 = 0u;
// Whether the device cannot filter a texture, or a texture must be sanitized before it is filtered: a filtered NaN is a
// NaN in four pixels.
const TAP_BY_HAND: bool = false;

fn sanitized(v: vec4f) -> vec4f {
    if TEXEL_SANITIZE == 1u { return sanitize(v); }
    if TEXEL_SANITIZE == 2u { return sanitize_signed(v); }
    if TEXEL_SANITIZE == 3u { return sanitize_light(v); }
    return v;
}

// One texel of a texture, or the nearest one if `p` is outside.
fn texel(t: texture_2d<f32>, p: vec2i) -> vec4f {
    let last = vec2i(textureDimensions(t)) - 1;
    return sanitized(textureLoad(t, clamp(p, vec2i(0), last), 0));
}

// Bilinear filter, clamped to the border.
fn tap(t: texture_2d<f32>, s: sampler, uv: vec2f) -> vec4f {
    if TAP_BY_HAND { return tap_by_hand(t, uv); }
    return sanitized(textureSampleLevel(t, s, uv, 0.0));
}

fn tap_by_hand(t: texture_2d<f32>, uv: vec2f) -> vec4f {
    let size = vec2f(textureDimensions(t));
    // Far outside, every coordinate is the border. The clamp keeps the conversion to integers defined.
    let p = clamp(uv * size - 0.5, vec2f(-1.0), size);
    let base = floor(p);
    let f = p - base;
    let i = vec2i(base);
    let top = between(texel(t, i), texel(t, i + vec2i(1, 0)), f.x);
    let bottom = between(texel(t, i + vec2i(0, 1)), texel(t, i + vec2i(1, 1)), f.x);
    return between(top, bottom, f.y);
}

fn texel3(t: texture_3d<f32>, p: vec3i) -> vec4f {
    let last = vec3i(textureDimensions(t)) - 1;
    return textureLoad(t, clamp(p, vec3i(0), last), 0);
}

// Trilinear filter, clamped to the border. Volumes are computed inside of the graph or decoded from files, so they are
// finite.
fn tap3(t: texture_3d<f32>, s: sampler, uvw: vec3f) -> vec4f {
    if TAP_BY_HAND { return tap3_by_hand(t, uvw); }
    return textureSampleLevel(t, s, uvw, 0.0);
}

fn tap3_plane(t: texture_3d<f32>, i: vec3i, f: vec2f) -> vec4f {
    let top = between(texel3(t, i), texel3(t, i + vec3i(1, 0, 0)), f.x);
    let bottom = between(texel3(t, i + vec3i(0, 1, 0)), texel3(t, i + vec3i(1, 1, 0)), f.x);
    return between(top, bottom, f.y);
}

fn tap3_by_hand(t: texture_3d<f32>, uvw: vec3f) -> vec4f {
    let size = vec3f(textureDimensions(t));
    let p = clamp(uvw * size - 0.5, vec3f(-1.0), size);
    let base = floor(p);
    let f = p - base;
    let i = vec3i(base);
    return between(tap3_plane(t, i, f.xy), tap3_plane(t, i + vec3i(0, 0, 1), f.xy), f.z);
}
