// Shapers map light of any range to about 0..1, where the entries of a table have equal steps. Lookups clamp the rest.

// A linear part up to a point, and a logarithm above it. `line` is slope, offset and end of the linear part; `curve` is
// a, b, c, d of c * log2(a * x + b) + d. Without an end of the linear part the shaper is the identity; with slope 0 it
// is a plain logarithm.
fn shape(x: f32, line: vec4f, curve: vec4f) -> f32 {
    let above = curve.z * log2(max(curve.x * x + curve.y, 1e-30)) + curve.w;
    return select(line.x * x + line.y, above, x > line.z);
}

fn shape3(v: vec3f, line: vec4f, curve: vec4f) -> vec3f {
    return vec3f(shape(v.x, line, curve), shape(v.y, line, curve), shape(v.z, line, curve));
}
