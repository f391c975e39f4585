// Copies an image or a buffer in several shapes: how much an invocation copies decides what a device reaches. All loads
// of an invocation come before its stores, so that they are in flight together.
@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var copied: texture_storage_2d<rgba16float, write>;
@group(0) @binding(2) var<storage, read> numbers: array<vec4u>;
@group(0) @binding(3) var<storage, read_write> stored: array<vec4u>;

// Loads outside of an image give zero, stores outside of it nothing: only whole workgroups check nothing.
@compute @workgroup_size(16, 16)
fn texels_1(@builtin(global_invocation_id) id: vec3u) {
    textureStore(copied, id.xy, textureLoad(source, id.xy, 0));
}

@compute @workgroup_size(32, 8)
fn texels_4(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let at = vec2u(32, 32) * group.xy + local.xy;
    let a = textureLoad(source, at, 0);
    let b = textureLoad(source, at + vec2u(0, 8), 0);
    let c = textureLoad(source, at + vec2u(0, 16), 0);
    let d = textureLoad(source, at + vec2u(0, 24), 0);
    textureStore(copied, at, a);
    textureStore(copied, at + vec2u(0, 8), b);
    textureStore(copied, at + vec2u(0, 16), c);
    textureStore(copied, at + vec2u(0, 24), d);
}

// The place of the first of `each` vectors of an invocation, which lie 256 vectors apart.
fn first(group: vec3u, groups: vec3u, local: u32, each: u32) -> u32 {
    return (group.y * groups.x + group.x) * 256 * each + local;
}

@compute @workgroup_size(256)
fn vectors_1(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let at = first(group, groups, local, 1);
    if at < arrayLength(&numbers) { stored[at] = numbers[at]; }
}

@compute @workgroup_size(256)
fn vectors_4(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let at = first(group, groups, local, 4);
    if at + 768 >= arrayLength(&numbers) { return; }
    let a = numbers[at];
    let b = numbers[at + 256];
    let c = numbers[at + 512];
    let d = numbers[at + 768];
    stored[at] = a;
    stored[at + 256] = b;
    stored[at + 512] = c;
    stored[at + 768] = d;
}
