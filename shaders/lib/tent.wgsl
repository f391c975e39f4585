// A tent filter: weights 1 2 1 in x times 1 2 1 in y.
#import sampling

// The weight of the tap at (x, y), each -1, 0 or 1. All nine sum to 1.
fn tent_weight(x: i32, y: i32) -> f32 {
    return f32((2 - abs(x)) * (2 - abs(y))) / 16.0;
}

// Nine bilinear taps, `radius` texels apart.
fn tap_tent(t: texture_2d<f32>, s: sampler, uv: vec2f, radius: f32) -> vec4f {
    if radius <= 1.0 { return tap_narrow_tent(t, s, uv, radius); }
    let spacing = radius / vec2f(textureDimensions(t));
    var sum = vec4f();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let color = tap(t, s, uv + vec2f(f32(x), f32(y)) * spacing);
            sum += tent_weight(x, y) * color;
        }
    }
    return sum;
}

// The weights of four texels in a row from `first` on, from all taps around `center`. All in texels.
fn tent_shares(center: f32, radius: f32, first: f32) -> vec4f {
    let away = first + vec4f(0.0, 1.0, 2.0, 3.0) - center;
    let middle = saturate(1.0 - abs(away));
    let sides = saturate(1.0 - abs(away + radius)) + saturate(1.0 - abs(away - radius));
    return 0.5 * middle + 0.25 * sides;
}

// The same sum in four taps. Up to a radius of 1 the tent spans 4x4 texels, and a tap between two texels weights both.
fn tap_narrow_tent(t: texture_2d<f32>, s: sampler, uv: vec2f, radius: f32) -> vec4f {
    let size = vec2f(textureDimensions(t));
    let center = uv * size - 0.5;
    let first = floor(center - radius);
    let x = tent_shares(center.x, radius, first.x);
    let y = tent_shares(center.y, radius, first.y);
    let across = vec2f(x.x + x.y, x.z + x.w);
    let down = vec2f(y.x + y.y, y.z + y.w);
    // A pair without weight is read at its first texel and adds 0.
    let u = (first.x + vec2f(0.5, 2.5) + vec2f(x.y, x.w) / max(across, vec2f(1e-6))) / size.x;
    let v = (first.y + vec2f(0.5, 2.5) + vec2f(y.y, y.w) / max(down, vec2f(1e-6))) / size.y;
    let upper = across.x * tap(t, s, vec2f(u.x, v.x)) + across.y * tap(t, s, vec2f(u.y, v.x));
    let lower = across.x * tap(t, s, vec2f(u.x, v.y)) + across.y * tap(t, s, vec2f(u.y, v.y));
    return down.x * upper + down.y * lower;
}
