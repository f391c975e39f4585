// A tent filter: weights 1 2 1 in x times 1 2 1 in y.
import package::sampling::{tap, tap_inside, tap_open};

// The weight of the tap at (x, y), each -1, 0 or 1. All nine sum to 1.
fn tent_weight(x: i32, y: i32) -> f32 {
    return f32((2 - abs(x)) * (2 - abs(y))) / 16.0;
}

// Nine bilinear taps, `radius` texels apart. Beyond the border the image is open, or its nearest texel.
fn tap_tent(t: texture_2d<f32>, s: sampler, uv: vec2f, radius: f32, is_open: bool) -> vec4f {
    if radius <= 1.0 { return tap_narrow_tent(t, s, uv, radius, is_open); }
    let spacing = radius / vec2f(textureDimensions(t));
    var sum = vec4f();
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let at = uv + vec2f(f32(x), f32(y)) * spacing;
            if is_open {
                sum += tent_weight(x, y) * tap_open(t, s, at);
            } else {
                sum += tent_weight(x, y) * tap(t, s, at);
            }
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
fn tap_narrow_tent(t: texture_2d<f32>, s: sampler, uv: vec2f, radius: f32, is_open: bool) -> vec4f {
    let size = vec2f(textureDimensions(t));
    let center = uv * size - 0.5;
    let first = floor(center - radius);
    let x = tent_shares(center.x, radius, first.x);
    let y = tent_shares(center.y, radius, first.y);
    var across = vec2f(x.x + x.y, x.z + x.w);
    var down = vec2f(y.x + y.y, y.z + y.w);
    // A pair without weight is read at its first texel and adds 0.
    let columns = first.x + vec2f(0.5, 2.5) + vec2f(x.y, x.w) / max(across, vec2f(1e-6));
    let rows = first.y + vec2f(0.5, 2.5) + vec2f(y.y, y.w) / max(down, vec2f(1e-6));
    if is_open {
        across *= tap_inside(columns, size.xx);
        down *= tap_inside(rows, size.yy);
    }
    let u = columns / size.x;
    let v = rows / size.y;
    let upper = across.x * tap(t, s, vec2f(u.x, v.x)) + across.y * tap(t, s, vec2f(u.y, v.x));
    let lower = across.x * tap(t, s, vec2f(u.x, v.y)) + across.y * tap(t, s, vec2f(u.y, v.y));
    return down.x * upper + down.y * lower;
}

// Two taps along an axis that weigh four texels as a narrow tent does, from a place beside the middle of one of them:
// the distances of the tap at that texel and of the one behind the place, and their weights.
struct TentTaps {
    texels: i32,    // texels of the result for one of the image: 2 or 4
    outer: vec4f,   // for the first and the last of these texels
    inner: vec4f,   // for those between
}

// The same sum for a result of exactly twice or four times the size.
fn tap_whole_tent(t: texture_2d<f32>, s: sampler, at: Point, taps: TentTaps, is_open: bool) -> vec4f {
    let size = vec2f(textureDimensions(t));
    let within = at.pixel & vec2i(taps.texels - 1);
    let is_outer = (within == vec2i()) | (within == vec2i(taps.texels - 1));
    let x = select(taps.inner, taps.outer, is_outer.x);
    let y = select(taps.inner, taps.outer, is_outer.y);
    let toward = select(vec2f(-1.0), vec2f(1.0), 2 * within < vec2i(taps.texels));
    let near = at.uv * size + toward * vec2f(x.x, y.x);
    let far = at.uv * size - toward * vec2f(x.y, y.y);
    var of_near = vec2f(x.z, y.z);
    var of_far = vec2f(x.w, y.w);
    if is_open {
        of_near *= tap_inside(near, size);
        of_far *= tap_inside(far, size);
    }
    let n = near / size;
    let f = far / size;
    let upper = of_near.x * tap(t, s, n) + of_far.x * tap(t, s, vec2f(f.x, n.y));
    let lower = of_near.x * tap(t, s, vec2f(n.x, f.y)) + of_far.x * tap(t, s, f);
    return of_near.y * upper + of_far.y * lower;
}
