import afterimage::noise::hash3;

struct Dither {
    bits: u32,
    seed: u32,
}

// Maps 16 bits to -1/2 to 1/2 exactly. The bits become the low end of the mantissa of a number from 1 to 2, which is
// cheaper than a conversion.
fn dither_number(bits: vec3u) -> vec3f {
    return bitcast<vec3f>(vec3u(0x3f800000u) | bits) * 128.0 - 128.5;
}

// Triangular noise of one code to either side. It fades to uniform noise of half a code at black and white, which stay
// solid. `random` holds two 16-bit numbers per channel.
fn dither_with(source: vec4f, pixel: vec2i, bits: u32, seed: u32) -> vec4f {
    let random = hash3(vec3u(bitcast<vec2u>(pixel), seed));
    let last = f32((1u << bits) - 1u);
    let code = clamp(source.rgb, vec3f(0.0), vec3f(1.0)) * last;
    let inside = clamp(2.0 * min(code, last - code), vec3f(0.0), vec3f(1.0));
    let noise = dither_number(random >> vec3u(16u)) + inside * dither_number(random & vec3u(0xffffu));
    return vec4f(clamp(floor(code + noise + 0.5) * (1.0 / last), vec3f(0.0), vec3f(1.0)), source.a);
}

fn dither(source: vec4f, at: Point, params: Dither) -> vec4f {
    return dither_with(source, at.pixel, params.bits, params.seed);
}

fn dither_animated(source: vec4f, at: Point, frame: Frame, params: Dither) -> vec4f {
    return dither_with(source, at.pixel, params.bits, params.seed + frame.index);
}
