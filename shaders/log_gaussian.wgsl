// The wide, small Gaussian of log2 luminance: an average over areas, then a blur along each axis.
#import cells
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
// Of a workgroup that makes several cells.
const LOG_GAUSSIAN_ALL_LANES: u32 = 256u;

@group(0) @binding(0) var<uniform> params: LogGaussian;
@group(0) @binding(1) var picture: texture_2d<f32>;
// Stops in x, added to `stops`; zero where nothing is metered.
@group(0) @binding(2) var<storage, read> exposure: array<vec4f>;
@group(0) @binding(3) var result: texture_storage_2d<rgba16float, write>;

var<workgroup> log_gaussian_sums: array<f32, LOG_GAUSSIAN_ALL_LANES>;

fn log_gaussian_level(color: vec4f) -> f32 {
    let light = luminance(color.rgb);
    return clamp(log2(max(light, 1e-30)) + params.stops + exposure[0].x, params.lo, params.hi);
}

// The invocations of a cell bring their sums together, always in the same order, and one of them stores the mean.
fn log_gaussian_store(cell: Cell, sum: f32) {
    let first = cell.slot * cell.lanes;
    let own = first + cell.lane;
    log_gaussian_sums[own] = sum;
    for (var half = cell.lanes / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if cell.lane < half { log_gaussian_sums[own] += log_gaussian_sums[own + half]; }
    }
    if cell.lane == 0u {
        let area = vec2f(textureDimensions(picture)) / vec2f(textureDimensions(result));
        let mean = log_gaussian_sums[own] / (area.x * area.y);
        textureStore(result, cell.place, vec4f(mean, mean, mean, 1.0));
    }
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
        let share = cell_share(pixel, cell, pixels, cells);
        sum += log_gaussian_level(texel(picture, vec2i(pixel))) * (share.x * share.y);
    }
    log_gaussian_store(Cell(cell, lane, LOG_GAUSSIAN_LANES, 0u), sum);
}

fn log_gaussian_begin(cell: Cell) -> f32 {
    return 0.0;
}

fn log_gaussian_visit(sum: ptr<function, f32>, cell: Cell, seen: Seen) {
    *sum += log_gaussian_level(seen.color) * seen.share;
}

fn log_gaussian_finish(sum: ptr<function, f32>, cell: Cell) {
    log_gaussian_store(cell, *sum);
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
