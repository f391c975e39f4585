// Selects the light that bloom spreads: each color times a weight. Alpha passes unchanged.
import afterimage::color::{brightest, luminance};
import afterimage::sanitize::{HALF_MAX, HALF_MAX_BITS};
import afterimage::math::smooth_step;
import afterimage::neighbors::{Around, largest_around};

struct Extract {
    threshold: f32,
    knee: f32,
    intensity: f32,
}

// Limited, because alpha and intensity may raise a bright color above the largest half float.
fn extract_scaled(source: vec4f, weight: f32) -> vec4f {
    return vec4f(clamp(source.rgb * weight, vec3f(-HALF_MAX), vec3f(HALF_MAX)), source.a);
}

// The share of the brightness above the threshold, with a parabola of width 2 * knee that joins both linear parts
// smoothly.
fn extract_knee_weight(brightness: f32, params: Extract) -> f32 {
    let over = brightness - params.threshold;
    let soft = clamp(over + params.knee, 0.0, 2.0 * params.knee);
    let above = max(over, soft * soft / max(4.0 * params.knee, 1e-30));
    return above / max(brightness, 1e-5) * params.intensity;
}

// 1 above the threshold. 0 for black, also if threshold and knee are 0.
fn extract_gate_weight(brightness: f32, params: Extract) -> f32 {
    let open = smooth_step(params.threshold - params.knee, params.threshold + params.knee, brightness);
    return select(open * params.intensity, 0.0, brightness <= 0.0);
}

fn extract_knee_max(source: vec4f, params: Extract) -> vec4f {
    return extract_scaled(source, extract_knee_weight(brightest(source.rgb), params));
}

fn extract_knee_luminance(source: vec4f, params: Extract) -> vec4f {
    return extract_scaled(source, extract_knee_weight(luminance(source.rgb), params));
}

fn extract_gate_max(source: vec4f, params: Extract) -> vec4f {
    return extract_scaled(source, extract_gate_weight(brightest(source.rgb), params));
}

fn extract_gate_luminance(source: vec4f, params: Extract) -> vec4f {
    return extract_scaled(source, extract_gate_weight(luminance(source.rgb), params));
}

// Alpha is the emissive strength of the pixel, at most 1. A mask of 1 is selected at a threshold of 1.
fn extract_emissive(source: vec4f, params: Extract) -> vec4f {
    return extract_scaled(source, select(0.0, min(source.a, 1.0) * params.intensity, source.a >= params.threshold));
}

fn extract_all(source: vec4f, params: Extract) -> vec4f {
    return extract_scaled(source, params.intensity);
}

// A pixel this much brighter than all around it is a firefly. A light of two pixels has a neighbor of at least a
// quarter of its brightness wherever it lies between pixels.
const EXTRACT_CONTRAST: f32 = 4.0;

// The largest channel of the eight pixels around one.
fn extract_around(source: texture_2d<f32>, p: vec2i) -> f32 {
    let last = vec2i(textureDimensions(source)) - 1;
    var around = 0.0;
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let at = p + vec2i(x, y);
            let is_other = all(at == clamp(at, vec2i(0), last)) && any(at != p);
            around = max(around, select(0.0, brightest(texel(source, at).rgb), is_other));
        }
    }
    return around;
}

// A light that is at most this many times as bright as something near it in the frame before is known, and stays.
const EXTRACT_KNOWN: f32 = 2.0;

// The bits of the largest of four peaks in a row. Bits of floats at or above 0 have the order of integers, and those of
// numbers that are not finite are above all others.
fn extract_four(before: texture_2d<f32>, x: vec4i, y: i32) -> u32 {
    let peaks = texels_loaded(before, vec2i(x.x, y), vec2i(x.y, y), vec2i(x.z, y), vec2i(x.w, y));
    let bits = bitcast<vec4u>(vec4f(peaks[0].r, peaks[1].r, peaks[2].r, peaks[3].r));
    let largest = max(bits.xy, bits.zw);
    return max(largest.x, largest.y);
}

// The largest channel within seven pixels of a place in the frame before, from the peaks of 2x2 pixels: of 8x8. Few
// pixels need it. The loop ends at a number that is not constant: written out, frames take longer. In a row of peaks
// none waits for another.
fn extract_before(before: texture_2d<f32>, p: vec2i) -> f32 {
    let zero = min(p.x, 0);
    let first = (p - 7) >> vec2u(1u);
    let last = vec2i(textureDimensions(before)) - 1;
    let left = clamp(first.x + vec4i(0, 1, 2, 3), vec4i(), vec4i(last.x));
    let right = clamp(first.x + vec4i(4, 5, 6, 7), vec4i(), vec4i(last.x));
    var most = 0u;
    for (var row = 0; row < 8 + zero; row++) {
        let y = clamp(first.y + row, 0, last.y);
        most = max(most, max(extract_four(before, left, y), extract_four(before, right, y)));
    }
    return bitcast<f32>(min(most, HALF_MAX_BITS));
}

// The brightness up to which a pixel stays.
fn extract_limit(around: f32, before: texture_2d<f32>, p: vec2i) -> f32 {
    return max(EXTRACT_CONTRAST * around, EXTRACT_KNOWN * extract_before(before, p));
}

// A pixel, one beside and one above or below it, and the pixel again.
fn extract_texels(source: texture_2d<f32>, at: Point) -> array<vec4f, 4> {
    let beside = vec2i(at.pixel.x + select(1, -1, at.pixel.x > 0), at.pixel.y);
    let above = vec2i(at.pixel.x, at.pixel.y + select(1, -1, at.pixel.y > 0));
    let last = vec2i(at.size) - 1;
    return texels_inside(source, at.pixel, min(beside, last), min(above, last), at.pixel);
}

// True if a pixel beside or above shows that this one is no firefly, which decides nearly all pixels.
fn extract_is_plain(color: vec4f, beside: vec4f, above: vec4f, at: Point) -> bool {
    let across = select(0.0, brightest(beside.rgb), at.size.x > 1.0);
    let near = max(across, select(0.0, brightest(above.rgb), at.size.y > 1.0));
    return brightest(color.rgb) <= EXTRACT_CONTRAST * near;
}

// The color, dimmed so that no channel exceeds the limit. The only pixel of an image has nothing around it.
fn extract_dimmed(color: vec4f, limit: f32, at: Point) -> vec4f {
    let light = brightest(color.rgb);
    let is_alone = all(at.size <= vec2f(1.0));
    return vec4f(color.rgb * select(limit / light, 1.0, light <= limit || is_alone), color.a);
}

fn extract_limited(source: texture_2d<f32>, at: Point) -> vec4f {
    let texels = extract_texels(source, at);
    let color = texels[0];
    if extract_is_plain(color, texels[1], texels[2], at) { return color; }
    return extract_dimmed(color, EXTRACT_CONTRAST * extract_around(source, at.pixel), at);
}

// The same with the peaks of the frame before. Without one, nothing shows that a light was not there.
fn extract_limited_since(source: texture_2d<f32>, before: texture_2d<f32>, at: Point, frame: Frame) -> vec4f {
    let texels = extract_texels(source, at);
    let color = texels[0];
    if frame.reset != 0u || extract_is_plain(color, texels[1], texels[2], at) { return color; }
    let near = extract_around(source, at.pixel);
    if brightest(color.rgb) <= EXTRACT_CONTRAST * near { return color; }
    return extract_dimmed(color, extract_limit(near, before, at.pixel), at);
}

// The same with what the eight pixels around show, by `extract_number`.
fn extract_limited_around(source: vec4f, around: Around, at: Point) -> vec4f {
    return extract_dimmed(source, EXTRACT_CONTRAST * largest_around(around), at);
}

fn extract_limited_around_since(
    source: vec4f,
    around: Around,
    before: texture_2d<f32>,
    at: Point,
    frame: Frame,
) -> vec4f {
    if frame.reset != 0u || !extract_stands_out(source, around) { return source; }
    return extract_dimmed(source, extract_limit(largest_around(around), before, at.pixel), at);
}

// True if the pixel may be a firefly: few are.
fn extract_stands_out(source: vec4f, around: Around) -> bool {
    return brightest(source.rgb) > EXTRACT_CONTRAST * largest_around(around);
}

fn extract_number(texel: vec4f) -> f32 {
    return brightest(texel.rgb);
}

// The largest channel of 2x2 pixels, or of those inside.
fn extract_peaks(source: texture_2d<f32>, at: Point) -> vec4f {
    let first = 2 * at.pixel;
    let last = min(first + 1, vec2i(textureDimensions(source)) - 1);
    let texels = texels_inside(source, first, vec2i(last.x, first.y), vec2i(first.x, last.y), last);
    return extract_peaks_of_square(Square(texels[0], texels[1], texels[2], texels[3]));
}

fn extract_peaks_of_square(square: Square) -> vec4f {
    let upper = max(brightest(square.upper_left.rgb), brightest(square.upper_right.rgb));
    let lower = max(brightest(square.lower_left.rgb), brightest(square.lower_right.rgb));
    return vec4f(max(max(upper, lower), 0.0), 0.0, 0.0, 1.0);
}
