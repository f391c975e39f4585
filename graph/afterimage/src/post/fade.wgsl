// Each texel of the host's view: a mix of the images of the old and of the new plan.

@group(0) @binding(0) var before: texture_2d<f32>;
@group(0) @binding(1) var after: texture_2d<f32>;

struct Corner {
    @builtin(position) at: vec4f,
    @location(0) uv: vec2f,
    @location(1) @interpolate(flat) weight: f32,
}

@vertex fn corner(@builtin(vertex_index) index: u32, @builtin(instance_index) share: u32) -> Corner {
    let at = vec2f(vec2u(index & 1u, index >> 1u)) * 4.0 - 1.0;
    // The number of the frame, and the number of frames behind it.
    let weight = f32(share >> 16u) / f32(share & 0xffffu);
    return Corner(vec4f(at, 0.0, 1.0), vec2f(0.5, -0.5) * at + 0.5, weight);
}

@fragment fn mixed(corner: Corner) -> @location(0) vec4f {
    let at = vec2u(corner.uv * vec2f(textureDimensions(after)));
    return mix(textureLoad(before, at, 0), textureLoad(after, at, 0), corner.weight);
}
