// The functions that read textures. The linker sets both constants for each module.
#import sanitize
#import math

// 0 if every texture is known to be finite, 1 to sanitize signals and light of a display, 2 to sanitize signed data, 3
// to sanitize scene light.
const TEXEL_SANITIZE: u32 = 0u;
// Whether the device cannot filter a texture, or a texture must be sanitized before it is filtered: a filtered NaN is a
// NaN in four pixels. True whenever textures are sanitized.
const TAP_BY_HAND: bool = false;

// The bits of a neighbour of a texel: 0 to 8 are the rows of the square around it. NaN for the texel itself and outside
// of the texture, so that these are not used.
fn sanitize_neighbour(t: texture_2d<f32>, p: vec2i, index: i32) -> vec4u {
    let at = p + vec2i(index % 3 - 1, index / 3 - 1);
    let inside = clamp(at, vec2i(0), vec2i(textureDimensions(t)) - 1);
    let is_other = all(at == inside) && any(at != p);
    return select(vec4u(0x7fc00000u), bitcast<vec4u>(textureLoad(t, inside, 0)), is_other);
}

// Limits a texel. The modes are those of TEXEL_SANITIZE.
fn sanitize_limited(v: vec4f, mode: u32) -> vec4f {
    if mode == 2u { return sanitize_signed(v); }
    if mode == 3u { return sanitize_light(v); }
    return sanitize(v);
}

// Limits each number of a neighbour by itself.
fn sanitize_plain(v: vec4f, mode: u32) -> vec4f {
    if mode == 1u { return sanitize(v); }
    return sanitize_signed(v);
}

// Repairs a texel with a number that is not finite. NaN, negative infinity, and an infinity that no neighbour shares
// become the median of the finite neighbours: the lower of two. The median is one of the numbers, so it is exact in any
// format. An infinity among others is light, such as a sun, and becomes the limit. Loops and loads instead of an array
// keep the registers of the common case free. The loops end at 9; a constant would let drivers unroll them wherever a
// host image is read.
fn sanitize_repair(t: texture_2d<f32>, p: vec2i, bits: vec4u, mode: u32) -> vec4f {
    let end = 9 + min(p.x, 0);
    var count = vec4u();
    var is_shared = vec4<bool>();
    for (var index = 0; index < end; index++) {
        let near = sanitize_neighbour(t, p, index);
        count += select(vec4u(), vec4u(1u), is_finite(near));
        is_shared |= near == vec4u(INFINITY_BITS);
    }
    var median = vec4f();
    for (var index = 0; index < end; index++) {
        let bits_of_one = sanitize_neighbour(t, p, index);
        let one = sanitize_plain(bitcast<vec4f>(bits_of_one), mode);
        var rank = vec4u();
        for (var other = 0; other < end; other++) {
            let bits_of_two = sanitize_neighbour(t, p, other);
            let two = sanitize_plain(bitcast<vec4f>(bits_of_two), mode);
            let is_before = (two < one) | ((two == one) & vec4<bool>(other < index));
            rank += select(vec4u(), vec4u(1u), is_before & is_finite(bits_of_two));
        }
        median = select(median, one, is_finite(bits_of_one) & (rank == (max(count, vec4u(1u)) - 1u) / 2u));
    }
    let keeps = is_finite(bits) | ((bits == vec4u(INFINITY_BITS)) & is_shared) | (count == vec4u());
    return sanitize_limited(bitcast<vec4f>(select(bitcast<vec4u>(median), bits, keeps)), mode);
}

// A texel of a host image. Only a texel with a number that is not finite reads its neighbours.
fn sanitize_texel(t: texture_2d<f32>, p: vec2i, mode: u32) -> vec4f {
    let v = textureLoad(t, p, 0);
    let bits = bitcast<vec4u>(v);
    if all(is_finite(bits)) { return sanitize_limited(v, mode); }
    return sanitize_repair(t, p, bits, mode);
}

// One texel of a texture at a position inside.
fn texel_inside(t: texture_2d<f32>, p: vec2i) -> vec4f {
    if TEXEL_SANITIZE == 0u { return textureLoad(t, p, 0); }
    return sanitize_texel(t, p, TEXEL_SANITIZE);
}

// A texel of a host image times a factor that brings numbers above the limit below it.
fn texel_scaled(t: texture_2d<f32>, p: vec2i, factor: f32) -> vec4f {
    let v = textureLoad(t, p, 0);
    let clean = texel_inside(t, p);
    let bits = bitcast<vec4u>(v);
    let is_light = is_finite(bits) & ((bits & vec4u(SIGN_BIT)) == vec4u());
    let light = select(clean, v, is_light).rgb * factor;
    return vec4f(clamp(light, vec3f(-HALF_MAX), vec3f(HALF_MAX)), clean.a);
}

// One texel of a texture, or the nearest one if `p` is outside.
fn texel(t: texture_2d<f32>, p: vec2i) -> vec4f {
    return texel_inside(t, clamp(p, vec2i(0), vec2i(textureDimensions(t)) - 1));
}

// Bilinear filter, clamped to the border.
fn tap(t: texture_2d<f32>, s: sampler, uv: vec2f) -> vec4f {
    if TAP_BY_HAND { return tap_by_hand(t, uv); }
    return textureSampleLevel(t, s, uv, 0.0);
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
