// The weight of a pixel in a meter, by its distance from a point.

const METERING_WEIGHT_CENTER: u32 = 1u;
const METERING_WEIGHT_SPOT: u32 = 2u;

// `radius` is in image heights. A Gaussian that is 1/2 at that distance, or 1 within it and 0 beyond; else 1.
fn metering_weight(kind: u32, uv: vec2f, size: vec2f, center: vec2f, radius: f32) -> f32 {
    let away = (uv - center) * vec2f(size.x / size.y, 1.0) / radius;
    let squared = dot(away, away);
    if kind == METERING_WEIGHT_CENTER { return exp2(-min(squared, 126.0)); }
    if kind == METERING_WEIGHT_SPOT { return select(0.0, 1.0, squared <= 1.0); }
    return 1.0;
}
