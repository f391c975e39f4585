// An exposure whose scene brightness is stated and not metered. It is adapted in time as a metered one.
#import metering

struct MeteringFixed {
    key_log2: f32,
    lowest_mean: f32,
    highest_mean: f32,
    compensation: f32,
    rate_dark: f32,
    rate_bright: f32,
    hold: u32,
}

@group(0) @binding(0) var<uniform> params: MeteringFixed;
@group(0) @binding(1) var<uniform> frame: Frame;
// Stops, mean, lux, and 1 if they are valid.
@group(0) @binding(2) var<storage, read_write> result: array<vec4f>;
// The target of the previous frame, in stops.
@group(0) @binding(3) var<storage, read_write> wanted_before: array<f32>;

fn metering_fixed_aim() -> MeteringAim {
    let mean = params.lowest_mean;
    let wanted = metering_stops(mean, params.lowest_mean, params.highest_mean, params.key_log2, params.compensation);
    return MeteringAim(wanted_before[0], wanted);
}

fn metering_fixed_write(adapted: f32, wanted: f32) {
    let known = result[0].w > 0.0 && frame.reset == 0u;
    let stops = metering_held(params.hold, result[0].x, adapted);
    let mean = params.lowest_mean;
    result[0] = vec4f(select(wanted, stops, known), mean, metering_lux(mean), 1.0);
    wanted_before[0] = wanted;
}

@compute @workgroup_size(1)
fn metering_fixed_exponential() {
    let aim = metering_fixed_aim();
    let dt = metering_seconds(frame.dt);
    let adapted = metering_exponential(result[0].x, aim, dt, params.rate_dark, params.rate_bright);
    metering_fixed_write(adapted, aim.wanted);
}

@compute @workgroup_size(1)
fn metering_fixed_linear() {
    let aim = metering_fixed_aim();
    let dt = metering_seconds(frame.dt);
    let adapted = metering_linear(result[0].x, aim, dt, params.rate_dark, params.rate_bright);
    metering_fixed_write(adapted, aim.wanted);
}
