// Its members are parameters of the node, by name.
struct MyKind {
    amount: f32,
    tint: vec3f,
}

// The result at a pixel. An argument with the name of an input is the input's pixel. To read around it, take
// `source: texture_2d<f32>, source_sampler: sampler, at: Point`, and call `tap(source, source_sampler, at.uv)`.
fn my_kind(source: vec4f, params: MyKind) -> vec4f {
    let tint = mix(vec3f(1.0), params.tint, params.amount);
    return vec4f(source.rgb * tint, source.a);
}
