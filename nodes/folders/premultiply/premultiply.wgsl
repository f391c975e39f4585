fn premultiply(source: vec4f) -> vec4f {
    return vec4f(source.rgb * clamp(source.a, 0.0, 1.0), source.a);
}
