// A typical point pass, drawn and dispatched. FORMAT is replaced by the format of its result.
@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var result: texture_storage_2d<FORMAT, write>;

fn curve(p: vec2u) -> vec4f {
    let v = textureLoad(source, p, 0) * 1.5;
    return vec4f(v.rgb / (1.0 + v.rgb), v.a);
}

@compute @workgroup_size(16, 16)
fn dispatched(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) { return; }
    textureStore(result, id.xy, curve(id.xy));
}

@vertex
fn triangle(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4f(corner * 2.0 - 1.0, 0.0, 1.0);
}

@fragment
fn drawn(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return curve(vec2u(position.xy));
}
