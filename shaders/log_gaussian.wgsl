// A small, wide Gaussian of log2 luminance: an average over areas, then a blur along each axis.
import afterimage::cells::cell_share;
import afterimage::color::level_luminance;
import afterimage::workgroup::{Invocation, workgroup_sum};
import afterimage::stride::{stride_pixel, stride_size};

struct LogGaussian {
    lo: f32,
    hi: f32,
    stops: f32,
    axis: vec2i,
    radius: i32,
    // The weight at an offset of i texels is scale * 2^(falloff i^2). All weights within the radius sum to 1.
    falloff: f32,
    scale: f32,
    step: u32,
}

const LOG_GAUSSIAN_INVOCATIONS: u32 = 64u;

@group(0) @binding(0) var<uniform> params: LogGaussian;
@group(0) @binding(1) var picture: texture_2d<f32>;
// Stops in x, added to `stops`. Zero without a meter.
@group(0) @binding(2) var<storage, read> exposure: array<vec4f>;
@group(0) @binding(3) var result: texture_storage_2d<rgba16float, write>;

fn log_gaussian_level(color: vec4f) -> f32 {
    let light = level_luminance(color.rgb);
    return clamp(log2(max(light, 1e-30)) + params.stops + exposure[0].x, params.lo, params.hi);
}

fn log_gaussian_give(place: vec2u, sum: f32) {
    let area = vec2f(stride_size(textureDimensions(picture), params.step)) / vec2f(textureDimensions(result));
    let mean = sum / (area.x * area.y);
    textureStore(result, place, vec4f(mean, mean, mean, 1.0));
}

// One workgroup averages one texel of the small image.
@compute @workgroup_size(64)
fn log_gaussian_average(@builtin(workgroup_id) group: vec3u, invocation: Invocation) {
    let size = textureDimensions(picture);
    let pixels = stride_size(size, params.step);
    let cells = textureDimensions(result);
    let cell = group.xy;
    let first = cell * pixels / cells;
    let extent = ((cell + 1u) * pixels + cells - 1u) / cells - first;
    var sum = 0.0;
    for (var i = invocation.index; i < extent.x * extent.y; i += LOG_GAUSSIAN_INVOCATIONS) {
        let pixel = first + vec2u(i % extent.x, i / extent.x);
        let share = cell_share(pixel, cell, pixels, cells);
        sum += log_gaussian_level(texel(picture, stride_pixel(pixel, size, params.step))) * (share.x * share.y);
    }
    let all = workgroup_sum(invocation, LOG_GAUSSIAN_INVOCATIONS, vec2f(sum, 0.0));
    if invocation.index == 0u { log_gaussian_give(cell, all.x); }
}

// The image has few texels, and a texel has many neighbors. So four invocations share the neighbors of one texel.
const LOG_GAUSSIAN_PARTS: i32 = 4;
const LOG_GAUSSIAN_TEXELS: u32 = 64u;

// The sum of each invocation.
var<workgroup> log_gaussian_sums: array<f32, 256>;

@compute @workgroup_size(64, 4)
fn log_gaussian_blur(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let pixel = group.xy * vec2u(16u, 4u) + vec2u(local.x % 16u, local.x / 16u);
    var sum = 0.0;
    for (var offset = i32(local.y) - params.radius; offset <= params.radius; offset += LOG_GAUSSIAN_PARTS) {
        let weight = exp2(params.falloff * f32(offset * offset));
        sum += weight * texel(picture, vec2i(pixel) + params.axis * offset).r;
    }
    log_gaussian_sums[local.y * LOG_GAUSSIAN_TEXELS + local.x] = sum;
    workgroupBarrier();
    if local.y == 0u && all(pixel < textureDimensions(result)) {
        let parts = vec4f(
            log_gaussian_sums[local.x],
            log_gaussian_sums[local.x + LOG_GAUSSIAN_TEXELS],
            log_gaussian_sums[local.x + 2u * LOG_GAUSSIAN_TEXELS],
            log_gaussian_sums[local.x + 3u * LOG_GAUSSIAN_TEXELS],
        );
        let level = params.scale * dot(parts, vec4f(1.0));
        textureStore(result, pixel, vec4f(level, level, level, 1.0));
    }
}
