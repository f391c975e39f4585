import afterimage::grade::{bounded, bounded_power3};

struct Cdl {
    slope: vec3f,
    offset: vec3f,
    power: vec3f,
    saturation: f32,
    luminance_weights: vec3f,
}

// The standard applies no power to values at or below 0.
fn cdl(source: vec4f, params: Cdl) -> vec4f {
    let moved = source.rgb * params.slope + params.offset;
    let powered = select(moved, bounded_power3(moved, params.power), moved > vec3f(0.0));
    let gray = vec3f(dot(powered, params.luminance_weights));
    return vec4f(bounded(gray + params.saturation * (powered - gray)), source.a);
}
