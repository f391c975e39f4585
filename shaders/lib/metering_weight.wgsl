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

// The texel of an image of any size at a place.
fn metering_nearest(image: texture_2d<f32>, uv: vec2f) -> vec4f {
    return texel(image, vec2i(uv * vec2f(textureDimensions(image))));
}

// The weight that a mask gives to a place.
fn metering_mask(mask: texture_2d<f32>, uv: vec2f) -> f32 {
    return clamp(metering_nearest(mask, uv).r, 0.0, 1.0);
}
