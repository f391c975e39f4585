// Fast approximate anti-aliasing: Lottes, "FXAA", NVIDIA, 2009, in the form of FXAA 3.11 for quality. An edge is found
// by its contrast, followed along its row or column to both ends, and each pixel beside it is read at a place between
// the two sides of the edge, by its distance from the nearer end.
import afterimage::color::luminance;

struct Fxaa {
    subpixel: f32,
    threshold: f32,
    floor: f32,
}

// The reads along an edge, from one pixel on. An array that a loop indexes would be copied at each read.
struct FxaaReads {
    singles: u32,  // steps of one pixel; then one of 1.5, and steps of two
    last: u32,     // the number of steps, of which the last but one has four pixels
    far: f32,      // the last step, to the distance of an edge without an end
}

// The brightness of the square around a pixel: rows from the top.
struct FxaaSquare {
    rows: array<vec3f, 3>,
}

// An edge beside a pixel.
struct FxaaEdge {
    along: vec2f,      // the step along the edge, in pixels
    across: vec2f,     // the step to the pixel on its other side
    middle: f32,       // the mean brightness of both sides
    contrast: f32,     // the least difference from it that ends the edge
}

// Brightness as the eye sees it: of encoded colors their luminance, of light the square root of it.
fn fxaa_brightness(color: vec4f, is_light: bool) -> f32 {
    let y = max(luminance(color.rgb), 0.0);
    return select(y, sqrt(y), is_light);
}

// The brightness beside a pixel: above, left, right and below.
fn fxaa_beside(source: texture_2d<f32>, p: vec2i, is_light: bool) -> vec4f {
    let above = texel(source, p - vec2i(0, 1));
    let left = texel(source, p - vec2i(1, 0));
    let right = texel(source, p + vec2i(1, 0));
    let below = texel(source, p + vec2i(0, 1));
    return vec4f(
        fxaa_brightness(above, is_light),
        fxaa_brightness(left, is_light),
        fxaa_brightness(right, is_light),
        fxaa_brightness(below, is_light),
    );
}

// The difference between the brightest and the darkest of a pixel and the four beside it; 0 where that is too small to
// be seen.
fn fxaa_contrast(center: f32, beside: vec4f, params: Fxaa) -> f32 {
    let high = max(max(beside.y, beside.z), max(max(beside.x, beside.w), center));
    let low = min(min(beside.y, beside.z), min(min(beside.x, beside.w), center));
    return select(high - low, 0.0, high - low < max(params.floor, high * params.threshold));
}

// The square around a pixel, of which all but the corners is known. Few pixels need them.
fn fxaa_square(source: texture_2d<f32>, p: vec2i, center: f32, beside: vec4f, is_light: bool) -> FxaaSquare {
    let upper_left = texel(source, p + vec2i(-1, -1));
    let upper_right = texel(source, p + vec2i(1, -1));
    let lower_left = texel(source, p + vec2i(-1, 1));
    let lower_right = texel(source, p + vec2i(1, 1));
    return FxaaSquare(array(
        vec3f(fxaa_brightness(upper_left, is_light), beside.x, fxaa_brightness(upper_right, is_light)),
        vec3f(beside.y, center, beside.z),
        vec3f(fxaa_brightness(lower_left, is_light), beside.w, fxaa_brightness(lower_right, is_light)),
    ));
}

// The offset toward the neighbor for a pixel that differs from all around it: this dims dots and thin lines.
fn fxaa_subpixel(square: FxaaSquare, contrast: f32, params: Fxaa) -> f32 {
    let upper = square.rows[0];
    let middle = square.rows[1];
    let lower = square.rows[2];
    let beside = (upper.y + lower.y) + (middle.x + middle.z);
    let corners = (upper.x + upper.z) + (lower.x + lower.z);
    let differs = clamp(abs((2.0 * beside + corners) / 12.0 - middle.y) / contrast, 0.0, 1.0);
    let smoothed = differs * differs * (3.0 - 2.0 * differs);
    return smoothed * smoothed * params.subpixel;
}

// Second differences across the rows, of the three columns; the middle one counts twice.
fn fxaa_bend(before: vec3f, middle: vec3f, after: vec3f) -> f32 {
    let bend = abs(before + after - 2.0 * middle);
    return (bend.x + bend.z) + 2.0 * bend.y;
}

fn fxaa_edge(square: FxaaSquare) -> FxaaEdge {
    let columns = transpose(mat3x3f(square.rows[0], square.rows[1], square.rows[2]));
    let center = square.rows[1].y;
    let across_rows = fxaa_bend(square.rows[0], square.rows[1], square.rows[2]);
    let across_columns = fxaa_bend(columns[0], columns[1], columns[2]);
    // At the corner of an area both are equal but for rounding, which decides in FXAA 3.11: here it is a row, on every
    // device.
    let is_row = 1.001 * across_rows >= across_columns;
    let before = select(square.rows[1].x, square.rows[0].y, is_row);
    let after = select(square.rows[1].z, square.rows[2].y, is_row);
    let is_before = abs(before - center) >= abs(after - center);
    let other = select(after, before, is_before);
    let side = select(1.0, -1.0, is_before);
    let across = side * select(vec2f(1.0, 0.0), vec2f(0.0, 1.0), is_row);
    let along = select(vec2f(0.0, 1.0), vec2f(1.0, 0.0), is_row);
    return FxaaEdge(along, across, 0.5 * (other + center), 0.25 * abs(other - center));
}

// The distances of presets 39, 25 and 12.
fn fxaa_reads(quality: u32) -> FxaaReads {
    if quality == 1u { return FxaaReads(0u, 7u, 8.0); }
    if quality == 2u { return FxaaReads(0u, 4u, 12.0); }
    return FxaaReads(4u, 11u, 8.0);
}

fn fxaa_step(number: u32, reads: FxaaReads) -> f32 {
    if number + 1u == reads.last { return reads.far; }
    if number + 2u == reads.last { return 4.0; }
    return select(select(1.0, 1.5, number == reads.singles), 2.0, number > reads.singles);
}

// The distance at which an edge ends in one direction, and the brightness of the last read less that of the edge.
fn fxaa_end(
    source: texture_2d<f32>,
    s: sampler,
    uv: vec2f,
    step: vec2f,
    edge: FxaaEdge,
    quality: u32,
    is_light: bool,
) -> vec2f {
    let reads = fxaa_reads(quality);
    var distance = 1.0;
    var difference = 0.0;
    for (var i = 0u; i < reads.last; i++) {
        difference = fxaa_brightness(tap(source, s, uv + distance * step), is_light) - edge.middle;
        if abs(difference) >= edge.contrast { break; }
        distance += fxaa_step(i, reads);
    }
    return vec2f(distance, difference);
}

// The offset across an edge for a pixel beside it: half a pixel at the end of the edge, nothing from its middle on, and
// nothing where the edge ends to the other side.
fn fxaa_offset(
    source: texture_2d<f32>,
    s: sampler,
    at: Point,
    edge: FxaaEdge,
    center: f32,
    quality: u32,
    is_light: bool,
) -> f32 {
    let texel_size = 1.0 / at.size;
    let uv = at.uv + 0.5 * edge.across * texel_size;
    let step = edge.along * texel_size;
    let first = fxaa_end(source, s, uv, -step, edge, quality, is_light);
    let second = fxaa_end(source, s, uv, step, edge, quality, is_light);
    let inside = center - edge.middle < 0.0;
    // Both ends count where they are equally far.
    let is_first = first.x <= second.x && (first.y < 0.0) != inside;
    let is_second = second.x <= first.x && (second.y < 0.0) != inside;
    return select(0.0, 0.5 - min(first.x, second.x) / (first.x + second.x), is_first || is_second);
}

fn fxaa_at(source: texture_2d<f32>, s: sampler, at: Point, params: Fxaa, quality: u32, is_light: bool) -> vec4f {
    let color = texel(source, at.pixel);
    let center = fxaa_brightness(color, is_light);
    let beside = fxaa_beside(source, at.pixel, is_light);
    let contrast = fxaa_contrast(center, beside, params);
    if contrast <= 0.0 { return color; }
    let square = fxaa_square(source, at.pixel, center, beside, is_light);
    let edge = fxaa_edge(square);
    let offset = fxaa_offset(source, s, at, edge, center, quality, is_light);
    let moved = max(offset, fxaa_subpixel(square, contrast, params));
    return tap(source, s, at.uv + moved * edge.across / at.size);
}

fn fxaa_long(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Fxaa) -> vec4f {
    return fxaa_at(source, source_sampler, at, params, 0u, false);
}

fn fxaa_medium(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Fxaa) -> vec4f {
    return fxaa_at(source, source_sampler, at, params, 1u, false);
}

fn fxaa_short(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Fxaa) -> vec4f {
    return fxaa_at(source, source_sampler, at, params, 2u, false);
}

fn fxaa_long_light(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Fxaa) -> vec4f {
    return fxaa_at(source, source_sampler, at, params, 0u, true);
}

fn fxaa_medium_light(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Fxaa) -> vec4f {
    return fxaa_at(source, source_sampler, at, params, 1u, true);
}

fn fxaa_short_light(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Fxaa) -> vec4f {
    return fxaa_at(source, source_sampler, at, params, 2u, true);
}
