// The functions that read textures. The linker sets both constants for each module.
#import sanitize
#import math

// 0 if every texture is known to be finite, 1 to sanitize signals and light of a display, 2 to sanitize signed data, 3
// to sanitize scene light.
const TEXEL_SANITIZE: u32 = 0u;
// Whether the device cannot filter a texture, or a texture must be sanitized before it is filtered: a filtered NaN is a
// NaN in four pixels. True whenever textures are sanitized.
const TAP_BY_HAND: bool = false;

// A channel of the bits of a texel.
fn sanitize_channel(bits: vec4u, channel: i32) -> u32 {
    return select(select(bits.x, bits.y, channel == 1), select(bits.z, bits.w, channel == 3), channel >= 2);
}

// The bits of a number of a neighbor: 0 to 8 are the rows of the square around a texel. NaN for the texel itself and
// outside of the texture, so that these are not used.
fn sanitize_neighbor(t: texture_2d<f32>, p: vec2i, index: i32, channel: i32) -> u32 {
    let at = p + vec2i(index % 3 - 1, index / 3 - 1);
    let inside = clamp(at, vec2i(0), vec2i(textureDimensions(t)) - 1);
    let is_other = all(at == inside) && any(at != p);
    let bits = bitcast<vec4u>(textureLoad(t, inside, 0));
    return select(0x7fc00000u, sanitize_channel(bits, channel), is_other);
}

// Limits a texel. The modes are those of TEXEL_SANITIZE.
fn sanitize_limited(v: vec4f, mode: u32) -> vec4f {
    if mode == 2u { return sanitize_signed(v); }
    if mode == 3u { return sanitize_light(v); }
    return sanitize(v);
}

// The number of this rank, from 1, among the finite neighbors in one channel, within the limits. Equal numbers have
// successive ranks.
fn sanitize_ranked(t: texture_2d<f32>, p: vec2i, channel: i32, rank: i32, end: i32) -> f32 {
    var found = -1e9;
    var left = rank;
    while left > 0 {
        var next = 1e9;
        var count = 0;
        for (var index = 0; index < end; index++) {
            let bits = sanitize_neighbor(t, p, index, channel);
            let limited = clamp(bitcast<f32>(bits), -HALF_MAX, HALF_MAX);
            let one = select(-1e9, limited, (bits & INFINITY_BITS) != INFINITY_BITS);
            if one > found {
                count = select(select(count, count + 1, one == next), 1, one < next);
                next = min(next, one);
            }
        }
        found = next;
        left -= max(count, 1);
    }
    return found;
}

// Repairs a number that is not finite. NaN, negative infinity, and an infinity that no neighbor shares become the
// median of the finite neighbors: the lower of two. The median is one of the numbers, so it is exact in any format. An
// infinity among others is light, such as a sun, and becomes the limit.
fn sanitize_number(t: texture_2d<f32>, p: vec2i, bits: u32, channel: i32, end: i32) -> u32 {
    var count = 0;
    var is_shared = false;
    for (var index = 0; index < end; index++) {
        let near = sanitize_neighbor(t, p, index, channel);
        count += select(0, 1, (near & INFINITY_BITS) != INFINITY_BITS);
        is_shared |= near == INFINITY_BITS;
    }
    if count == 0 || (is_shared && bits == INFINITY_BITS) { return bits; }
    return bitcast<u32>(sanitize_ranked(t, p, channel, (count + 1) / 2, end));
}

// Repairs a texel channel by channel. This code runs for few texels, but every read of a host image contains it: one
// number at a time takes few registers, and the loops end at numbers that are not constants, because drivers would
// unroll them otherwise.
fn sanitize_repair(t: texture_2d<f32>, p: vec2i, bits: vec4u, mode: u32) -> vec4f {
    let zero = min(p.x, 0);
    var clean = bits;
    for (var channel = 0; channel < 4 + zero; channel++) {
        let number = sanitize_channel(bits, channel);
        if (number & INFINITY_BITS) == INFINITY_BITS {
            let repaired = sanitize_number(t, p, number, channel, 9 + zero);
            clean = select(clean, vec4u(repaired), vec4i(0, 1, 2, 3) == vec4i(channel));
        }
    }
    return sanitize_limited(bitcast<vec4f>(clean), mode);
}

// Whether a value is within the limits of a mode, so that it stays the same: one comparison of its bits, which nearly
// all values pass. Negative light does not, even where it may stay.
fn sanitize_is_clean(bits: vec4u, mode: u32) -> bool {
    let magnitudes = select(bits, bits & vec4u(~SIGN_BIT), mode == 2u);
    let largest = max(magnitudes.xy, magnitudes.zw);
    return max(largest.x, largest.y) <= HALF_MAX_BITS;
}

// The value of a kernel that may make any numbers.
fn sanitize_value(v: vec4f, mode: u32) -> vec4f {
    if sanitize_is_clean(bitcast<vec4u>(v), mode) { return v; }
    return sanitize_limited(v, mode);
}

// A texel of a host image. Only one with a number that is not finite reads its neighbors.
fn sanitize_texel(t: texture_2d<f32>, p: vec2i, mode: u32) -> vec4f {
    let v = textureLoad(t, p, 0);
    let bits = bitcast<vec4u>(v);
    if sanitize_is_clean(bits, mode) { return v; }
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

// One sample of a texel of a host image, or of the nearest texel if `p` is outside. Other samples of the texel may show
// other surfaces, so a number that is not finite is limited, and none is put in its place.
fn texel_sample(t: texture_multisampled_2d<f32>, p: vec2i, index: i32) -> vec4f {
    let v = textureLoad(t, clamp(p, vec2i(0), vec2i(textureDimensions(t)) - 1), index);
    if TEXEL_SANITIZE == 0u { return v; }
    return sanitize_value(v, TEXEL_SANITIZE);
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

// One texel of a volume, or the nearest one if `p` is outside.
fn texel3(t: texture_3d<f32>, p: vec3i) -> vec4f {
    let inside = clamp(p, vec3i(0), vec3i(textureDimensions(t)) - 1);
    if TEXEL_SANITIZE == 0u { return textureLoad(t, inside, 0); }
    return sanitize_texel3(t, inside, TEXEL_SANITIZE);
}

// A texel of a volume of the host. What is not finite is repaired by its neighbors in its slice: a march from the
// camera carries a NaN into all slices behind it.
fn sanitize_texel3(t: texture_3d<f32>, p: vec3i, mode: u32) -> vec4f {
    let v = textureLoad(t, p, 0);
    let bits = bitcast<vec4u>(v);
    if sanitize_is_clean(bits, mode) { return v; }
    if all(is_finite(bits)) { return sanitize_limited(v, mode); }
    var near: array<vec4u, 9>;
    for (var index = 0; index < 9; index++) {
        let at = p + vec3i(index % 3 - 1, index / 3 - 1, 0);
        let inside = clamp(at, vec3i(0), vec3i(textureDimensions(t)) - 1);
        let is_other = all(at == inside) && index != 4;
        near[index] = select(vec4u(0x7fc00000u), bitcast<vec4u>(textureLoad(t, inside, 0)), is_other);
    }
    var clean = bits;
    for (var channel = 0; channel < 4; channel++) {
        let number = sanitize_channel(bits, channel);
        if (number & INFINITY_BITS) == INFINITY_BITS {
            let repaired = sanitize_median(&near, number, channel);
            clean = select(clean, vec4u(repaired), vec4i(0, 1, 2, 3) == vec4i(channel));
        }
    }
    return sanitize_limited(bitcast<vec4f>(clean), mode);
}

// What `sanitize_number` puts in the place of a number, from the texels around it.
fn sanitize_median(near: ptr<function, array<vec4u, 9>>, bits: u32, channel: i32) -> u32 {
    var numbers: array<f32, 9>;
    var count = 0;
    var is_shared = false;
    for (var index = 0; index < 9; index++) {
        let one = sanitize_channel((*near)[index], channel);
        is_shared |= one == INFINITY_BITS;
        if (one & INFINITY_BITS) != INFINITY_BITS {
            numbers[count] = clamp(bitcast<f32>(one), -HALF_MAX, HALF_MAX);
            count++;
        }
    }
    if count == 0 || (is_shared && bits == INFINITY_BITS) { return bits; }
    // The number that has this rank, from 1: fewer are less than it, and it and its equals reach the rank.
    let rank = (count + 1) / 2;
    var median = numbers[0];
    for (var i = 0; i < count; i++) {
        var less = 0;
        var equal = 0;
        for (var j = 0; j < count; j++) {
            less += select(0, 1, numbers[j] < numbers[i]);
            equal += select(0, 1, numbers[j] == numbers[i]);
        }
        median = select(median, numbers[i], less < rank && rank <= less + equal);
    }
    return bitcast<u32>(median);
}

// Trilinear filter, clamped to the border.
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
