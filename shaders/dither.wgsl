#import noise

struct Dither {
    bits: u32,
    seed: u32,
}

// Two random numbers in [0, 1) for every channel of every pixel, 16 bits each, exact in a float.
fn dither_random(pixel: vec2i, channel: u32, seed: u32) -> vec2f {
    let h = hash(bitcast<u32>(pixel.x) ^ hash(bitcast<u32>(pixel.y) ^ hash(seed * 3u + channel)));
    return vec2f(f32(h >> 16u), f32(h & 0xffffu)) * (1.0 / 65536.0);
}

// Triangular noise of one code to either side, fading to half a code of even noise at black and white, which stay solid.
fn dither_channel(v: f32, random: vec2f, last: f32) -> f32 {
    let code = clamp(v, 0.0, 1.0) * last;
    let inside = clamp(2.0 * min(code, last - code), 0.0, 1.0);
    let noise = mix(random.x - 0.5, random.x + random.y - 1.0, inside);
    return floor(clamp(code + noise, 0.0, last) + 0.5) / last;
}

fn dither_with(source: vec4f, pixel: vec2i, bits: u32, seed: u32) -> vec4f {
    let last = f32((1u << bits) - 1u);
    return vec4f(
        dither_channel(source.r, dither_random(pixel, 0u, seed), last),
        dither_channel(source.g, dither_random(pixel, 1u, seed), last),
        dither_channel(source.b, dither_random(pixel, 2u, seed), last),
        source.a,
    );
}

fn dither(source: vec4f, at: Point, params: Dither) -> vec4f {
    return dither_with(source, at.pixel, params.bits, params.seed);
}

fn dither_animated(source: vec4f, at: Point, frame: Frame, params: Dither) -> vec4f {
    return dither_with(source, at.pixel, params.bits, params.seed + frame.index);
}
