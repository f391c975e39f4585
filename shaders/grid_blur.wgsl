// Blurs a bilateral grid along one axis. Sums and weights are blurred alike, and cells outside of the grid are empty:
// readers divide sums by weights, which compensates for the missing cells at the borders.

struct GridBlur {
    axis: vec3i,
    radius: i32,
    // The weight at an offset of i cells is scale * 2^(falloff i^2). All weights within the radius sum to 1.
    falloff: f32,
    scale: f32,
    // Stops per stop.
    slope: f32,
}

@group(0) @binding(0) var<uniform> params: GridBlur;
@group(0) @binding(1) var cells: texture_3d<f32>;
@group(0) @binding(2) var result: texture_storage_3d<rgba16float, write>;

fn grid_blur_weight(offset: i32) -> f32 {
    return params.scale * exp2(params.falloff * f32(offset * offset));
}

@compute @workgroup_size(8, 8, 4)
fn grid_blur(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(cells);
    if any(id >= size) { return; }
    let cell = vec3i(id);
    let here = dot(cell, params.axis);
    let last = dot(vec3i(size), params.axis) - 1;
    var sums = vec2f();
    for (var offset = max(-params.radius, -here); offset <= min(params.radius, last - here); offset++) {
        sums += grid_blur_weight(offset) * texel3(cells, cell + params.axis * offset).xy;
    }
    // The range of the grid passes unchanged.
    textureStore(result, id, vec4f(sums, texel3(cells, cell).zw));
}

const GRID_BLUR_INVOCATIONS: u32 = 64u;
const GRID_BLUR_MOST_CELLS: u32 = 256u;
// Stops by which another cell counts as further away for each factor of two between the weights. Where two regions meet
// their cells weigh alike; a few pixels of one do not change the means of the other.
const GRID_BLUR_SHARE: f32 = 0.5;

// The cells of a column; the blurred mean of each, and log2 of its weight.
var<workgroup> grid_blur_column: array<vec2f, GRID_BLUR_MOST_CELLS>;
var<workgroup> grid_blur_means: array<vec2f, GRID_BLUR_MOST_CELLS>;

// Blurs along luminance, and limits how fast means change along it: each becomes the middle between the lowest and the
// highest that the other cells of its column allow. Weights stay.
@compute @workgroup_size(64)
fn grid_blur_slope(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) index: u32) {
    let depth = textureDimensions(cells).z;
    for (var z = index; z < depth; z += GRID_BLUR_INVOCATIONS) {
        grid_blur_column[z] = texel3(cells, vec3i(vec3u(group.xy, z))).xy;
    }
    workgroupBarrier();
    for (var z = index; z < depth; z += GRID_BLUR_INVOCATIONS) {
        var sums = vec2f();
        let here = i32(z);
        for (var offset = max(-params.radius, -here); offset <= min(params.radius, i32(depth) - 1 - here); offset++) {
            sums += grid_blur_weight(offset) * grid_blur_column[here + offset];
        }
        grid_blur_means[z] = vec2f(sums.x / max(sums.y, 1e-6), log2(max(sums.y, 1e-12)));
    }
    workgroupBarrier();
    // The range of the grid passes unchanged.
    let range = texel3(cells, vec3i(vec3u(group.xy, 0u))).zw;
    let steepest = params.slope * (range.y - range.x) / f32(depth);
    for (var z = index; z < depth; z += GRID_BLUR_INVOCATIONS) {
        let own = grid_blur_means[z];
        var bounds = vec2f(own.x);
        for (var other = 0u; other < depth; other++) {
            let mean = grid_blur_means[other];
            let away = steepest * abs(f32(other) - f32(z)) + GRID_BLUR_SHARE * abs(mean.y - own.y);
            bounds = vec2f(min(bounds.x, mean.x + away), max(bounds.y, mean.x - away));
        }
        let weight = select(0.0, exp2(own.y), own.y > -39.0);
        textureStore(result, vec3u(group.xy, z), vec4f(0.5 * (bounds.x + bounds.y) * weight, weight, range));
    }
}
