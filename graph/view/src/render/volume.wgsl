// The shown image is a slice of a volume.

@group(0) @binding(1) var shown: texture_3d<f32>;

fn shown_size() -> vec2f {
    return vec2f(textureDimensions(shown).xy);
}

fn shown_at(texel: vec2i) -> vec4f {
    let last = vec3i(textureDimensions(shown)) - 1;
    return textureLoad(shown, clamp(vec3i(texel, i32(placement.slice)), vec3i(0), last), 0);
}

fn slices() -> u32 {
    return textureDimensions(shown).z;
}

fn texel_at(texel: vec2u, slice: u32) -> vec4f {
    return textureLoad(shown, vec3u(texel, slice), 0);
}
