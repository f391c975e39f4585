// The curve of sRGB (IEC 61966-2-1) in both directions, for 0 and above, also beyond 1.
import afterimage::math::power3;

fn srgb_to_code(x: vec3f) -> vec3f {
    let v = max(x, vec3f(0.0));
    return select(1.055 * power3(v, 1.0 / 2.4) - 0.055, 12.92 * v, v <= vec3f(0.0031308));
}

fn srgb_from_code(x: vec3f) -> vec3f {
    let v = max(x, vec3f(0.0));
    return select(power3((v + 0.055) / 1.055, 2.4), v / 12.92, v <= vec3f(0.04045));
}
