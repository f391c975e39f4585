// Constants of linear Rec.709 with D65 white.

// Luminance weights of ITU-R BT.709 with four digits. Their sum is exactly 1.
const LUMINANCE: vec3f = vec3f(0.2126, 0.7152, 0.0722);

fn luminance(rgb: vec3f) -> f32 {
    return dot(rgb, LUMINANCE);
}

fn brightest(rgb: vec3f) -> f32 {
    return max(rgb.r, max(rgb.g, rgb.b));
}
