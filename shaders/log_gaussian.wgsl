// The wide, small Gaussian of log2 luminance: an average over areas, then a blur along each axis.
#import color

struct LogGaussian {
    lo: f32,
    hi: f32,
    stops: f32,
    axis: vec2i,
    radius: i32,
    // The weight of an offset of i texels is scale * 2^(falloff i^2); all within the radius sum to 1.
    falloff: f32,
    scale: f32,
}

const LOG_GAUSSIAN_LANES: u32 = 64u;

@group(0) @binding(0) var<uniform> params: LogGaussian;
@group(0) @binding(1) var picture: texture_2d<f32>;
// Stops in x, added to `stops`; zero where nothing is metered.
@group(0) @binding(2) var<storage, read> exposure: array<vec4f>;
@group(0) @binding(3) var result: texture_storage_2d<rgba16float, write>;

var<workgroup> log_gaussian_sums: array<f32, LOG_GAUSSIAN_LANES>;

// How much of a pixel lies in a cell, in parts of a pixel: whole numbers before the division, so nothing is lost or counted twice.
fn log_gaussian_overlap(pixel: vec2u, cell: vec2u, pixels: vec2u, cells: vec2u) -> f32 {
    let overlap = min((pixel + 1u) * cells, (cell + 1u) * pixels) - max(pixel * cells, cell * pixels);
    let share = vec2f(overlap) / vec2f(cells);
    return share.x * share.y;
}

fn log_gaussian_tree(lane: u32, value: f32) -> f32 {
    log_gaussian_sums[lane] = value;
    for (var half = LOG_GAUSSIAN_LANES / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half { log_gaussian_sums[lane] += log_gaussian_sums[lane + half]; }
    }
    workgroupBarrier();
    return log_gaussian_sums[0];
}

// One workgroup averages one texel of the small image.
@compute @workgroup_size(64)
fn log_gaussian_average(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pixels = textureDimensions(picture);
    let cells = textureDimensions(result);
    let cell = group.xy;
    let first = cell * pixels / cells;
    let extent = ((cell + 1u) * pixels + cells - 1u) / cells - first;
    var sum = 0.0;
    for (var i = lane; i < extent.x * extent.y; i += LOG_GAUSSIAN_LANES) {
        let pixel = first + vec2u(i % extent.x, i / extent.x);
        let light = luminance(texel(picture, vec2i(pixel)).rgb);
        let level = clamp(log2(max(light, 1e-30)) + params.stops + exposure[0].x, params.lo, params.hi);
        sum += level * log_gaussian_overlap(pixel, cell, pixels, cells);
    }
    let area = vec2f(pixels) / vec2f(cells);
    let mean = log_gaussian_tree(lane, sum) / (area.x * area.y);
    if lane == 0u { textureStore(result, cell, vec4f(mean, mean, mean, 1.0)); }
}

@compute @workgroup_size(16, 16)
fn log_gaussian_blur(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(result)) { return; }
    var sum = 0.0;
    for (var offset = -params.radius; offset <= params.radius; offset++) {
        let weight = params.scale * exp2(params.falloff * f32(offset * offset));
        sum += weight * texel(picture, vec2i(id.xy) + params.axis * offset).r;
    }
    textureStore(result, id.xy, vec4f(sum, sum, sum, 1.0));
}
