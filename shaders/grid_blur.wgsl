// Blurs a bilateral grid along one axis. Sums and weights are blurred alike, and cells outside of the grid are empty:
// readers divide sums by weights, which compensates for the missing cells at the borders.

struct GridBlur {
    axis: vec3i,
    radius: i32,
    // The weight at an offset of i cells is scale * 2^(falloff i^2). All weights within the radius sum to 1.
    falloff: f32,
    scale: f32,
}

@group(0) @binding(0) var<uniform> params: GridBlur;
@group(0) @binding(1) var cells: texture_3d<f32>;
@group(0) @binding(2) var result: texture_storage_3d<rgba16float, write>;

@compute @workgroup_size(8, 8, 4)
fn grid_blur(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(cells);
    if any(id >= size) { return; }
    let cell = vec3i(id);
    let here = dot(cell, params.axis);
    let last = dot(vec3i(size), params.axis) - 1;
    var sums = vec2f();
    for (var offset = max(-params.radius, -here); offset <= min(params.radius, last - here); offset++) {
        let weight = params.scale * exp2(params.falloff * f32(offset * offset));
        sums += weight * texel3(cells, cell + params.axis * offset).xy;
    }
    // The range of the grid passes unchanged.
    textureStore(result, id, vec4f(sums, texel3(cells, cell).zw));
}
