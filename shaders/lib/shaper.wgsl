// Shapers bring light of any range into about 0..1, where the nodes of a table are evenly spaced; lookups clamp the rest.

// A line up to a point, and a logarithm above it: `line` is the slope, the offset and where it ends, `curve` a, b, c, d of
// c * log2(a * x + b) + d. A line without end is a shaper that does nothing; a line of slope 0 makes the plain logarithm.
fn shape(x: f32, line: vec4f, curve: vec4f) -> f32 {
    let above = curve.z * log2(max(curve.x * x + curve.y, 1e-30)) + curve.w;
    return select(line.x * x + line.y, above, x > line.z);
}

fn shape3(v: vec3f, line: vec4f, curve: vec4f) -> vec3f {
    return vec3f(shape(v.x, line, curve), shape(v.y, line, curve), shape(v.z, line, curve));
}
