import afterimage::grade::bounded_scene;

struct WhiteBalance {
    row0: vec4f,
    row1: vec4f,
    row2: vec4f,
}

fn white_balance(source: vec4f, params: WhiteBalance) -> vec4f {
    let rgb = vec3f(
        dot(params.row0.xyz, source.rgb),
        dot(params.row1.xyz, source.rgb),
        dot(params.row2.xyz, source.rgb),
    );
    return vec4f(bounded_scene(rgb), source.a);
}
