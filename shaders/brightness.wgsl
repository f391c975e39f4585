import afterimage::grade::bounded_light;

struct Brightness {
    amount: f32,
}

fn brightness(source: vec4f, params: Brightness) -> vec4f {
    return vec4f(bounded_light(source.rgb + params.amount), source.a);
}
