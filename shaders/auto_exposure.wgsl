// Computes stops from a histogram. One workgroup scans the bins, computes the mean between two percentiles and adapts
// the exposure to it. Counts are integers and sums have a fixed order, so every run gives equal bits.
#import workgroup
#import metering

struct AutoExposure {
    low: f32,
    high: f32,
    key_log2: f32,
    lowest_mean: f32,
    highest_mean: f32,
    compensation: f32,
    curve_ev: vec4f,
    curve_stops: vec4f,
    rate_dark: f32,
    rate_bright: f32,
    highlight_log2: f32,
}

const AUTO_EXPOSURE_BINS: u32 = 256u;

@group(0) @binding(0) var<uniform> params: AutoExposure;
@group(0) @binding(1) var<uniform> frame: Frame;
@group(0) @binding(2) var<storage, read> histogram: array<u32>;
// Stops, mean, lux, and 1 if they are valid; kept from frame to frame.
@group(0) @binding(3) var<storage, read_write> result: array<vec4f>;
// The target of the previous frame, in stops.
@group(0) @binding(4) var<storage, read_write> wanted_before: array<f32>;

struct AutoExposureBins {
    count: u32,
    lo: f32,
    per_bin: f32,
}

struct AutoExposureMetered {
    counted: bool,
    mean: f32,
    // log2 luminance of the upper percentile.
    bright: f32,
}

var<workgroup> auto_exposure_quantile: f32;
var<workgroup> auto_exposure_bright: f32;

fn auto_exposure_bins() -> AutoExposureBins {
    let count = u32(bitcast<f32>(histogram[3]));
    let lo = bitcast<f32>(histogram[1]);
    return AutoExposureBins(count, lo, (bitcast<f32>(histogram[2]) - lo) / f32(max(count, 2u) - 1u));
}

// Whether this bin contains the pixel of rank `rank`. The last bin in use also contains all higher ranks.
fn auto_exposure_holds(rank: f32, below: u32, through: u32, total: u32) -> bool {
    let in_use = through > below && f32(below) <= rank;
    return in_use && (rank < f32(through) || through == total);
}

fn auto_exposure_meter(invocation: Invocation) -> AutoExposureMetered {
    // A default, because no invocation writes a result if no pixel was counted.
    if invocation.index == 0u {
        auto_exposure_quantile = 0.0;
        auto_exposure_bright = 0.0;
    }
    let bins = auto_exposure_bins();
    // One bin per invocation, scanned from the darkest to the brightest.
    let bin = workgroup_rank(invocation);
    let used = bin > 0u && bin < bins.count;
    let count = select(0u, histogram[4u + min(bin, bins.count - 1u)], used);
    // The number of pixels in this bin and all darker ones, and in all bins.
    let scanned = workgroup_scan(invocation, AUTO_EXPOSURE_BINS, count);
    let through = scanned.x;
    let total = scanned.y;
    let below = through - count;
    let first = params.low * f32(total);
    let last = params.high * f32(total);
    let edge = bins.lo + (f32(bin) - 1.0) * bins.per_bin;
    if auto_exposure_holds(first, below, through, total) { auto_exposure_quantile = edge + 0.5 * bins.per_bin; }
    if auto_exposure_holds(last, below, through, total) {
        let part = clamp((last - f32(below)) / f32(count), 0.0, 1.0);
        auto_exposure_bright = edge + part * bins.per_bin;
    }
    let weight = clamp(f32(through), first, max(first, last)) - clamp(f32(below), first, max(first, last));
    let sums = workgroup_sum(invocation, AUTO_EXPOSURE_BINS, vec2f(weight * (edge + 0.5 * bins.per_bin), weight));
    let mean = select(auto_exposure_quantile, sums.x / max(sums.y, 1e-30), last > first && sums.y > 0.0);
    return AutoExposureMetered(total > 0u, mean, auto_exposure_bright);
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
    let wanted = max(min(stops, params.highlight_log2 - metered.bright), -METERING_MAX_STOPS);
    return MeteringAim(before.wanted, wanted);
}

fn auto_exposure_write(metered: AutoExposureMetered, before: AutoExposureBefore, adapted: f32, wanted: f32) {
    let known = before.result.w > 0.0 && frame.reset == 0u;
    let next = vec4f(select(wanted, adapted, known), metered.mean, metering_lux(metered.mean), 1.0);
    let held = select(vec4f(), before.result, known);
    result[0] = select(held, next, metered.counted);
    if metered.counted { wanted_before[0] = wanted; }
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
