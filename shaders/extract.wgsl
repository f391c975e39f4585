// Selects the light that bloom spreads: each colour times a weight. Alpha passes unchanged.
#import color
#import sanitize
#import math

struct Extract {
    threshold: f32,
    knee: f32,
    intensity: f32,
}

// Limited, because alpha and intensity may raise a bright colour above the largest half float.
fn extract_scaled(source: vec4f, weight: f32) -> vec4f {
    return vec4f(clamp(source.rgb * weight, vec3f(-HALF_MAX), vec3f(HALF_MAX)), source.a);
}

// The share of the brightness above the threshold, with a parabola of width 2 * knee that joins both linear parts
// smoothly.
fn extract_knee_weight(brightness: f32, params: Extract) -> f32 {
    let over = brightness - params.threshold;
    let soft = clamp(over + params.knee, 0.0, 2.0 * params.knee);
    let above = max(over, soft * soft / max(4.0 * params.knee, 1e-30));
    return above / max(brightness, 1e-5) * params.intensity;
}

// 1 above the threshold. 0 for black, also if threshold and knee are 0.
fn extract_gate_weight(brightness: f32, params: Extract) -> f32 {
    let open = smooth_step(params.threshold - params.knee, params.threshold + params.knee, brightness);
    return select(open * params.intensity, 0.0, brightness <= 0.0);
}

fn extract_knee_max(source: vec4f, params: Extract) -> vec4f {
    return extract_scaled(source, extract_knee_weight(brightest(source.rgb), params));
}

fn extract_knee_luminance(source: vec4f, params: Extract) -> vec4f {
    return extract_scaled(source, extract_knee_weight(luminance(source.rgb), params));
}

fn extract_gate_max(source: vec4f, params: Extract) -> vec4f {
    return extract_scaled(source, extract_gate_weight(brightest(source.rgb), params));
}

fn extract_gate_luminance(source: vec4f, params: Extract) -> vec4f {
    return extract_scaled(source, extract_gate_weight(luminance(source.rgb), params));
}

// Alpha is the emissive strength of the pixel.
fn extract_emissive(source: vec4f, params: Extract) -> vec4f {
    return extract_scaled(source, select(0.0, source.a * params.intensity, source.a > params.threshold));
}

fn extract_all(source: vec4f, params: Extract) -> vec4f {
    return extract_scaled(source, params.intensity);
}
