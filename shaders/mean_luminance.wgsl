// The mean luminance of an image: each workgroup sums a tile of 64x64 pixels, then one workgroup sums the tiles. Both
// sums have a fixed order, and the divisor is the exact number of pixels, so no size needs padding.
#import color
#import workgroup

struct MeanLuminance {
    lo: f32,
    // Numbers of pixels and of tiles, computed from the size.
    pixels: f32,
    tiles: u32,
}

const MEAN_LUMINANCE_INVOCATIONS: u32 = 256u;
const MEAN_LUMINANCE_TILE: u32 = 64u;

@group(0) @binding(0) var<uniform> params: MeanLuminance;
@group(0) @binding(1) var picture: texture_2d<f32>;
// The sum and the brightest pixel of each tile.
@group(0) @binding(2) var<storage, read_write> written: array<vec2f>;
@group(0) @binding(3) var<storage, read> tiles: array<vec2f>;
@group(0) @binding(4) var<storage, read_write> result: array<vec4f>;

// A pixel of the tile, row by row: its luminance, or a negative number outside of the image.
fn mean_luminance_of(tile: vec2u, invocation: u32, row: u32) -> f32 {
    let within = vec2u(invocation % MEAN_LUMINANCE_TILE, row + invocation / MEAN_LUMINANCE_TILE);
    let cell = tile * MEAN_LUMINANCE_TILE + within;
    let light = max(luminance(texel(picture, vec2i(cell)).rgb), 0.0);
    return select(-1.0, light, all(cell < textureDimensions(picture)));
}

fn mean_luminance_write(group: vec2u, groups: u32, invocation: Invocation, sum: vec2f) {
    let joined = workgroup_sum_and_max(invocation, MEAN_LUMINANCE_INVOCATIONS, sum);
    if invocation.index == 0u { written[group.y * groups + group.x] = joined; }
}

@compute @workgroup_size(256)
fn mean_luminance_log(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    invocation: Invocation,
) {
    var sum = vec2f();
    for (var row = 0u; row < MEAN_LUMINANCE_TILE; row += 4u) {
        let light = mean_luminance_of(group.xy, invocation.index, row);
        let logarithm = max(log2(max(light, 1e-30)), params.lo);
        sum = sum_and_max(sum, vec2f(select(0.0, logarithm, light >= 0.0), light));
    }
    mean_luminance_write(group.xy, groups.x, invocation, sum);
}

@compute @workgroup_size(256)
fn mean_luminance_linear(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    invocation: Invocation,
) {
    var sum = vec2f();
    for (var row = 0u; row < MEAN_LUMINANCE_TILE; row += 4u) {
        let light = mean_luminance_of(group.xy, invocation.index, row);
        sum = sum_and_max(sum, vec2f(max(light, 0.0), light));
    }
    mean_luminance_write(group.xy, groups.x, invocation, sum);
}

fn mean_luminance_total(invocation: Invocation) -> vec2f {
    var sum = vec2f();
    for (var tile = invocation.index; tile < params.tiles; tile += MEAN_LUMINANCE_INVOCATIONS) {
        sum = sum_and_max(sum, tiles[tile]);
    }
    return workgroup_sum_and_max(invocation, MEAN_LUMINANCE_INVOCATIONS, sum);
}

// The mean as log2, the brightest pixel, and 1 if any pixel is brighter than the lower limit.
fn mean_luminance_give(mean: f32, brightest: f32) {
    result[0] = vec4f(max(mean, params.lo), brightest, 0.0, select(0.0, 1.0, brightest > exp2(params.lo)));
}

@compute @workgroup_size(256)
fn mean_luminance_of_logs(invocation: Invocation) {
    let total = mean_luminance_total(invocation);
    if invocation.index == 0u { mean_luminance_give(total.x / params.pixels, total.y); }
}

@compute @workgroup_size(256)
fn mean_luminance_log_of_mean(invocation: Invocation) {
    let total = mean_luminance_total(invocation);
    if invocation.index == 0u { mean_luminance_give(log2(max(total.x / params.pixels, 1e-30)), total.y); }
}
