// Adapts an exposure to a metered mean. The result is kept from frame to frame.
import afterimage::metering::{
    MeteringAim, metering_exponential, metering_held, metering_linear, metering_lux, metering_seconds, metering_stops,
};

struct Adapt {
    key_log2: f32,
    lowest_mean: f32,
    highest_mean: f32,
    compensation: f32,
    rate_dark: f32,
    rate_bright: f32,
    hold: u32,
}

@group(0) @binding(0) var<uniform> params: Adapt;
@group(0) @binding(1) var<uniform> frame: Frame;
// x: log2 of the mean luminance; w: 1 if it is valid.
@group(0) @binding(2) var<storage, read> mean: array<vec4f>;
// Stops, mean, lux, and 1 if they are valid.
@group(0) @binding(3) var<storage, read_write> result: array<vec4f>;
// The target of the previous frame, in stops.
@group(0) @binding(4) var<storage, read_write> wanted_before: array<f32>;

fn adapt_aim() -> MeteringAim {
    let wanted = metering_stops(
        mean[0].x,
        params.lowest_mean,
        params.highest_mean,
        params.key_log2,
        params.compensation,
    );
    return MeteringAim(wanted_before[0], wanted);
}

fn adapt_write(adapted: f32, wanted: f32) {
    let known = result[0].w > 0.0 && frame.reset == 0u;
    let metered = mean[0].w > 0.0;
    let stops = metering_held(params.hold, result[0].x, adapted);
    let next = vec4f(select(wanted, stops, known), mean[0].x, metering_lux(mean[0].x), 1.0);
    result[0] = select(select(vec4f(), result[0], known), next, metered);
    if metered { wanted_before[0] = wanted; }
}

@compute @workgroup_size(1)
fn adapt_exponential() {
    let aim = adapt_aim();
    let dt = metering_seconds(frame.dt);
    let adapted = metering_exponential(result[0].x, aim, dt, params.rate_dark, params.rate_bright);
    adapt_write(adapted, aim.wanted);
}

@compute @workgroup_size(1)
fn adapt_linear() {
    let aim = adapt_aim();
    let dt = metering_seconds(frame.dt);
    let adapted = metering_linear(result[0].x, aim, dt, params.rate_dark, params.rate_bright);
    adapt_write(adapted, aim.wanted);
}
