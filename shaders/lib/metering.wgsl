// From a metered mean to stops, and the adaptation of stops over time. `stops` is log2 of a factor. EV100 is the
// brightness of a scene: with luminance in cd/m2, EV100 = log2(L * 100 / 12.5) = log2(L) + 3 (reflected-light meter,
// ISO 2720, K = 12.5).

const METERING_PI: f32 = 3.14159265;
// The assumed mean reflectance of a scene.
const METERING_GRAY: f32 = 0.18;
const METERING_EV100: f32 = 3.0;
// Within this distance, in stops, an exposure becomes exactly equal to a constant target.
const METERING_ARRIVAL: f32 = 0.0009765625;
const METERING_MAX_STOPS: f32 = 24.0;

// A finite time step in seconds: 0 for a negative number or NaN, a limit for infinity. As integers, the bits of both
// are greater than those of infinity. Float comparisons do not detect NaN reliably.
fn metering_seconds(dt: f32) -> f32 {
    let bits = bitcast<u32>(dt);
    let finite = select(min(dt, 1e6), 1e6, bits == 0x7f800000u);
    return select(finite, 0.0, bits > 0x7f800000u);
}

// The stops that map a metered mean of log2 luminance to the key.
fn metering_stops(mean: f32, lowest: f32, highest: f32, key: f32, compensation: f32) -> f32 {
    return clamp(key - clamp(mean, lowest, highest) + compensation, -METERING_MAX_STOPS, METERING_MAX_STOPS);
}

// The stops of the previous frame while the exposure is held.
fn metering_held(hold: u32, before: f32, adapted: f32) -> f32 {
    return select(adapted, before, hold != 0u);
}

// Lux on a gray card whose log2 luminance is `mean`: E = pi L / 0.18 (Lambert).
fn metering_lux(mean: f32) -> f32 {
    return METERING_PI / METERING_GRAY * exp2(clamp(mean, -32.0, 32.0));
}

// Piecewise linear through four points, constant beyond the ends. `evs` is in ascending order; of two equal ones the
// later applies.
fn metering_curve(ev: f32, evs: vec4f, stops: vec4f) -> f32 {
    let t = clamp((vec3f(ev) - evs.xyz) / max(evs.yzw - evs.xyz, vec3f(1e-6)), vec3f(0.0), vec3f(1.0));
    return mix(mix(mix(stops.x, stops.y, t.x), stops.z, t.y), stops.w, t.z);
}

// 1 - exp(-x) for x >= 0, without the cancellation near 0 that would slow adaptation at high frame rates.
fn metering_share(x: f32) -> f32 {
    return select(1.0 - exp(-min(x, 80.0)), x * (1.0 - x * (0.5 - x / 6.0)), x < 0.02);
}

// 1 - metering_share(x) / x: the share of a linear motion during the time x that is followed by its end.
fn metering_share_of_line(x: f32) -> f32 {
    let series = x * (1.0 / 2.0 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0 - x / 720.0))));
    return select(1.0 - metering_share(x) / max(x, 0.25), series, x < 0.25);
}

// The target is computed once per frame. Between two frames it is taken to move on a straight line from `before` to
// `wanted`. A target that is constant within a frame would be followed half a frame late, so the result would depend on
// the frame rate.
struct MeteringAim {
    before: f32,
    wanted: f32,
}

// One step of e' = rate (aim - e), solved for a target on a line. Rates are in 1/s; `dark` applies when the gain must
// rise.
fn metering_exponential(stops: f32, aim: MeteringAim, dt: f32, dark: f32, bright: f32) -> f32 {
    let x = select(bright, dark, aim.wanted > stops) * dt;
    let step = (aim.before - stops) * metering_share(x) + (aim.wanted - aim.before) * metering_share_of_line(x);
    return metering_arrive(stops, aim, dt, step);
}

// One step at a constant speed, in stops per second. The speed does not depend on where the target was within the
// frame.
fn metering_linear(stops: f32, aim: MeteringAim, dt: f32, dark: f32, bright: f32) -> f32 {
    return metering_arrive(stops, aim, dt, clamp(aim.wanted - stops, -bright * dt, dark * dt));
}

// Limits a step: never away from the current target, never past it. Only a constant target is reached exactly. Snapping
// to a slowly moving one in each frame would make adaptation faster at high frame rates.
fn metering_arrive(stops: f32, aim: MeteringAim, dt: f32, step: f32) -> f32 {
    if dt <= 0.0 { return stops; }
    if aim.before == aim.wanted && abs(aim.wanted - stops) < METERING_ARRIVAL { return aim.wanted; }
    return clamp(stops + step, min(stops, aim.wanted), max(stops, aim.wanted));
}
