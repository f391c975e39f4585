// Counts the pixels of each luminance. A workgroup counts a tile, 64 pixels wide, in workgroup memory. Then it adds
// only the used bins to the table, because these additions serialize all workgroups. Integer additions commute, so the
// result does not depend on the order of the tiles.
import afterimage::color::{brightest, level_luminance, luminance};
import afterimage::workgroup::Invocation;
import afterimage::stride::{stride_pixel, stride_rows, stride_size};
import afterimage::metering_weight::{metering_mask, metering_nearest, metering_weight};

struct Histogram {
    bins: u32,
    lo: f32,
    hi: f32,
    black: f32,
    center: vec2f,
    radius: f32,
    // Bins per stop above the first bin, computed from the range.
    bins_per_stop: f32,
    // The count of a pixel with full weight.
    full_weight: f32,
    // The inverse of the luminance above black at which a pixel counts in full.
    rise: f32,
}

// Weights of pixels by their distance from the center.
override HISTOGRAM_WEIGHT: u32 = 0;
override HISTOGRAM_MASK: bool = false;
override HISTOGRAM_ALBEDO: bool = false;

// One pixel of each cell of so many times so many pixels is counted.
override HISTOGRAM_STEP: u32 = 1;
// The number of rows of a tile, a multiple of 16.
override HISTOGRAM_ROWS: u32 = 64;

const HISTOGRAM_COLUMNS: u32 = 64u;
const HISTOGRAM_INVOCATIONS: u32 = 256u;
// The largest number of bins.
const HISTOGRAM_MAX_BINS: u32 = 2u * HISTOGRAM_INVOCATIONS;
// The first four words of the table are floats: the brightest channel of the frame, lo, hi and the number of bins.
const HISTOGRAM_HEADER: u32 = 4u;

// Inverse powers of the plastic number.
const HISTOGRAM_STEPS = vec2f(0.75487767, 0.56984029);

@group(0) @binding(0) var<uniform> params: Histogram;
@group(0) @binding(1) var source: texture_2d<f32>;
@group(0) @binding(2) var albedo: texture_2d<f32>;
@group(0) @binding(3) var mask: texture_2d<f32>;
@group(0) @binding(4) var<storage, read_write> result: array<atomic<u32>>;

var<workgroup> histogram_bins: array<atomic<u32>, HISTOGRAM_MAX_BINS>;
var<workgroup> histogram_brightest: atomic<u32>;
// 1 if the tile has light that is too faint to count.
var<workgroup> histogram_faint: atomic<u32>;

@compute @workgroup_size(256)
fn histogram(@builtin(workgroup_id) tile: vec3u, own: Invocation) {
    let invocation = own.index;
    atomicStore(&histogram_bins[invocation], 0u);
    atomicStore(&histogram_bins[invocation + HISTOGRAM_INVOCATIONS], 0u);
    if invocation == 0u {
        atomicStore(&histogram_brightest, 0u);
        atomicStore(&histogram_faint, 0u);
    }
    workgroupBarrier();
    let size = textureDimensions(source);
    let sampled = stride_size(size, HISTOGRAM_STEP);
    var brightest = 0.0;
    for (var row = 0u; row < HISTOGRAM_ROWS; row += 16u) {
        let cell = tile.xy * vec2u(HISTOGRAM_COLUMNS, HISTOGRAM_ROWS)
            + vec2u(invocation % HISTOGRAM_COLUMNS, row + 4u * (invocation / HISTOGRAM_COLUMNS));
        let pixels = stride_rows(cell, size, HISTOGRAM_STEP);
        let colors = texels_loaded(source, pixels[0], pixels[1], pixels[2], pixels[3]);
        let are_sound = are_limited(colors[0], colors[1], colors[2], colors[3]);
        if are_sound && (HISTOGRAM_ALBEDO || histogram_are_full(colors)) {
            if all(cell < sampled) { brightest = max(brightest, histogram_sound(colors[0].rgb, pixels[0], size)); }
            if cell.x < sampled.x && cell.y + 1u < sampled.y {
                brightest = max(brightest, histogram_sound(colors[1].rgb, pixels[1], size));
            }
            if cell.x < sampled.x && cell.y + 2u < sampled.y {
                brightest = max(brightest, histogram_sound(colors[2].rgb, pixels[2], size));
            }
            if cell.x < sampled.x && cell.y + 3u < sampled.y {
                brightest = max(brightest, histogram_sound(colors[3].rgb, pixels[3], size));
            }
        } else {
            for (var k = 0u; k < 4u + min(size.x, 0u); k++) {
                let place = cell + vec2u(0u, k);
                let pixel = stride_pixel(place, size, HISTOGRAM_STEP);
                let color = texel_inside(source, pixel);
                if all(place < sampled) {
                    brightest = max(brightest, histogram_count(color.rgb, pixel, size));
                }
            }
        }
    }
    // The bits of floats at or above 0 have the order of integers.
    atomicMax(&histogram_brightest, bitcast<u32>(brightest));
    workgroupBarrier();
    histogram_add(invocation);
    histogram_add(invocation + HISTOGRAM_INVOCATIONS);
    if invocation == 0u { atomicMax(&result[0], atomicLoad(&histogram_brightest)); }
    if invocation == 0u && all(tile.xy == vec2u()) {
        atomicStore(&result[1], bitcast<u32>(params.lo));
        atomicStore(&result[2], bitcast<u32>(params.hi));
        atomicStore(&result[3], bitcast<u32>(f32(params.bins)));
    }
}

// Adds a bin of the tile to that of the image. Bins beyond the last are empty. Faint light counts 1 in the darkest bin,
// which is next to nothing beside other light: only of exact black there is nothing to meter.
fn histogram_add(bin: u32) {
    var counted = atomicLoad(&histogram_bins[bin]);
    if bin == 0u { counted -= atomicLoad(&histogram_faint); }
    if bin == 1u { counted += atomicLoad(&histogram_faint); }
    if counted > 0u { atomicAdd(&result[HISTOGRAM_HEADER + bin], counted); }
}

// Counts one pixel and returns its largest channel. A pixel that is nearly black counts in part, the rest of it in bin
// 0: so the exposure does not jump when black becomes a little less black. Parts are rounded up or down by a sequence
// that fills the unit interval evenly along both axes, so that many small ones keep their sum.
fn histogram_count(rgb: vec3f, pixel: vec2i, size: vec2u) -> f32 {
    let uv = (vec2f(pixel) + 0.5) / vec2f(size);
    let light = histogram_metered(rgb, uv);
    let weight = histogram_weight(uv, vec2f(size));
    let whole = u32(weight + 0.5);
    var counted = whole;
    let share = clamp((light - params.black) * params.rise, 0.0, 1.0);
    if share < 1.0 { counted = min(u32(weight * share * share + fract(dot(vec2f(pixel), HISTOGRAM_STEPS))), whole); }
    if counted > 0u { atomicAdd(&histogram_bins[histogram_bin(light)], counted); }
    if counted < whole {
        atomicAdd(&histogram_bins[0], whole - counted);
        if light > params.black { atomicStore(&histogram_faint, 1u); }
    }
    return max(brightest(rgb), 0.0);
}

// True if each pixel is bright enough to count in full.
fn histogram_are_full(colors: array<vec4f, 4>) -> bool {
    let first = min(limited_level(colors[0].rgb), limited_level(colors[1].rgb));
    let second = min(limited_level(colors[2].rgb), limited_level(colors[3].rgb));
    return (min(first, second) - params.black) * params.rise >= 1.0;
}

// The same of a pixel that needs no repair, and counts in full if there is no albedo.
fn histogram_sound(rgb: vec3f, pixel: vec2i, size: vec2u) -> f32 {
    if HISTOGRAM_ALBEDO { return histogram_count(rgb, pixel, size); }
    let uv = (vec2f(pixel) + 0.5) / vec2f(size);
    let weight = u32(histogram_weight(uv, vec2f(size)) + 0.5);
    if weight > 0u { atomicAdd(&histogram_bins[histogram_bin(limited_level(rgb))], weight); }
    return max(brightest(rgb), 0.0);
}

// The bin of a luminance: never 0.
fn histogram_bin(light: f32) -> u32 {
    let place = (log2(max(light, 1e-37)) - params.lo) * params.bins_per_stop;
    return 1u + u32(clamp(place, 0.0, f32(params.bins) - 2.0));
}

// The luminance to count: of the pixel, or of a gray card in the same light, 0.18 L / albedo. Negative for an excluded
// pixel.
fn histogram_metered(rgb: vec3f, uv: vec2f) -> f32 {
    let light = level_luminance(rgb);
    if !HISTOGRAM_ALBEDO { return light; }
    let surface = metering_nearest(albedo, uv);
    return select(-1.0, 0.18 * light / clamp(luminance(surface.rgb), 0.04, 1.0), surface.a >= 0.5);
}

fn histogram_weight(uv: vec2f, size: vec2f) -> f32 {
    var weight = params.full_weight;
    if HISTOGRAM_WEIGHT != 0u {
        weight *= metering_weight(HISTOGRAM_WEIGHT, uv, size, params.center, params.radius);
    }
    if HISTOGRAM_MASK { weight *= metering_mask(mask, uv); }
    return weight;
}
