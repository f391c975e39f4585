// sRGB (IEC 61966-2-1) of any number: mirrored at 0, continued above 1.

fn encode(light: vec3f) -> vec3f {
    let sized = abs(light);
    let curve = 1.055 * pow(sized, vec3f(1.0 / 2.4)) - 0.055;
    return sign(light) * select(curve, sized * 12.92, sized <= vec3f(0.0031308));
}

fn decode(signal: vec3f) -> vec3f {
    let sized = abs(signal);
    let curve = pow((sized + 0.055) / 1.055, vec3f(2.4));
    return sign(signal) * select(curve, sized / 12.92, sized <= vec3f(0.04045));
}
