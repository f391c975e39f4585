import afterimage::grade::bounded_scene;

fn unpremultiply(source: vec4f) -> vec4f {
    let covered = clamp(source.a, 0.0, 1.0);
    return vec4f(select(source.rgb, bounded_scene(source.rgb / max(covered, 1e-30)), covered > 0.0), source.a);
}
