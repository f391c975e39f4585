// Lets an exposure follow a metered mean: one number in, one out, kept from frame to frame.
#import metering

struct Adapt {
    key_log2: f32,
    lowest_mean: f32,
    highest_mean: f32,
    compensation: f32,
    rate_dark: f32,
    rate_bright: f32,
}

@group(0) @binding(0) var<uniform> params: Adapt;
@group(0) @binding(1) var<uniform> frame: Frame;
// log2 of the mean luminance in x, whether it is known in w.
@group(0) @binding(2) var<storage, read> mean: array<vec4f>;
// Stops, mean, lux and whether they hold anything.
@group(0) @binding(3) var<storage, read_write> result: array<vec4f>;

fn adapt_wanted() -> f32 {
    return metering_stops(mean[0].x, params.lowest_mean, params.highest_mean, params.key_log2, params.compensation);
}

fn adapt_write(adapted: f32, wanted: f32) {
    let known = result[0].w > 0.0 && frame.reset == 0u;
    let next = vec4f(select(wanted, adapted, known), mean[0].x, metering_lux(mean[0].x), 1.0);
    result[0] = select(select(vec4f(), result[0], known), next, mean[0].w > 0.0);
}

@compute @workgroup_size(1)
fn adapt_exponential() {
    let wanted = adapt_wanted();
    let dt = metering_seconds(frame.dt);
    adapt_write(metering_exponential(result[0].x, wanted, dt, params.rate_dark, params.rate_bright), wanted);
}

@compute @workgroup_size(1)
fn adapt_linear() {
    let wanted = adapt_wanted();
    let dt = metering_seconds(frame.dt);
    adapt_write(metering_linear(result[0].x, wanted, dt, params.rate_dark, params.rate_bright), wanted);
}
