// Contrast adaptive sharpening: Lottes, "FidelityFX CAS", AMD, 2019. A pixel is sharpened less where its surroundings
// have much contrast, or are near black or white.
import afterimage::math::between3;

struct Cas {
    amount: f32,
    sharpness: f32,
    white: f32,
}

// The square around a pixel.
struct CasSquare {
    up: vec3f,
    down: vec3f,
    left: vec3f,
    right: vec3f,
    corners: array<vec3f, 4>,
}

fn cas_square(source: texture_2d<f32>, p: vec2i) -> CasSquare {
    let corners = array(
        texel(source, p + vec2i(-1, -1)).rgb,
        texel(source, p + vec2i(1, -1)).rgb,
        texel(source, p + vec2i(-1, 1)).rgb,
        texel(source, p + vec2i(1, 1)).rgb,
    );
    return CasSquare(
        texel(source, p + vec2i(0, -1)).rgb,
        texel(source, p + vec2i(0, 1)).rgb,
        texel(source, p + vec2i(-1, 0)).rgb,
        texel(source, p + vec2i(1, 0)).rgb,
        corners,
    );
}

fn cas_sharp(center: vec3f, near: CasSquare, params: Cas) -> vec3f {
    // Sums of the limits of the cross and of the whole square, so that diagonals count half.
    let low_cross = min(min(min(near.up, near.down), min(near.left, near.right)), center);
    let high_cross = max(max(max(near.up, near.down), max(near.left, near.right)), center);
    let low_corners = min(min(near.corners[0], near.corners[1]), min(near.corners[2], near.corners[3]));
    let high_corners = max(max(near.corners[0], near.corners[1]), max(near.corners[2], near.corners[3]));
    let low = low_cross + min(low_cross, low_corners);
    let high = high_cross + max(high_cross, high_corners);
    let room = clamp(min(low, 2.0 * params.white - high) / max(high, vec3f(1e-6)), vec3f(0.0), vec3f(1.0));
    // At most 1/5 of each neighbor is subtracted, so the sum of the weights is at least 1/5.
    let weight = -sqrt(room) / mix(8.0, 5.0, params.sharpness);
    let around = (near.up + near.down) + (near.left + near.right);
    let sharp = (center + weight * around) / (1.0 + 4.0 * weight);
    return clamp(sharp, vec3f(0.0), max(center, vec3f(params.white)));
}

fn cas(source: texture_2d<f32>, at: Point, params: Cas) -> vec4f {
    let center = texel(source, at.pixel);
    let sharp = cas_sharp(center.rgb, cas_square(source, at.pixel), params);
    return vec4f(between3(center.rgb, sharp, params.amount), center.a);
}
