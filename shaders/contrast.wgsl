import afterimage::grade::bounded_light;

struct Contrast {
    amount: f32,
    pivot: f32,
}

fn contrast_linear(source: vec4f, params: Contrast) -> vec4f {
    return vec4f(bounded_light((source.rgb - params.pivot) * params.amount + params.pivot), source.a);
}

// Linear in stops: pivot * (x / pivot)^amount. Amount 0 gives the pivot for every value, including black.
fn contrast_log(source: vec4f, params: Contrast) -> vec4f {
    let stops = params.amount * log2(max(source.rgb, vec3f(1e-30)) / params.pivot);
    let spread = params.pivot * exp2(clamp(stops, vec3f(-120.0), vec3f(40.0)));
    let black = (source.rgb <= vec3f(0.0)) & vec3<bool>(params.amount > 0.0);
    return vec4f(bounded_light(select(spread, vec3f(0.0), black)), source.a);
}
