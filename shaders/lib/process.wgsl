// The steps of color processes: see graph/color/src/process. Each limits the arguments of powers, logarithms and
// exponentials like the version in double precision.
import package::color::luminance;
import package::transfer::{hlg_decode, hlg_encode, pq_decode, pq_encode};

// The largest magnitude between two steps.
const PROCESS_LIMIT: f32 = 1e12;
// The smallest normal number.
const PROCESS_SMALLEST: f32 = 1.17549435e-38;

fn process_limited(v: vec3f) -> vec3f {
    return clamp(v, vec3f(-PROCESS_LIMIT), vec3f(PROCESS_LIMIT));
}

fn process_matrix(v: vec3f, row0: vec4f, row1: vec4f, row2: vec4f) -> vec3f {
    return vec3f(dot(row0.xyz, v) + row0.w, dot(row1.xyz, v) + row1.w, dot(row2.xyz, v) + row2.w);
}

fn process_range(v: vec3f, slope: f32, offset: f32, low: f32, high: f32) -> vec3f {
    return clamp(v * slope + offset, vec3f(low), vec3f(high));
}

// 2^x, limited to 2^40.
fn process_exp2(x: vec3f) -> vec3f {
    return exp2(clamp(x, vec3f(-126.0), vec3f(40.0)));
}

// 1 for 0, where `sign` is 0.
fn process_sign(v: vec3f) -> vec3f {
    return select(vec3f(1.0), vec3f(-1.0), v < vec3f(0.0));
}

// x^exponent for x above 0, else 0. x itself for an exponent of 1, where an exponential of a logarithm is not exact.
fn process_raised(x: vec3f, exponent: vec3f) -> vec3f {
    let powered = process_exp2(exponent * log2(max(x, vec3f(PROCESS_SMALLEST))));
    return select(select(powered, x, exponent == vec3f(1.0)), vec3f(0.0), x <= vec3f(0.0));
}

// A linear part up to `end` and a logarithm above it.
fn process_logarithm(
    v: vec3f,
    slope: vec3f,
    offset: vec3f,
    end: vec3f,
    a: vec3f,
    b: vec3f,
    scale: vec3f,
    shift: vec3f,
) -> vec3f {
    let above = scale * log2(max(a * v + b, vec3f(PROCESS_SMALLEST))) + shift;
    return select(above, slope * v + offset, v <= end);
}

// A linear part up to `end` and an exponential above it.
fn process_antilog(
    v: vec3f,
    slope: vec3f,
    offset: vec3f,
    end: vec3f,
    a: vec3f,
    b: vec3f,
    scale: vec3f,
    shift: vec3f,
) -> vec3f {
    return select(scale * process_exp2(a * v + b) + shift, slope * v + offset, v <= end);
}

// A line below `end` and a power from it on.
fn process_power(
    v: vec3f,
    slope: vec3f,
    end: vec3f,
    a: vec3f,
    b: vec3f,
    exponent: vec3f,
    scale: vec3f,
    shift: vec3f,
) -> vec3f {
    return select(scale * process_raised(a * v + b, exponent) + shift, slope * v, v < end);
}

// Values below 0 skip the power.
fn process_cdl_power(v: vec3f, power: vec3f) -> vec3f {
    return select(process_raised(v, power), v, v < vec3f(0.0));
}

fn process_saturated(v: vec3f, saturation: f32) -> vec3f {
    return vec3f(luminance(v)) * (1.0 - saturation) + v * saturation;
}

fn process_cdl(
    v: vec3f,
    slope: vec3f,
    offset: vec3f,
    power: vec3f,
    saturation: f32,
    low: f32,
    high: f32,
) -> vec3f {
    let base = clamp(v * slope + offset, vec3f(low), vec3f(high));
    return clamp(process_saturated(process_cdl_power(base, power), saturation), vec3f(low), vec3f(high));
}

// The reverse, with the reciprocals of slope, power and saturation.
fn process_cdl_reverse(
    v: vec3f,
    slope: vec3f,
    offset: vec3f,
    power: vec3f,
    saturation: f32,
    low: f32,
    high: f32,
) -> vec3f {
    let gray = process_saturated(clamp(v, vec3f(low), vec3f(high)), saturation);
    let base = process_cdl_power(clamp(gray, vec3f(low), vec3f(high)), power);
    return clamp((base - offset) * slope, vec3f(low), vec3f(high));
}

// cd/m2 to the perceptual quantizer. Negative light counts as 0, and light above 10000 as that.
fn process_pq_encode(nits: vec3f) -> vec3f {
    let n = clamp(nits, vec3f(0.0), vec3f(10000.0));
    return vec3f(pq_encode(n.r), pq_encode(n.g), pq_encode(n.b));
}

fn process_pq_decode(v: vec3f) -> vec3f {
    let n = clamp(v, vec3f(0.0), vec3f(1.0));
    return vec3f(pq_decode(n.r), pq_decode(n.g), pq_decode(n.b));
}

// Luminance weights of linear Rec.2020.
const PROCESS_REC2020: vec3f = vec3f(0.262700212011, 0.677998071519, 0.059301716470);

// Light in units of the peak to HLG. `exponent` is that of luminance from the display to the scene.
fn process_hlg_encode(light: vec3f, exponent: f32) -> vec3f {
    let bounded = clamp(light, vec3f(0.0), vec3f(1.0));
    let factor = process_raised(vec3f(max(dot(bounded, PROCESS_REC2020), 1e-30)), vec3f(exponent)).x;
    let scene = min(bounded * factor, vec3f(1.0));
    return vec3f(hlg_encode(scene.r), hlg_encode(scene.g), hlg_encode(scene.b));
}

// HLG to light in units of the peak. `exponent` is that of luminance from the scene to the display.
fn process_hlg_decode(v: vec3f, exponent: f32) -> vec3f {
    let n = clamp(v, vec3f(0.0), vec3f(1.0));
    let scene = vec3f(hlg_decode(n.r), hlg_decode(n.g), hlg_decode(n.b));
    return scene * process_raised(vec3f(dot(scene, PROCESS_REC2020)), vec3f(exponent)).x;
}

// An entry of the 1-D tables of a process, which lie in the rows of one texture.
fn process_entry(curves: texture_2d<f32>, index: u32) -> vec3f {
    let width = textureDimensions(curves).x;
    return texel(curves, vec2i(vec2u(index % width, index / width))).rgb;
}

// A 1-D table of `count` entries from `first` on, at positions from 0 to 1.
fn process_curve(curves: texture_2d<f32>, first: u32, count: u32, at: vec3f) -> vec3f {
    let p = clamp(at, vec3f(0.0), vec3f(1.0)) * f32(count - 1u);
    let below = vec3u(min(floor(p), vec3f(f32(count - 2u))));
    let f = p - vec3f(below);
    let i = below + first;
    return vec3f(
        mix(process_entry(curves, i.r).r, process_entry(curves, i.r + 1u).r, f.r),
        mix(process_entry(curves, i.g).g, process_entry(curves, i.g + 1u).g, f.g),
        mix(process_entry(curves, i.b).b, process_entry(curves, i.b + 1u).b, f.b),
    );
}

// The code of the half float at or below |x|, and the distance to it in steps of halves. Halves below 2^-14 have equal
// steps of 2^-24; above, the code is the upper part of the bits of x with another bias of the exponent.
fn process_half_code(x: f32) -> vec2f {
    let magnitude = min(abs(x), 65504.0);
    let small = magnitude * 16777216.0;
    let bits = bitcast<u32>(max(magnitude, 6.1035156e-5)) - (112u << 23u);
    let normal = vec2f(f32(bits >> 13u), f32(bits & 0x1fffu) / 8192.0);
    return select(normal, vec2f(floor(small), fract(small)), magnitude < 6.1035156e-5);
}

// A channel of a table with one entry per code of a half float.
fn process_half_entry(curves: texture_2d<f32>, first: u32, x: f32, channel: u32) -> f32 {
    let place = process_half_code(x);
    let code = u32(place.x);
    let start = first + select(0u, 0x8000u, x < 0.0);
    let low = process_entry(curves, start + code)[channel];
    let high = process_entry(curves, start + min(code + 1u, 0x7bffu))[channel];
    return mix(low, high, place.y);
}

fn process_half_curve(curves: texture_2d<f32>, first: u32, v: vec3f) -> vec3f {
    return vec3f(
        process_half_entry(curves, first, v.r, 0u),
        process_half_entry(curves, first, v.g, 1u),
        process_half_entry(curves, first, v.b, 2u),
    );
}
