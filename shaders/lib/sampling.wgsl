// The functions that read textures. The linker sets both constants for each module.
import package::color::{level_luminance, luminance};
import package::sanitize::{
    HALF_MAX, HALF_MAX_BITS, INFINITY_BITS, SIGN_BIT, is_finite, sanitize, sanitize_light, sanitize_signed,
};
import package::math::between;

// 0 if every texture is known to be finite, 1 to sanitize signals and light of a display, 2 to sanitize signed data, 3
// to sanitize scene light.
const TEXEL_SANITIZE: u32 = 0u;
// True if the device cannot filter a texture, or a texture must be sanitized before it is filtered: a filtered NaN is a
// NaN in four pixels. True whenever textures are sanitized.
const TAP_BY_HAND: bool = false;

// Limits a texel. The modes are those of TEXEL_SANITIZE.
fn sanitize_limited(v: vec4f, mode: u32) -> vec4f {
    if mode == 2u { return sanitize_signed(v); }
    if mode == 3u { return sanitize_light(v); }
    return sanitize(v);
}

// Less and more than all numbers of texels.
const SANITIZE_NONE: vec4f = vec4f(-1e9);
const SANITIZE_ALL: vec4f = vec4f(1e9);

// The bits of a neighbor. NaN outside of the texture, so that these are not used.
fn sanitize_neighbor(t: texture_2d<f32>, p: vec2i) -> vec4u {
    let inside = clamp(p, vec2i(0), vec2i(textureDimensions(t)) - 1);
    let bits = bitcast<vec4u>(textureLoad(t, inside, 0));
    return select(vec4u(INFINITY_BITS | 1u), bits, all(p == inside));
}

// The numbers of bits within the limits, in place of those that are not finite the least.
fn sanitize_finite(bits: vec4u) -> vec4f {
    let limited = clamp(bitcast<vec4f>(bits), vec4f(-HALF_MAX), vec4f(HALF_MAX));
    return select(SANITIZE_NONE, limited, is_finite(bits));
}

// The larger finite number of a pair of opposite neighbors; SANITIZE_ALL without one.
fn sanitize_larger(one: vec4u, other: vec4u) -> vec4f {
    let larger = max(sanitize_finite(one), sanitize_finite(other));
    return select(larger, SANITIZE_ALL, larger == SANITIZE_NONE);
}

// The replacement of a texel, from the infinities of its neighbors and from the least of the pairs.
fn sanitize_repaired(bits: vec4u, is_light: vec4<bool>, least: vec4f, mode: u32) -> vec4f {
    let clean = select(bits, vec4u(HALF_MAX_BITS), is_light & (bits == vec4u(INFINITY_BITS)));
    let stays = is_finite(clean) | (least == SANITIZE_ALL);
    return sanitize_limited(select(least, bitcast<vec4f>(clean), stays), mode);
}

// Repairs a texel channel by channel. An infinity next to another is light, such as a sun, and becomes the limit. Other
// numbers that are not finite become the least of four: of each pair of opposite neighbors the larger finite number. So
// the sides of an edge and thin lines stay what they are, and a bright pixel is not repeated. The number is one of the
// neighbors', so it is exact in any format.
//
// This code runs for few texels, but every read of a host image contains it, and its registers are taken from the rest:
// its loop ends at a number that is not constant, because drivers would unroll it otherwise.
fn sanitize_repair(t: texture_2d<f32>, p: vec2i, bits: vec4u, mode: u32) -> vec4f {
    let zero = min(p.x, 0);
    var is_light = vec4<bool>();
    var least = SANITIZE_ALL;
    for (var index = 0; index < 4 + zero; index++) {
        let step = select(vec2i(index - 2, 1), vec2i(1, 0), index == 0);
        let one = sanitize_neighbor(t, p + step);
        let other = sanitize_neighbor(t, p - step);
        is_light |= (one == vec4u(INFINITY_BITS)) | (other == vec4u(INFINITY_BITS));
        least = min(least, sanitize_larger(one, other));
    }
    return sanitize_repaired(bits, is_light, least, mode);
}

// The largest bits of the numbers of a value. Up to those of the limit, all numbers are within the limits of the mode,
// so that the value stays the same. Negative light is above, even where it may stay.
fn sanitize_largest(bits: vec4u, mode: u32) -> u32 {
    let magnitudes = select(bits, bits & vec4u(~SIGN_BIT), mode == 2u);
    let largest = max(magnitudes.xy, magnitudes.zw);
    return max(largest.x, largest.y);
}

// The result of an untrusted kernel. A quotient by zero is undefined in SPIR-V, and a compiler that knows the zero
// takes another number for it at each use, so that no comparison limits it. What a mask of bits clears it cannot
// choose: scaled, all numbers within the limits have the exponent's highest bit clear, and without it none is 65536 or
// more.
fn sanitize_result(v: vec4f, mode: u32) -> vec4f {
    let scaled = bitcast<vec4u>(sanitize_value(v, mode) * 0.000030517578125);
    return bitcast<vec4f>(scaled & vec4u(0xbfffffffu)) * 32768.0;
}

// A value within the limits.
fn sanitize_value(v: vec4f, mode: u32) -> vec4f {
    if sanitize_largest(bitcast<vec4u>(v), mode) <= HALF_MAX_BITS { return v; }
    return sanitize_limited(v, mode);
}

// A texel of a host image that is loaded. Only one with a number that is not finite reads its neighbors.
fn sanitize_loaded(t: texture_2d<f32>, p: vec2i, v: vec4f, mode: u32) -> vec4f {
    let bits = bitcast<vec4u>(v);
    if sanitize_largest(bits, mode) <= HALF_MAX_BITS { return v; }
    if all(is_finite(bits)) { return sanitize_limited(v, mode); }
    return sanitize_repair(t, p, bits, mode);
}

// A texel of a host image.
fn sanitize_texel(t: texture_2d<f32>, p: vec2i, mode: u32) -> vec4f {
    return sanitize_loaded(t, p, textureLoad(t, p, 0), mode);
}

// One texel of a texture at a position inside. One that is sanitized is the result of an operation that changes no
// number: llvmpipe takes minutes to compile a thousand uses of a value that branches have made.
fn texel_inside(t: texture_2d<f32>, p: vec2i) -> vec4f {
    if TEXEL_SANITIZE == 0u { return textureLoad(t, p, 0); }
    return min(sanitize_texel(t, p, TEXEL_SANITIZE), vec4f(3.4028234e38));
}

// Four texels at positions inside, loaded together so that their latencies overlap, and not sanitized: where
// `are_limited` is false, read them again with `texel_inside`. That costs less than `texels_inside`: the code of the
// repair stands in the kernel once, and the code for sound texels does not wait for it.
fn texels_loaded(t: texture_2d<f32>, a: vec2i, b: vec2i, c: vec2i, d: vec2i) -> array<vec4f, 4> {
    return array(textureLoad(t, a, 0), textureLoad(t, b, 0), textureLoad(t, c, 0), textureLoad(t, d, 0));
}

// True if sanitizing changes none of four texels.
fn are_limited(a: vec4f, b: vec4f, c: vec4f, d: vec4f) -> bool {
    if TEXEL_SANITIZE == 0u { return true; }
    var largest = sanitize_largest(bitcast<vec4u>(a), TEXEL_SANITIZE);
    largest = max(largest, sanitize_largest(bitcast<vec4u>(b), TEXEL_SANITIZE));
    largest = max(largest, sanitize_largest(bitcast<vec4u>(c), TEXEL_SANITIZE));
    largest = max(largest, sanitize_largest(bitcast<vec4u>(d), TEXEL_SANITIZE));
    return largest <= HALF_MAX_BITS;
}

// `level_luminance` of a texel of which `are_limited` is true: what is limited as a signal or as light has no channel
// below 0 then.
fn limited_level(rgb: vec3f) -> f32 {
    if TEXEL_SANITIZE == 1u || TEXEL_SANITIZE == 3u { return luminance(rgb); }
    return level_luminance(rgb);
}

// Four texels at positions inside. All are loaded before the first is examined, so that their latencies overlap.
fn texels_inside(t: texture_2d<f32>, a: vec2i, b: vec2i, c: vec2i, d: vec2i) -> array<vec4f, 4> {
    let texels = texels_loaded(t, a, b, c, d);
    if TEXEL_SANITIZE == 0u { return texels; }
    var first = texels[0];
    var second = texels[1];
    var third = texels[2];
    var fourth = texels[3];
    // With a return from within the branch, kernels take a third longer.
    if !are_limited(first, second, third, fourth) {
        first = sanitize_loaded(t, a, first, TEXEL_SANITIZE);
        second = sanitize_loaded(t, b, second, TEXEL_SANITIZE);
        third = sanitize_loaded(t, c, third, TEXEL_SANITIZE);
        fourth = sanitize_loaded(t, d, fourth, TEXEL_SANITIZE);
    }
    return array(first, second, third, fourth);
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
// other surfaces, so a number that is not finite is limited, and none is put in its place: see `is_sample_known`.
fn texel_sample(t: texture_multisampled_2d<f32>, p: vec2i, index: i32) -> vec4f {
    let v = textureLoad(t, clamp(p, vec2i(0), vec2i(textureDimensions(t)) - 1), index);
    if TEXEL_SANITIZE == 0u { return v; }
    return sanitize_value(v, TEXEL_SANITIZE);
}

// True if the numbers of a sample are known: none is NaN or negative infinity.
fn is_sample_known(t: texture_multisampled_2d<f32>, p: vec2i, index: i32) -> bool {
    if TEXEL_SANITIZE == 0u { return true; }
    let bits = bitcast<vec4u>(textureLoad(t, clamp(p, vec2i(0), vec2i(textureDimensions(t)) - 1), index));
    return all(is_finite(bits) | (bits == vec4u(INFINITY_BITS)));
}

// Bilinear filter, clamped to the border.
fn tap(t: texture_2d<f32>, s: sampler, uv: vec2f) -> vec4f {
    if TAP_BY_HAND { return tap_by_hand(t, uv); }
    return textureSampleLevel(t, s, uv, 0.0);
}

// The weights of two taps of an open image, which beyond its border is half of its nearest texel, along axes of `count`
// texels, at places in texels from where they begin.
fn tap_inside(at: vec2f, count: vec2f) -> vec2f {
    return 0.5 + 0.5 * saturate(min(at, count - at) + 0.5);
}

// Bilinear filter of an open image.
fn tap_open(t: texture_2d<f32>, s: sampler, uv: vec2f) -> vec4f {
    let size = vec2f(textureDimensions(t));
    let inside = tap_inside(uv * size, size);
    return inside.x * inside.y * tap(t, s, uv);
}

fn tap_by_hand(t: texture_2d<f32>, uv: vec2f) -> vec4f {
    let size = vec2f(textureDimensions(t));
    // Far outside, every coordinate is the border. The clamp keeps the conversion to integers defined.
    let p = clamp(uv * size - 0.5, vec2f(-1.0), size);
    let base = floor(p);
    let f = p - base;
    let i = vec2i(base);
    let last = vec2i(textureDimensions(t)) - 1;
    let low = clamp(i, vec2i(0), last);
    let high = clamp(i + 1, vec2i(0), last);
    let corners = texels_inside(t, low, vec2i(high.x, low.y), vec2i(low.x, high.y), high);
    let top = between(corners[0], corners[1], f.x);
    let bottom = between(corners[2], corners[3], f.x);
    return between(top, bottom, f.y);
}

// One texel of a volume, or the nearest one if `p` is outside.
fn texel3(t: texture_3d<f32>, p: vec3i) -> vec4f {
    let inside = clamp(p, vec3i(0), vec3i(textureDimensions(t)) - 1);
    if TEXEL_SANITIZE == 0u { return textureLoad(t, inside, 0); }
    return sanitize_texel3(t, inside, TEXEL_SANITIZE);
}

// A texel of a volume of the host. What is not finite is repaired by its neighbors in its slice, as in an image: a
// march from the camera carries a NaN into all slices behind it.
fn sanitize_texel3(t: texture_3d<f32>, p: vec3i, mode: u32) -> vec4f {
    let v = textureLoad(t, p, 0);
    let bits = bitcast<vec4u>(v);
    if sanitize_largest(bits, mode) <= HALF_MAX_BITS { return v; }
    if all(is_finite(bits)) { return sanitize_limited(v, mode); }
    var is_light = vec4<bool>();
    var least = SANITIZE_ALL;
    for (var index = 0; index < 4; index++) {
        let step = vec3i(select(vec2i(index - 2, 1), vec2i(1, 0), index == 0), 0);
        let one = sanitize_neighbor3(t, p + step);
        let other = sanitize_neighbor3(t, p - step);
        is_light |= (one == vec4u(INFINITY_BITS)) | (other == vec4u(INFINITY_BITS));
        least = min(least, sanitize_larger(one, other));
    }
    return sanitize_repaired(bits, is_light, least, mode);
}

fn sanitize_neighbor3(t: texture_3d<f32>, p: vec3i) -> vec4u {
    let inside = clamp(p, vec3i(0), vec3i(textureDimensions(t)) - 1);
    let bits = bitcast<vec4u>(textureLoad(t, inside, 0));
    return select(vec4u(INFINITY_BITS | 1u), bits, all(p == inside));
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
