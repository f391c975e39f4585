// The shown image is flat.

@group(0) @binding(1) var shown: texture_2d<f32>;

fn shown_size() -> vec2f {
    return vec2f(textureDimensions(shown));
}

fn shown_at(texel: vec2i) -> vec4f {
    let last = vec2i(textureDimensions(shown)) - 1;
    return textureLoad(shown, clamp(texel, vec2i(0), last), 0);
}

fn slices() -> u32 {
    return 1u;
}

fn texel_at(texel: vec2u, slice: u32) -> vec4f {
    return textureLoad(shown, texel, 0);
}
