// A tent: 1 2 1 in x times 1 2 1 in y.
#import sampling

// The weight of the tap at (x, y), each -1, 0 or 1; all nine sum to 1.
fn tent_weight(x: i32, y: i32) -> f32 {
    return f32((2 - abs(x)) * (2 - abs(y))) / 16.0;
}

// Nine bilinear taps, `radius` texels apart.
fn tap_tent(t: texture_2d<f32>, s: sampler, uv: vec2f, radius: f32) -> vec4f {
    let spacing = radius / vec2f(textureDimensions(t));
    var sum = vec4f();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            sum += tent_weight(x, y) * tap(t, s, uv + vec2f(f32(x), f32(y)) * spacing);
        }
    }
    return sum;
}
