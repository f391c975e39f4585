// Copies an image: the highest bandwidth of shaders.
@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var copied: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(16, 16)
fn copy(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(source)) { return; }
    textureStore(copied, id.xy, textureLoad(source, id.xy, 0));
}
