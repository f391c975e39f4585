#import color
#import grade

struct Saturation {
    amount: f32,
}

fn saturation(source: vec4f, params: Saturation) -> vec4f {
    let grey = vec3f(luminance(source.rgb));
    return vec4f(bounded_light(grey + params.amount * (source.rgb - grey)), source.a);
}
