// Computes stops from a histogram. One workgroup scans the bins, computes the mean between two percentiles and adapts
// the exposure to it. Counts are integers and sums have a fixed order, so every run gives equal bits.
import afterimage::math::smooth_step;
import afterimage::metering::{
    METERING_EV100, METERING_MAX_STOPS, MeteringAim, metering_curve, metering_exponential, metering_held,
    metering_linear, metering_lux, metering_seconds, metering_share, metering_stops,
};
import afterimage::workgroup::{Invocation, workgroup_scan, workgroup_sum};

struct AutoExposure {
    low: f32,
    high: f32,
    dark: f32,
    bright: f32,
    key_log2: f32,
    lowest_mean: f32,
    highest_mean: f32,
    compensation: f32,
    curve_ev: vec4f,
    curve_stops: vec4f,
    rate_dark: f32,
    rate_bright: f32,
    highlight_log2: f32,
    hold: u32,
}

// Each invocation has two bins.
const AUTO_EXPOSURE_INVOCATIONS: u32 = 256u;

@group(0) @binding(0) var<uniform> params: AutoExposure;
@group(0) @binding(1) var<uniform> frame: Frame;
@group(0) @binding(2) var<storage, read> histogram: array<u32>;
// Stops, mean, lux, and 1 if they are valid; kept from frame to frame.
@group(0) @binding(3) var<storage, read_write> result: array<vec4f>;
// The target of the previous frame, in stops.
@group(0) @binding(4) var<storage, read_write> wanted_before: array<f32>;
// Stops between the dark and the bright part, their log2 luminances, and 1 if they are valid.
@group(0) @binding(5) var<storage, read_write> range: array<vec4f>;

struct AutoExposureBins {
    count: u32,
    lo: f32,
    per_bin: f32,
}

struct AutoExposureMetered {
    counted: bool,
    mean: f32,
    // log2 luminance of the upper percentile of the mean, and of the dark and the bright part.
    high: f32,
    ends: vec2f,
}

var<workgroup> auto_exposure_quantile: f32;
var<workgroup> auto_exposure_high: f32;
// Half of the window of a percentile at 0 and 1, in shares.
const AUTO_EXPOSURE_NARROWEST: f32 = 0.005;

fn auto_exposure_bins() -> AutoExposureBins {
    let count = u32(bitcast<f32>(histogram[3]));
    let lo = bitcast<f32>(histogram[1]);
    return AutoExposureBins(count, lo, (bitcast<f32>(histogram[2]) - lo) / f32(max(count, 2u) - 1u));
}

// True if this bin contains the pixel of rank `rank`. The last bin in use also contains all higher ranks.
fn auto_exposure_holds(rank: f32, below: u32, through: u32, total: u32) -> bool {
    let in_use = through > below && f32(below) <= rank;
    return in_use && (rank < f32(through) || through == total);
}

// The number of counted pixels in a bin. Bin 0 holds those that the meter ignores.
fn auto_exposure_count(bin: u32, bins: AutoExposureBins) -> u32 {
    let count = histogram[4u + min(bin, bins.count - 1u)];
    return select(0u, count, bin > 0u && bin < bins.count);
}

// The ranks of the percentiles, and the number of counted pixels.
struct AutoExposureRanks {
    first: f32,
    last: f32,
    total: u32,
}

// log2 luminance of a rank in a bin that begins at `edge`.
fn auto_exposure_level(rank: f32, below: u32, count: u32, edge: f32, per_bin: f32) -> f32 {
    return edge + clamp((rank - f32(below)) / f32(count), 0.0, 1.0) * per_bin;
}

// The part of a bin between the percentiles: the weight times the bin's center, and the weight.
fn auto_exposure_part(bin: u32, below: u32, count: u32, bins: AutoExposureBins, ranks: AutoExposureRanks) -> vec2f {
    let through = below + count;
    let edge = bins.lo + (f32(bin) - 1.0) * bins.per_bin;
    let center = edge + 0.5 * bins.per_bin;
    if auto_exposure_holds(ranks.first, below, through, ranks.total) { auto_exposure_quantile = center; }
    if auto_exposure_holds(ranks.last, below, through, ranks.total) {
        auto_exposure_high = auto_exposure_level(ranks.last, below, count, edge, bins.per_bin);
    }
    let end = max(ranks.first, ranks.last);
    let weight = clamp(f32(through), ranks.first, end) - clamp(f32(below), ranks.first, end);
    return vec2f(weight * center, weight);
}

// The weight around a percentile of all pixels up to a share of them. Its window ends at the nearer end of all pixels,
// and what enters it counts little at first: a lamp that grows does not switch it.
fn auto_exposure_through(share: f32, percentile: f32) -> f32 {
    let reach = max(min(percentile, 1.0 - percentile), AUTO_EXPOSURE_NARROWEST);
    return smooth_step(percentile - reach, percentile + reach, share);
}

// The weights of the dark and the bright part between two shares of the pixels.
fn auto_exposure_ends(first: f32, last: f32) -> vec2f {
    let dark = auto_exposure_through(last, params.dark) - auto_exposure_through(first, params.dark);
    let bright = auto_exposure_through(last, params.bright) - auto_exposure_through(first, params.bright);
    return vec2f(dark, bright);
}

fn auto_exposure_meter(invocation: Invocation) -> AutoExposureMetered {
    // A default, because no invocation writes a result if no pixel was counted.
    if invocation.index == 0u {
        auto_exposure_quantile = 0.0;
        auto_exposure_high = 0.0;
    }
    let bins = auto_exposure_bins();
    // Two neighboring bins per invocation, scanned from the darkest to the brightest.
    let bin = 2u * invocation.index;
    let counts = vec2u(auto_exposure_count(bin, bins), auto_exposure_count(bin + 1u, bins));
    // The number of pixels in these bins and all darker ones, and in all bins.
    let scanned = workgroup_scan(invocation, AUTO_EXPOSURE_INVOCATIONS, counts.x + counts.y);
    let total = scanned.y;
    let below = scanned.x - counts.x - counts.y;
    let ranks = AutoExposureRanks(params.low * f32(total), params.high * f32(total), total);
    let parts = auto_exposure_part(bin, below, counts.x, bins, ranks)
        + auto_exposure_part(bin + 1u, below + counts.x, counts.y, bins, ranks);
    let sums = workgroup_sum(invocation, AUTO_EXPOSURE_INVOCATIONS, parts);
    workgroupBarrier();
    let shares = vec3f(vec3u(below, below + counts.x, scanned.x)) / f32(max(total, 1u));
    let center = bins.lo + (f32(bin) - 0.5) * bins.per_bin;
    let levels = auto_exposure_ends(shares.x, shares.y) * center
        + auto_exposure_ends(shares.y, shares.z) * (center + bins.per_bin);
    let ends = workgroup_sum(invocation, AUTO_EXPOSURE_INVOCATIONS, levels) / auto_exposure_ends(0.0, 1.0);
    let is_range = ranks.last > ranks.first && sums.y > 0.0;
    let mean = select(auto_exposure_quantile, sums.x / max(sums.y, 1e-30), is_range);
    return AutoExposureMetered(total > 0u, mean, auto_exposure_high, ends);
}

// The state of the previous frame: the result, and the target in stops.
struct AutoExposureBefore {
    result: vec4f,
    wanted: f32,
}

fn auto_exposure_before() -> AutoExposureBefore {
    return AutoExposureBefore(result[0], wanted_before[0]);
}

fn auto_exposure_aim(metered: AutoExposureMetered, before: AutoExposureBefore) -> MeteringAim {
    let curve = metering_curve(metered.mean + METERING_EV100, params.curve_ev, params.curve_stops);
    let compensation = params.compensation + curve;
    let stops = metering_stops(metered.mean, params.lowest_mean, params.highest_mean, params.key_log2, compensation);
    let wanted = max(min(stops, params.highlight_log2 - metered.high), -METERING_MAX_STOPS);
    return MeteringAim(before.wanted, wanted);
}

fn auto_exposure_write(metered: AutoExposureMetered, before: AutoExposureBefore, adapted: f32, wanted: f32) {
    let known = before.result.w > 0.0 && frame.reset == 0u;
    let stops = metering_held(params.hold, before.result.x, adapted);
    let next = vec4f(select(wanted, stops, known), metered.mean, metering_lux(metered.mean), 1.0);
    let held = select(vec4f(), before.result, known);
    result[0] = select(held, next, metered.counted);
    if metered.counted {
        wanted_before[0] = wanted;
        auto_exposure_write_range(metered, known);
    }
}

// The range approaches that of the frame by the same share of the rest per unit of time, in both directions alike.
fn auto_exposure_write_range(metered: AutoExposureMetered, known: bool) {
    let wanted = max(metered.ends.y - metered.ends.x, 0.0);
    let before = range[0].x;
    let share = select(metering_share(params.rate_dark * metering_seconds(frame.dt)), 0.0, params.hold != 0u);
    let adapted = select(wanted, before + (wanted - before) * share, known && range[0].w > 0.0);
    range[0] = vec4f(adapted, metered.ends, 1.0);
}

@compute @workgroup_size(256)
fn auto_exposure_exponential(invocation: Invocation) {
    // Loaded early, so that the latency overlaps with the sums.
    let before = auto_exposure_before();
    let metered = auto_exposure_meter(invocation);
    if invocation.index == 0u {
        let aim = auto_exposure_aim(metered, before);
        let dt = metering_seconds(frame.dt);
        let adapted = metering_exponential(before.result.x, aim, dt, params.rate_dark, params.rate_bright);
        auto_exposure_write(metered, before, adapted, aim.wanted);
    }
}

@compute @workgroup_size(256)
fn auto_exposure_linear(invocation: Invocation) {
    // Loaded early, so that the latency overlaps with the sums.
    let before = auto_exposure_before();
    let metered = auto_exposure_meter(invocation);
    if invocation.index == 0u {
        let aim = auto_exposure_aim(metered, before);
        let dt = metering_seconds(frame.dt);
        let adapted = metering_linear(before.result.x, aim, dt, params.rate_dark, params.rate_bright);
        auto_exposure_write(metered, before, adapted, aim.wanted);
    }
}
