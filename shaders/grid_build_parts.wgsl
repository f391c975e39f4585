// Stores the columns of cells that several workgroups of `grid_build_part` have summed, as `grid_build_store` does.
struct GridBuildParts {
    lo: f32,
    hi: f32,
    size: vec3u,
    // Factor from fixed-point sums to stored values.
    share: f32,
}

@group(0) @binding(0) var<uniform> params: GridBuildParts;
// The fixed-point sum and weight of each cell.
@group(0) @binding(1) var<storage, read> sums: array<u32>;
@group(0) @binding(2) var result: texture_storage_3d<rgba16float, write>;

@compute @workgroup_size(256)
fn grid_build_parts(@builtin(workgroup_id) column: vec3u, @builtin(local_invocation_index) invocation: u32) {
    for (var bin = invocation; bin < params.size.z; bin += 256u) {
        let at = 2u * ((column.y * params.size.x + column.x) * params.size.z + bin);
        let weight = f32(sums[at + 1u]);
        let sum = f32(sums[at]) - 0.5 * (params.hi - params.lo) * weight;
        textureStore(result, vec3u(column.xy, bin), vec4f(params.share * vec2f(sum, weight), params.lo, params.hi));
    }
}
