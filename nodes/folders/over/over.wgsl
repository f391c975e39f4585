import afterimage::grade::bounded_scene;

struct Over { opacity: f32 }

fn over(source: vec4f, front: vec4f, params: Over) -> vec4f {
    let covered = params.opacity * clamp(front.a, 0.0, 1.0);
    let light = params.opacity * front.rgb + (1.0 - covered) * source.rgb;
    return vec4f(bounded_scene(light), covered + (1.0 - covered) * source.a);
}
