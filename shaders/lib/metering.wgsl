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

// 1 - metering_share(x) / x: how much of a way that was gone evenly during the time x is followed by its end.
fn metering_share_of_line(x: f32) -> f32 {
    let series = x * (1.0 / 2.0 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0 - x / 720.0))));
    return select(1.0 - metering_share(x) / max(x, 0.25), series, x < 0.25);
}

// What is wanted is known once a frame. Between two frames it is taken to go in a straight line, from `before` to `wanted`: held
// for a whole frame it would be followed half a frame late, so that the frame rate would show.
struct MeteringAim {
    before: f32,
    wanted: f32,
}

// One step of e' = rate (aim - e), solved for an aim on a line; rates in 1/s, `dark` when the scene got darker and the gain must rise.
fn metering_exponential(stops: f32, aim: MeteringAim, dt: f32, dark: f32, bright: f32) -> f32 {
    let x = select(bright, dark, aim.wanted > stops) * dt;
    let step = (aim.before - stops) * metering_share(x) + (aim.wanted - aim.before) * metering_share_of_line(x);
    return metering_arrive(stops, aim, dt, step);
}

// The same at a constant speed; speeds in stops per second. Wherever the aim was on its way, the speed is the same.
fn metering_linear(stops: f32, aim: MeteringAim, dt: f32, dark: f32, bright: f32) -> f32 {
    return metering_arrive(stops, aim, dt, clamp(aim.wanted - stops, -bright * dt, dark * dt));
}

// Never away from what is wanted now, never past it. Only an aim that rests is arrived at: to snap to a slow one in each frame
// would follow it faster the more frames there are.
fn metering_arrive(stops: f32, aim: MeteringAim, dt: f32, step: f32) -> f32 {
    if dt <= 0.0 { return stops; }
    if aim.before == aim.wanted && abs(aim.wanted - stops) < METERING_ARRIVAL { return aim.wanted; }
    return clamp(stops + step, min(stops, aim.wanted), max(stops, aim.wanted));
}
