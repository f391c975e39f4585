// From a metered mean to stops, and how stops follow it in time. `stops` is log2 of a multiplier, EV100 the brightness of a
// scene: with luminance in cd/m2, EV100 = log2(L * 100 / 12.5) = log2(L) + 3 (reflected-light meter, ISO 2720, K = 12.5).

const METERING_PI: f32 = 3.14159265;
// The reflectance that a meter takes a scene to have.
const METERING_GREY: f32 = 0.18;
const METERING_EV100: f32 = 3.0;
// Nearer than this, in stops, an exposure has arrived: it then rests, to the bit.
const METERING_ARRIVAL: f32 = 0.0009765625;
const METERING_MAX_STOPS: f32 = 24.0;

// Seconds that have passed: none for a negative number or NaN, a finite many for infinity. The bits of both are greater, as
// whole numbers, than those of infinity; comparing floats proves nothing about NaN.
fn metering_seconds(dt: f32) -> f32 {
    let bits = bitcast<u32>(dt);
    let finite = select(min(dt, 1e6), 1e6, bits == 0x7f800000u);
    return select(finite, 0.0, bits > 0x7f800000u);
}

// The stops that bring a metered mean of log2 luminance to the key.
fn metering_stops(mean: f32, lowest: f32, highest: f32, key: f32, compensation: f32) -> f32 {
    return clamp(key - clamp(mean, lowest, highest) + compensation, -METERING_MAX_STOPS, METERING_MAX_STOPS);
}

// Lux on a grey card whose log2 luminance is `mean`: E = pi L / 0.18 (Lambert).
fn metering_lux(mean: f32) -> f32 {
    return METERING_PI / METERING_GREY * exp2(clamp(mean, -32.0, 32.0));
}

// Straight lines through four points, level beyond the ends. `evs` must rise; where two are equal the later one holds.
fn metering_curve(ev: f32, evs: vec4f, stops: vec4f) -> f32 {
    let t = clamp((vec3f(ev) - evs.xyz) / max(evs.yzw - evs.xyz, vec3f(1e-6)), vec3f(0.0), vec3f(1.0));
    return mix(mix(mix(stops.x, stops.y, t.x), stops.z, t.y), stops.w, t.z);
}

// 1 - exp(-x) for x >= 0, without the cancellation near 0 that would slow adaptation at high frame rates.
fn metering_share(x: f32) -> f32 {
    return select(1.0 - exp(-min(x, 80.0)), x * (1.0 - x * (0.5 - x / 6.0)), x < 0.02);
}

// One step towards the wanted stops; rates in 1/s, `dark` when the scene got darker and the gain must rise.
fn metering_exponential(stops: f32, wanted: f32, dt: f32, dark: f32, bright: f32) -> f32 {
    let rate = select(bright, dark, wanted > stops);
    return metering_arrive(stops, wanted, dt, (wanted - stops) * metering_share(rate * dt));
}

// The same at a constant speed; speeds in stops per second.
fn metering_linear(stops: f32, wanted: f32, dt: f32, dark: f32, bright: f32) -> f32 {
    return metering_arrive(stops, wanted, dt, clamp(wanted - stops, -bright * dt, dark * dt));
}

fn metering_arrive(stops: f32, wanted: f32, dt: f32, step: f32) -> f32 {
    if dt <= 0.0 { return stops; }
    return select(stops + step, wanted, abs(wanted - stops) < METERING_ARRIVAL);
}
