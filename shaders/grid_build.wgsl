// A bilateral grid (Chen, Paris and Durand, "Real-time Edge-Aware Image Processing with the Bilateral Grid", 2007) over
// x, y and log2 luminance. One workgroup computes one column of cells: it reads the pixels under the column, sums them
// in workgroup memory in fixed point, and stores the column; of tall pictures, several add to a buffer, from which
// another pass stores it. Integer additions commute, so the result does not depend on their order.
import afterimage::cells::cell_first;
import afterimage::color::level_luminance;
import afterimage::stride::{stride_pixel, stride_rows, stride_size};

struct GridBuild {
    lo: f32,
    hi: f32,
    stops: f32,
    size: vec3u,
    bins_per_stop: f32,
    // Steps of the fixed point per unit, such that no sum overflows.
    unit: f32,
    // Factor from fixed-point sums to stored values.
    share: f32,
}

// One pixel of each cell of so many times so many pixels is read.
override GRID_BUILD_STEP: u32 = 1;
// Workgroups for a column of cells.
override GRID_BUILD_PARTS: u32 = 1;

const GRID_BUILD_INVOCATIONS: u32 = 256u;
const GRID_BUILD_MOST_BINS: u32 = 256u;

@group(0) @binding(0) var<uniform> params: GridBuild;
@group(0) @binding(1) var source: texture_2d<f32>;
// Stops in x, added to `stops`. Zero without a meter.
@group(0) @binding(2) var<storage, read> exposure: array<vec4f>;
// Sum of (log2 luminance - the middle of the range), sum of weights, lo, hi. Near the middle, where middle gray is by
// default, half floats hold the sum well: from `lo` on, the base would be off by 0.004 stops.
@group(0) @binding(3) var result: texture_storage_3d<rgba16float, write>;
// The fixed-point sum and weight of each cell, to which several workgroups add.
@group(0) @binding(4) var<storage, read_write> sums: array<atomic<u32>>;

var<workgroup> grid_build_sums: array<atomic<u32>, GRID_BUILD_MOST_BINS>;
var<workgroup> grid_build_weights: array<atomic<u32>, GRID_BUILD_MOST_BINS>;

fn grid_build_clear(invocation: u32, invocations: u32) {
    for (var bin = invocation; bin < params.size.z; bin += invocations) {
        atomicStore(&grid_build_sums[bin], 0u);
        atomicStore(&grid_build_weights[bin], 0u);
    }
    workgroupBarrier();
}

fn grid_build_store(column: vec2u, invocation: u32, invocations: u32) {
    workgroupBarrier();
    for (var bin = invocation; bin < params.size.z; bin += invocations) {
        let weight = f32(atomicLoad(&grid_build_weights[bin]));
        let sum = f32(atomicLoad(&grid_build_sums[bin])) - 0.5 * (params.hi - params.lo) * weight;
        textureStore(result, vec3u(column, bin), vec4f(params.share * vec2f(sum, weight), params.lo, params.hi));
    }
}

// Stops above `lo`, of a pixel and of a level of light.
fn grid_build_level(color: vec4f) -> f32 {
    return grid_build_stops(level_luminance(color.rgb));
}

fn grid_build_stops(light: f32) -> f32 {
    return clamp(log2(max(light, 1e-30)) + params.stops + exposure[0].x, params.lo, params.hi) - params.lo;
}

fn grid_build_bin(level: f32) -> u32 {
    return min(u32(level * params.bins_per_stop), params.size.z - 1u);
}

fn grid_build_add(bin: u32, weight: f32, level: f32) {
    atomicAdd(&grid_build_sums[bin], u32(weight * level * params.unit + 0.5));
    atomicAdd(&grid_build_weights[bin], u32(weight * params.unit + 0.5));
}

// Counts the pixels of a rectangle. An invocation loads four pixels of a column together.
fn grid_build_rectangle(first: vec2u, extent: vec2u, invocation: u32) {
    let size = textureDimensions(source);
    let end = first.y + extent.y;
    let columns = select(64u, 32u, extent.x <= 32u);
    // With a stride, a square of four rows is either loaded or not.
    let top = select(first.y / 4u * 4u, first.y, GRID_BUILD_STEP == 1u);
    var run = GridBuildRun();
    for (var x = invocation % columns; x < extent.x; x += columns) {
        let rows = 4u * (GRID_BUILD_INVOCATIONS / columns);
        for (var y = top + 4u * (invocation / columns); y < end; y += rows) {
            let pixels = stride_rows(vec2u(first.x + x, y), size, GRID_BUILD_STEP);
            let colors = texels_loaded(source, pixels[0], pixels[1], pixels[2], pixels[3]);
            let places = y + vec4u(0u, 1u, 2u, 3u);
            let are_inside = (places >= vec4u(first.y)) & (places < vec4u(end));
            if are_limited(colors[0], colors[1], colors[2], colors[3]) {
                if are_inside.x { grid_build_count(&run, grid_build_stops(limited_level(colors[0].rgb))); }
                if are_inside.y { grid_build_count(&run, grid_build_stops(limited_level(colors[1].rgb))); }
                if are_inside.z { grid_build_count(&run, grid_build_stops(limited_level(colors[2].rgb))); }
                if are_inside.w { grid_build_count(&run, grid_build_stops(limited_level(colors[3].rgb))); }
            } else {
                for (var row = max(y, first.y); row < min(y + 4u, end); row++) {
                    let color = texel_inside(source, stride_pixel(vec2u(first.x + x, row), size, GRID_BUILD_STEP));
                    grid_build_count(&run, grid_build_level(color));
                }
            }
        }
    }
    grid_build_flush(&run);
}

@compute @workgroup_size(256)
fn grid_build_nearest(@builtin(workgroup_id) column: vec3u, @builtin(local_invocation_index) invocation: u32) {
    grid_build_clear(invocation, GRID_BUILD_INVOCATIONS);
    let pixels = stride_size(textureDimensions(source), GRID_BUILD_STEP);
    let first = cell_first(column.xy, pixels, params.size.xy);
    let extent = cell_first(column.xy + 1u, pixels, params.size.xy) - first;
    grid_build_rectangle(first, extent, invocation);
    grid_build_store(column.xy, invocation, GRID_BUILD_INVOCATIONS);
}

// One of several workgroups for a column, one below the other: a picture that is made in bands needs fewer rows at a
// time.
@compute @workgroup_size(256)
fn grid_build_part(@builtin(workgroup_id) place: vec3u, @builtin(local_invocation_index) invocation: u32) {
    grid_build_clear(invocation, GRID_BUILD_INVOCATIONS);
    let column = vec2u(place.x, place.y / GRID_BUILD_PARTS);
    let part = place.y % GRID_BUILD_PARTS;
    let pixels = stride_size(textureDimensions(source), GRID_BUILD_STEP);
    let first = cell_first(column, pixels, params.size.xy);
    let extent = cell_first(column + 1u, pixels, params.size.xy) - first;
    let rows = extent.y * vec2u(part, part + 1u) / GRID_BUILD_PARTS;
    grid_build_rectangle(first + vec2u(0u, rows.x), vec2u(extent.x, rows.y - rows.x), invocation);
    workgroupBarrier();
    for (var bin = invocation; bin < params.size.z; bin += GRID_BUILD_INVOCATIONS) {
        let weight = atomicLoad(&grid_build_weights[bin]);
        if weight > 0u {
            let at = 2u * ((column.y * params.size.x + column.x) * params.size.z + bin);
            atomicAdd(&sums[at], atomicLoad(&grid_build_sums[bin]));
            atomicAdd(&sums[at + 1u], weight);
        }
    }
}

@compute @workgroup_size(256)
fn grid_build_trilinear(@builtin(workgroup_id) column: vec3u, @builtin(local_invocation_index) invocation: u32) {
    grid_build_clear(invocation, GRID_BUILD_INVOCATIONS);
    let size = textureDimensions(source);
    let pixels = stride_size(size, GRID_BUILD_STEP);
    let cells = params.size.xy;
    // All pixels between the centers of the neighboring cells. Pixels outside have the weight 0.
    let first = cell_first(max(column.xy, vec2u(1u)) - 1u, pixels, cells);
    let extent = cell_first(min(column.xy + 2u, cells), pixels, cells) - first;
    for (var i = invocation; i < extent.x * extent.y; i += GRID_BUILD_INVOCATIONS) {
        let pixel = first + vec2u(i % extent.x, i / extent.x);
        let place = clamp((vec2f(pixel) + 0.5) / vec2f(pixels) * vec2f(cells) - 0.5, vec2f(0.0), vec2f(cells - 1u));
        let near = max(1.0 - abs(place - vec2f(column.xy)), vec2f(0.0));
        if near.x * near.y > 0.0 {
            let level = grid_build_level(texel(source, stride_pixel(pixel, size, GRID_BUILD_STEP)));
            grid_build_spread(near.x * near.y, level);
        }
    }
    grid_build_store(column.xy, invocation, GRID_BUILD_INVOCATIONS);
}

// Divides a pixel between the two nearest bins of the column.
fn grid_build_spread(weight: f32, level: f32) {
    let last = params.size.z - 1u;
    let place = clamp(level * params.bins_per_stop - 0.5, 0.0, f32(last));
    let bin = u32(place);
    let above = place - f32(bin);
    grid_build_add(bin, weight * (1.0 - above), level);
    if above > 0.0 { grid_build_add(min(bin + 1u, last), weight * above, level); }
}

// Consecutive pixels of one bin in an invocation. Neighbors mostly share a bin, and an addition in a register is
// cheaper than an atomic addition.
struct GridBuildRun {
    bin: u32,
    sum: u32,
    weight: u32,
}

fn grid_build_flush(run: ptr<function, GridBuildRun>) {
    if (*run).weight == 0u { return; }
    atomicAdd(&grid_build_sums[(*run).bin], (*run).sum);
    atomicAdd(&grid_build_weights[(*run).bin], (*run).weight);
}

fn grid_build_count(run: ptr<function, GridBuildRun>, level: f32) {
    let bin = grid_build_bin(level);
    if bin != (*run).bin {
        grid_build_flush(run);
        *run = GridBuildRun(bin, 0u, 0u);
    }
    (*run).sum += u32(level * params.unit + 0.5);
    (*run).weight += u32(params.unit + 0.5);
}
