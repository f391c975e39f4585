// The mean luminance of an image: each workgroup sums a tile of 64x64 pixels, then one workgroup sums the tiles. Both
// sums have a fixed order. Without weights the divisor is the exact number of pixels, so no size needs padding.
import afterimage::color::luminance;
import afterimage::workgroup::{Invocation, workgroup_sum, workgroup_sum_and_max};
import afterimage::metering_weight::{metering_mask, metering_weight};

struct MeanLuminance {
    lo: f32,
    center: vec2f,
    radius: f32,
    // Numbers of pixels and of tiles, computed from the size.
    pixels: f32,
    tiles: u32,
}

// Weights of pixels: by their distance from the center, by a mask, or equal.
override MEAN_LUMINANCE_WEIGHT: u32 = 0;
override MEAN_LUMINANCE_MASK: bool = false;
override MEAN_LUMINANCE_WEIGHTED: bool = false;

const MEAN_LUMINANCE_INVOCATIONS: u32 = 256u;
const MEAN_LUMINANCE_TILE: u32 = 64u;

@group(0) @binding(0) var<uniform> params: MeanLuminance;
@group(0) @binding(1) var picture: texture_2d<f32>;
@group(0) @binding(2) var mask: texture_2d<f32>;
// The weighted sum, the brightest pixel and the weight of each tile.
@group(0) @binding(3) var<storage, read_write> written: array<vec4f>;
@group(0) @binding(4) var<storage, read> tiles: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> result: array<vec4f>;

// Four pixels of the tile, four rows apart: the luminance of each and its weight, 0 outside of the image. They are
// loaded together, so that their latencies overlap.
fn mean_luminance_of(tile: vec2u, invocation: u32, row: u32) -> array<vec2f, 4> {
    let within = vec2u(invocation % MEAN_LUMINANCE_TILE, row + invocation / MEAN_LUMINANCE_TILE);
    let first = tile * MEAN_LUMINANCE_TILE + within;
    let size = textureDimensions(picture);
    let last = vec2i(size) - 1;
    let p = vec2i(first);
    let colors = texels_loaded(
        picture,
        min(p, last),
        min(p + vec2i(0, 4), last),
        min(p + vec2i(0, 8), last),
        min(p + vec2i(0, 12), last),
    );
    var found = vec4f(
        luminance(colors[0].rgb),
        luminance(colors[1].rgb),
        luminance(colors[2].rgb),
        luminance(colors[3].rgb),
    );
    if !are_limited(colors[0], colors[1], colors[2], colors[3]) {
        for (var k = 0u; k < 4u; k++) {
            found[k] = luminance(texel_inside(picture, min(p + vec2i(0, 4 * i32(k)), last)).rgb);
        }
    }
    var pixels: array<vec2f, 4>;
    for (var k = 0u; k < 4u; k++) {
        let cell = first + vec2u(0u, 4u * k);
        let uv = (vec2f(cell) + 0.5) / vec2f(size);
        let weight = select(0.0, mean_luminance_weight(uv, vec2f(size)), all(cell < size));
        pixels[k] = vec2f(max(found[k], 0.0), weight);
    }
    return pixels;
}

fn mean_luminance_weight(uv: vec2f, size: vec2f) -> f32 {
    var weight = 1.0;
    if MEAN_LUMINANCE_WEIGHT != 0u {
        weight = metering_weight(MEAN_LUMINANCE_WEIGHT, uv, size, params.center, params.radius);
    }
    if MEAN_LUMINANCE_MASK { weight *= metering_mask(mask, uv); }
    return weight;
}

// Adds a pixel: its part of the mean, its luminance and its weight.
fn mean_luminance_add(sum: vec3f, part: f32, pixel: vec2f) -> vec3f {
    let brightest = max(sum.y, select(0.0, pixel.x, pixel.y > 0.0));
    return vec3f(sum.x + part * pixel.y, brightest, sum.z + pixel.y);
}

// The sum, the brightest pixel and the weight of all invocations.
fn mean_luminance_join(invocation: Invocation, sum: vec3f) -> vec3f {
    let joined = workgroup_sum_and_max(invocation, MEAN_LUMINANCE_INVOCATIONS, sum.xy);
    if !MEAN_LUMINANCE_WEIGHTED { return vec3f(joined, 0.0); }
    workgroupBarrier();
    return vec3f(joined, workgroup_sum(invocation, MEAN_LUMINANCE_INVOCATIONS, vec2f(sum.z, 0.0)).x);
}

fn mean_luminance_write(group: vec2u, groups: u32, invocation: Invocation, sum: vec3f) {
    let joined = mean_luminance_join(invocation, sum);
    if invocation.index == 0u { written[group.y * groups + group.x] = vec4f(joined, 0.0); }
}

@compute @workgroup_size(256)
fn mean_luminance_log(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    invocation: Invocation,
) {
    var sum = vec3f();
    for (var row = 0u; row < MEAN_LUMINANCE_TILE; row += 16u) {
        let pixels = mean_luminance_of(group.xy, invocation.index, row);
        for (var k = 0u; k < 4u; k++) {
            sum = mean_luminance_add(sum, max(log2(max(pixels[k].x, 1e-37)), params.lo), pixels[k]);
        }
    }
    mean_luminance_write(group.xy, groups.x, invocation, sum);
}

@compute @workgroup_size(256)
fn mean_luminance_linear(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    invocation: Invocation,
) {
    var sum = vec3f();
    for (var row = 0u; row < MEAN_LUMINANCE_TILE; row += 16u) {
        let pixels = mean_luminance_of(group.xy, invocation.index, row);
        for (var k = 0u; k < 4u; k++) { sum = mean_luminance_add(sum, pixels[k].x, pixels[k]); }
    }
    mean_luminance_write(group.xy, groups.x, invocation, sum);
}

fn mean_luminance_total(invocation: Invocation) -> vec3f {
    var sum = vec3f();
    for (var tile = invocation.index; tile < params.tiles; tile += MEAN_LUMINANCE_INVOCATIONS) {
        let part = tiles[tile].xyz;
        sum = vec3f(sum.x + part.x, max(sum.y, part.y), sum.z + part.z);
    }
    return mean_luminance_join(invocation, sum);
}

// The mean of all pixels from their sum.
fn mean_luminance_mean(total: vec3f) -> f32 {
    if MEAN_LUMINANCE_WEIGHTED { return total.x / max(total.z, 1e-30); }
    return total.x / params.pixels;
}

// The mean as log2, the brightest pixel, and 1 if any pixel is brighter than black.
fn mean_luminance_give(mean: f32, brightest: f32) {
    result[0] = vec4f(max(mean, params.lo), brightest, 0.0, select(0.0, 1.0, brightest > 0.0));
}

@compute @workgroup_size(256)
fn mean_luminance_of_logs(invocation: Invocation) {
    let total = mean_luminance_total(invocation);
    if invocation.index == 0u { mean_luminance_give(mean_luminance_mean(total), total.y); }
}

@compute @workgroup_size(256)
fn mean_luminance_log_of_mean(invocation: Invocation) {
    let total = mean_luminance_total(invocation);
    if invocation.index == 0u { mean_luminance_give(log2(max(mean_luminance_mean(total), 1e-37)), total.y); }
}
