// The exposure of a scene of one brightness, to which the limits of a meter fix it.
import afterimage::metering::{metering_lux, metering_stops};

struct FixedExposure {
    key_log2: f32,
    mean: f32,
    compensation: f32,
}

@group(0) @binding(0) var<uniform> params: FixedExposure;
// Stops, mean, lux, and 1.
@group(0) @binding(1) var<storage, read_write> result: array<vec4f>;

@compute @workgroup_size(1)
fn fixed_exposure() {
    let mean = params.mean;
    let stops = metering_stops(mean, mean, mean, params.key_log2, params.compensation);
    result[0] = vec4f(stops, mean, metering_lux(mean), 1.0);
}
