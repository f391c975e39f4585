#import noise

struct Dither {
    bits: u32,
    seed: u32,
}

// Triangular noise of one code to either side, fading to half a code of even noise at black and white, which stay solid.
// `random` holds two numbers of 16 bits for each channel.
fn dither_with(source: vec4f, pixel: vec2i, bits: u32, seed: u32) -> vec4f {
    let random = hash3(vec3u(bitcast<vec2u>(pixel), seed));
    let first = vec3f(random >> vec3u(16u)) * (1.0 / 65536.0);
    let second = vec3f(random & vec3u(0xffffu)) * (1.0 / 65536.0);
    let last = f32((1u << bits) - 1u);
    let code = clamp(source.rgb, vec3f(0.0), vec3f(1.0)) * last;
    let inside = clamp(2.0 * min(code, last - code), vec3f(0.0), vec3f(1.0));
    let noise = mix(first - 0.5, first + second - 1.0, inside);
    return vec4f(floor(clamp(code + noise, vec3f(0.0), vec3f(last)) + 0.5) * (1.0 / last), source.a);
}

fn dither(source: vec4f, at: Point, params: Dither) -> vec4f {
    return dither_with(source, at.pixel, params.bits, params.seed);
}

fn dither_animated(source: vec4f, at: Point, frame: Frame, params: Dither) -> vec4f {
    return dither_with(source, at.pixel, params.bits, params.seed + frame.index);
}
