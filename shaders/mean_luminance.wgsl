// The mean luminance of a picture: each workgroup sums a tile of 64x64 pixels, one workgroup sums the tiles. Both sums have
// a fixed shape, and the divisor is the true number of pixels, so that no size needs padding.
#import color
#import lanes

struct MeanLuminance {
    lo: f32,
    // Pixels and tiles, computed from the size.
    pixels: f32,
    tiles: u32,
}

const MEAN_LUMINANCE_LANES: u32 = 256u;
const MEAN_LUMINANCE_TILE: u32 = 64u;

@group(0) @binding(0) var<uniform> params: MeanLuminance;
@group(0) @binding(1) var picture: texture_2d<f32>;
// The sum and the brightest pixel of each tile.
@group(0) @binding(2) var<storage, read_write> written: array<vec2f>;
@group(0) @binding(3) var<storage, read> tiles: array<vec2f>;
@group(0) @binding(4) var<storage, read_write> result: array<vec4f>;

// A pixel of the tile, row by row: the luminance, or a negative number outside the picture.
fn mean_luminance_of(tile: vec2u, lane: u32, row: u32) -> f32 {
    let cell = tile * MEAN_LUMINANCE_TILE + vec2u(lane % MEAN_LUMINANCE_TILE, row + lane / MEAN_LUMINANCE_TILE);
    let light = max(luminance(texel(picture, vec2i(cell)).rgb), 0.0);
    return select(-1.0, light, all(cell < textureDimensions(picture)));
}

fn mean_luminance_write(group: vec2u, groups: u32, lane: Lane, sum: vec2f) {
    let joined = lanes_sum_and_most(lane, MEAN_LUMINANCE_LANES, sum);
    if lane.index == 0u { written[group.y * groups + group.x] = joined; }
}

@compute @workgroup_size(256)
fn mean_luminance_log(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    lane: Lane,
) {
    var sum = vec2f();
    for (var row = 0u; row < MEAN_LUMINANCE_TILE; row += 4u) {
        let light = mean_luminance_of(group.xy, lane.index, row);
        let logarithm = max(log2(max(light, 1e-30)), params.lo);
        sum = lanes_joined(sum, vec2f(select(0.0, logarithm, light >= 0.0), light));
    }
    mean_luminance_write(group.xy, groups.x, lane, sum);
}

@compute @workgroup_size(256)
fn mean_luminance_linear(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    lane: Lane,
) {
    var sum = vec2f();
    for (var row = 0u; row < MEAN_LUMINANCE_TILE; row += 4u) {
        let light = mean_luminance_of(group.xy, lane.index, row);
        sum = lanes_joined(sum, vec2f(max(light, 0.0), light));
    }
    mean_luminance_write(group.xy, groups.x, lane, sum);
}

fn mean_luminance_total(lane: Lane) -> vec2f {
    var sum = vec2f();
    for (var tile = lane.index; tile < params.tiles; tile += MEAN_LUMINANCE_LANES) {
        sum = lanes_joined(sum, tiles[tile]);
    }
    return lanes_sum_and_most(lane, MEAN_LUMINANCE_LANES, sum);
}

// The mean as log2, the brightest pixel, and whether anything is brighter than the floor.
fn mean_luminance_give(mean: f32, brightest: f32) {
    result[0] = vec4f(max(mean, params.lo), brightest, 0.0, select(0.0, 1.0, brightest > exp2(params.lo)));
}

@compute @workgroup_size(256)
fn mean_luminance_of_logs(lane: Lane) {
    let total = mean_luminance_total(lane);
    if lane.index == 0u { mean_luminance_give(total.x / params.pixels, total.y); }
}

@compute @workgroup_size(256)
fn mean_luminance_log_of_mean(lane: Lane) {
    let total = mean_luminance_total(lane);
    if lane.index == 0u { mean_luminance_give(log2(max(total.x / params.pixels, 1e-30)), total.y); }
}
