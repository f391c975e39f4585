// Draws an image of a pipeline into the window: placed, filtered by hand, compared, and made visible.

struct Placement {
    // The picture's upper left corner in the window, in physical pixels.
    origin: vec2f,
    // Physical pixels that the picture covers.
    extent: vec2f,
    // Added to the numbers, after the factor.
    gain: f32,
    bias: f32,
    // The first column of the other picture, in physical pixels.
    wipe: f32,
    // The factor of a difference.
    difference: f32,
    // The channel that is shown alone: 0 to 3; 4 for all.
    channel: u32,
    flags: u32,
    // The slice of a volume.
    slice: u32,
    // Light that a display shows as white, in the units of the picture.
    peak: f32,
}

const SMOOTH = 1u;
// The values are linear, to be encoded for the window.
const IS_LINEAR = 2u;
const FALSE_COLOR = 4u;
const CLIPPING = 8u;
const FAULTS = 16u;
const COMPARES = 32u;
const DIFFERS = 64u;

@group(0) @binding(0) var<uniform> placement: Placement;
@group(0) @binding(2) var other: texture_2d<f32>;

@vertex
fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn has(flag: u32) -> bool {
    return (placement.flags & flag) != 0u;
}

fn other_at(texel: vec2i) -> vec4f {
    let last = vec2i(textureDimensions(other)) - 1;
    return textureLoad(other, clamp(texel, vec2i(0), last), 0);
}

fn read_shown(uv: vec2f) -> vec4f {
    let place = uv * shown_size();
    if (!has(SMOOTH)) {
        return shown_at(vec2i(floor(place)));
    }
    let low = floor(place - 0.5);
    let part = place - 0.5 - low;
    let at = vec2i(low);
    let upper = mix(shown_at(at), shown_at(at + vec2i(1, 0)), part.x);
    let lower = mix(shown_at(at + vec2i(0, 1)), shown_at(at + vec2i(1, 1)), part.x);
    return mix(upper, lower, part.y);
}

fn read_other(uv: vec2f) -> vec4f {
    let place = uv * vec2f(textureDimensions(other).xy);
    if (!has(SMOOTH)) {
        return other_at(vec2i(floor(place)));
    }
    let low = floor(place - 0.5);
    let part = place - 0.5 - low;
    let at = vec2i(low);
    let upper = mix(other_at(at), other_at(at + vec2i(1, 0)), part.x);
    let lower = mix(other_at(at + vec2i(0, 1)), other_at(at + vec2i(1, 1)), part.x);
    return mix(upper, lower, part.y);
}

// Compilers may assume that there is no NaN, so its bits are compared.
fn is_nan(x: vec3f) -> bool {
    return any((bitcast<vec3u>(x) & vec3u(0x7fffffffu)) > vec3u(0x7f800000u));
}

fn is_infinite(x: vec3f) -> bool {
    return any((bitcast<vec3u>(x) & vec3u(0x7fffffffu)) == vec3u(0x7f800000u));
}

fn stripes(pixel: vec2f) -> bool {
    return (i32(floor((pixel.x + pixel.y) / 6.0)) & 1) == 0;
}

// Stops around middle gray as colors, from violet for black to red for white.
fn false_color(light: vec3f) -> vec3f {
    let stops = log2(max(dot(light, vec3f(0.2126, 0.7152, 0.0722)), 1e-9) / 0.18);
    var colors = array(
        vec3f(0.10, 0.02, 0.16), vec3f(0.28, 0.11, 0.46), vec3f(0.16, 0.24, 0.66), vec3f(0.10, 0.46, 0.70),
        vec3f(0.14, 0.56, 0.50), vec3f(0.34, 0.36, 0.36), vec3f(0.56, 0.56, 0.54), vec3f(0.78, 0.72, 0.42),
        vec3f(0.92, 0.72, 0.16), vec3f(0.92, 0.44, 0.10), vec3f(0.84, 0.14, 0.12), vec3f(1.0, 0.86, 0.86),
    );
    let band = clamp(i32(floor(stops + 0.5)) + 6, 0, 11);
    return colors[band];
}

fn one_channel(value: vec4f) -> vec3f {
    if (placement.channel < 4u) {
        return vec3f(value[placement.channel]);
    }
    return value.rgb;
}

// The numbers as what the window shows.
fn visible(value: vec4f, pixel: vec2f) -> vec3f {
    let raw = one_channel(value);
    if (has(FAULTS)) {
        if (is_nan(raw)) {
            return select(vec3f(0.0), vec3f(1.0, 0.0, 0.9), stripes(pixel));
        }
        if (is_infinite(raw)) {
            return select(vec3f(0.0), vec3f(1.0, 0.9, 0.0), stripes(pixel));
        }
        if (any(raw < vec3f(0.0))) {
            return select(vec3f(0.0), vec3f(0.0, 0.9, 0.9), stripes(pixel));
        }
    }
    let scaled = raw * placement.gain + placement.bias;
    let signal = select(scaled, encode(scaled), has(IS_LINEAR));
    if (has(FALSE_COLOR)) {
        return false_color(decode(signal));
    }
    let white = encode(vec3f(placement.peak)).x;
    if (has(CLIPPING) && any(signal >= vec3f(white - 0.5 / 255.0))) {
        return select(min(signal, vec3f(white)), vec3f(1.0, 0.1, 0.1), stripes(pixel));
    }
    if (has(CLIPPING) && all(signal <= vec3f(0.5 / 255.0))) {
        return select(max(signal, vec3f(0.0)), vec3f(0.15, 0.3, 1.0), stripes(pixel));
    }
    return clamp(signal, vec3f(0.0), vec3f(white));
}

@fragment
fn draw(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let uv = (position.xy - placement.origin) / placement.extent;
    if (any(uv < vec2f(0.0)) || any(uv >= vec2f(1.0))) {
        discard;
    }
    let first = read_shown(uv);
    if (!has(COMPARES)) {
        return vec4f(visible(first, position.xy), 1.0);
    }
    let second = read_other(uv);
    if (has(DIFFERS)) {
        let apart = abs(one_channel(first) - one_channel(second)) * placement.gain;
        return vec4f(min(apart * placement.difference, vec3f(1.0)), 1.0);
    }
    if (abs(position.x - placement.wipe) < 1.0) {
        return vec4f(0.96, 0.72, 0.26, 1.0);
    }
    return vec4f(visible(select(first, second, position.x > placement.wipe), position.xy), 1.0);
}

// NaN or infinite, in any channel.
fn is_faulty(x: vec4f) -> bool {
    return any((bitcast<vec4u>(x) & vec4u(0x7f800000u)) == vec4u(0x7f800000u));
}

// The number of texels with NaN or infinities in a cell of the grid, in all slices. Each texel belongs to one cell.
fn fault_count(cell: vec2u) -> u32 {
    let size = vec2u(shown_size());
    let grid = vec2u(placement.extent);
    let first = cell * size / grid;
    let end = (cell + 1u) * size / grid;
    var count = 0u;
    for (var slice = 0u; slice < slices(); slice++) {
        for (var y = first.y; y < end.y; y++) {
            for (var x = first.x; x < end.x; x++) {
                count += u32(is_faulty(texel_at(vec2u(x, y), slice)));
            }
        }
    }
    return count;
}

// The numbers themselves at a coarse grid of places, for the scopes. Alpha is the number of faulty texels.
@fragment
fn sample_grid(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let value = shown_at(vec2i(floor(position.xy / placement.extent * shown_size())));
    let limit = vec3f(65504.0);
    let color = select(clamp(value.rgb, -limit, limit), vec3f(0.0), is_nan(value.rgb));
    return vec4f(color, min(f32(fault_count(vec2u(position.xy))), limit.x));
}
