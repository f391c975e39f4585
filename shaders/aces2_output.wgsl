// ACES 2.0 output transform: J is lightness, M colorfulness. The hue is a unit vector, so that no trigonometry is
// needed. Names and formulas are those of graph/color/src/aces2.
import afterimage::math::{between, power, power3};
import afterimage::sampling::texel;

struct Aces2Output {
    enter0: vec4f,      // rows: Rec.709 to AP1, with the factor of the light
    enter1: vec4f,
    enter2: vec4f,
    cones0: vec4f,      // AP1 to adapted cone responses
    cones1: vec4f,
    cones2: vec4f,
    opponents0: vec4f,  // compressed cone responses to A, a, b
    opponents1: vec4f,
    opponents2: vec4f,
    back0: vec4f,       // A, a, b to compressed cone responses, for the display
    back1: vec4f,
    back2: vec4f,
    display0: vec4f,    // cone responses to the display's RGB
    display1: vec4f,
    display2: vec4f,
    brightest: f32,     // AP1 is clipped here
    top: f32,           // the peak in units of 100 cd/m2
    unit: f32,          // 100 cd/m2 in units of the result
    level: f32,         // luminance in cd/m2 to cone responses
    white: f32,         // compressed response to white
    exponent: f32,      // from A to J
    tone: vec2f,        // factor and offset
    chroma: vec4f,      // saturation, threshold, compression, scale
    limit_j: f32,
    mid_j: f32,
    focus_distance: f32,
    lower_gamma_inv: f32,
}

// The hulls at a hue: cusp J, cusp M, the inverse exponent of the upper hull, and the reach of the source.
struct Hull {
    cusp: vec2f,
    upper_gamma_inv: f32,
    reach: f32,
}

// The line start + slope * M, and where the line through the cusp meets the gray axis.
struct Line {
    start: f32,
    slope: f32,
    cusp: f32,
}

const CONE_OFFSET: f32 = 27.13;

fn rows(row0: vec4f, row1: vec4f, row2: vec4f, v: vec3f) -> vec3f {
    return vec3f(dot(row0.xyz, v), dot(row1.xyz, v), dot(row2.xyz, v));
}

fn compress(v: vec3f) -> vec3f {
    let p = power3(abs(v), 0.42);
    return sign(v) * p / (CONE_OFFSET + p);
}

fn expand(v: vec3f) -> vec3f {
    let limited = min(abs(v), vec3f(0.99));
    return sign(v) * power3(CONE_OFFSET * limited / (1.0 - limited), 1.0 / 0.42);
}

// The hull at a hue. The table has segments of equal length along the border of a square around the origin. Each has
// four texels: the hull at its begin, where it bends and at its end, and the place of the bend.
fn hull_at(table: texture_2d<f32>, hue: vec2f) -> Hull {
    let size = vec2i(textureDimensions(table));
    let x = hue.x / (abs(hue.x) + abs(hue.y));
    let count = size.x * size.y / 4;
    let place = select(3.0 + x, 1.0 - x, hue.y >= 0.0) * 0.25 * f32(count);
    let segment = clamp(i32(place), 0, count - 1);
    let base = vec2i(4 * segment % size.x, 4 * segment / size.x);
    let t = place - f32(segment);
    let bend = texel(table, base + vec2i(3, 0)).x;
    let bent = texel(table, base + vec2i(1, 0));
    let before = between(texel(table, base), bent, min(t / bend, 1.0));
    let after = between(bent, texel(table, base + vec2i(2, 0)), (t - bend) / (1.0 - bend));
    let h = select(after, before, t < bend);
    return Hull(h.xy, h.z, h.w);
}

// The achromatic response to the lightness after the tone scale.
fn tone_scaled(a: f32, params: Aces2Output) -> f32 {
    let limited = min(params.white * a, 0.99);
    let y = 0.01 * power(CONE_OFFSET * limited / (1.0 - limited), 1.0 / 0.42) / params.level;
    let f = params.tone.x * power(y / (y + params.tone.y), 1.15);
    let p = power(100.0 * params.level * f * f / (f + 0.04), 0.42);
    return 100.0 * power(p / ((CONE_OFFSET + p) * params.white), params.exponent);
}

fn toe(x: f32, limit: f32, k1_in: f32, k2_in: f32) -> f32 {
    let k2 = max(k2_in, 0.001);
    let k1 = sqrt(k1_in * k1_in + k2 * k2);
    let k3 = (limit + k1) / (limit + k2);
    let b = k3 * x - k1;
    let ac = 4.0 * k2 * k3 * x;
    let root = sqrt(max(b * b + ac, 0.0));
    // The form without a difference of nearly equal numbers.
    let bent = select(0.5 * ac / max(root - b, 1e-30), 0.5 * (b + root), b > 0.0);
    return select(bent, x, x > limit);
}

// A typical M at a hue.
fn chroma_norm(hue: vec2f, params: Aces2Output) -> f32 {
    let c = hue.x;
    let s = hue.y;
    let cosines = 11.34072 * c + 16.46899 * (2.0 * c * c - 1.0) + 7.88380 * (4.0 * c * c - 3.0) * c;
    let sines = 14.66441 * s - 6.37224 * 2.0 * c * s + 9.19364 * (3.0 - 4.0 * s * s) * s;
    return params.chroma.w * (cosines + sines + 77.12896);
}

// M after the tone scale has changed J from `from_j` to `j`.
fn compressed_chroma(from_j: f32, j: f32, m: f32, hue: vec2f, reach: f32, params: Aces2Output) -> f32 {
    let norm = chroma_norm(hue, params);
    let share = j / params.limit_j;
    let rest = max(1.0 - share, 0.0);
    let limit = power(share, 1.0 / params.exponent) * reach / norm;
    let scaled = m * power(j / from_j, 1.0 / params.exponent) / norm;
    let k2 = sqrt(share * share + params.chroma.y);
    let widened = limit - toe(limit - scaled, limit - 0.001, rest * params.chroma.x, k2);
    return norm * toe(widened, limit, share * params.chroma.z, rest);
}

// The inverse slope of lines through points of this J.
fn slope_gain(j: f32, hull: Hull, params: Aces2Output) -> f32 {
    let threshold = mix(hull.cusp.x, params.limit_j, 0.3);
    let gain = params.limit_j * params.focus_distance;
    let room = (params.limit_j - threshold) / max(params.limit_j - j, 1e-4);
    let adjustment = 0.30102999566 * log2(max(room, 1.0));
    return gain * (1.0 + adjustment * adjustment);
}

// J where the line through a point meets the gray axis.
fn axis_meeting(point: vec2f, focus: f32, gain: f32, params: Aces2Output) -> f32 {
    let scaled = point.y / gain;
    let a = scaled / focus;
    if point.x < focus {
        let b = 1.0 - scaled;
        return 2.0 * point.x / (b + sqrt(max(b * b + 4.0 * a * point.x, 0.0)));
    }
    let b = 1.0 + scaled + params.limit_j * a;
    let c = params.limit_j * scaled + point.x;
    return 2.0 * c / (b + sqrt(max(b * b - 4.0 * a * c, 0.0)));
}

fn line_through(point: vec2f, hull: Hull, params: Aces2Output) -> Line {
    let focus = mix(hull.cusp.x, params.mid_j, min(1.3 - hull.cusp.x / params.limit_j, 1.0));
    let gain = slope_gain(point.x, hull, params);
    let start = axis_meeting(point, focus, gain, params);
    let room = select(params.limit_j - start, start, start < focus);
    return Line(start, room * (start - focus) / (focus * gain), axis_meeting(hull.cusp, focus, gain, params));
}

// M where the line start + slope * M meets the curve from the origin to `top`, approximately.
fn curve_meeting(start: f32, slope: f32, gamma_inv: f32, top: vec2f, reference: f32) -> f32 {
    let moved = reference * power(max(start / reference, 0.0), gamma_inv);
    return moved * top.y / (top.x - slope * top.y);
}

fn display_border(line: Line, hull: Hull, params: Aces2Output) -> f32 {
    let lower = curve_meeting(line.start, line.slope, params.lower_gamma_inv, hull.cusp, line.cusp);
    let above = vec2f(params.limit_j - hull.cusp.x, hull.cusp.y);
    let start = params.limit_j - line.start;
    let upper = curve_meeting(start, -line.slope, hull.upper_gamma_inv, above, params.limit_j - line.cusp);
    let width = 0.12 * hull.cusp.y;
    let h = max(width - abs(lower - upper), 0.0) / width;
    return min(lower, upper) - h * h * h * width / 6.0;
}

// M from the range up to `reach` in the range up to `border`.
fn remapped(m: f32, border: f32, reach: f32) -> f32 {
    let share = max(border / reach, 0.75);
    let threshold = share * border;
    if m <= threshold || share >= 1.0 { return m; }
    let source = reach - threshold;
    let scale = source / (source / (border - threshold) - 1.0);
    let over = (m - threshold) / scale;
    return threshold + scale * over / (1.0 + over);
}

// J and M in the gamut of the display.
fn compressed_gamut(point: vec2f, hull: Hull, params: Aces2Output) -> vec2f {
    if point.y <= 0.0 || point.x > params.limit_j { return vec2f(point.x, 0.0); }
    let line = line_through(point, hull, params);
    let border = display_border(line, hull, params);
    if border <= 0.0 { return vec2f(point.x, 0.0); }
    let top = vec2f(params.limit_j, hull.reach);
    let reach = curve_meeting(line.start, line.slope, 1.0 / params.exponent, top, params.limit_j);
    let m = remapped(point.y, border, reach);
    return vec2f(line.start + m * line.slope, m);
}

// The display's RGB of a lightness, an M and a hue.
fn displayed(point: vec2f, hue: vec2f, params: Aces2Output) -> vec3f {
    let a = power(0.01 * point.x, 1.0 / params.exponent);
    let cones = expand(rows(params.back0, params.back1, params.back2, vec3f(a, point.y * hue)));
    let rgb = rows(params.display0, params.display1, params.display2, cones);
    return clamp(rgb, vec3f(0.0), vec3f(params.top));
}

fn aces2_output(source: vec4f, hulls: texture_2d<f32>, params: Aces2Output) -> vec4f {
    let light = rows(params.enter0, params.enter1, params.enter2, source.rgb);
    let limited = clamp(light, vec3f(0.0), vec3f(params.brightest));
    let cones = compress(rows(params.cones0, params.cones1, params.cones2, limited));
    let response = rows(params.opponents0, params.opponents1, params.opponents2, cones);
    if response.x <= 1e-12 { return vec4f(0.0, 0.0, 0.0, source.a); }
    let m = length(response.yz);
    let hue = select(vec2f(1.0, 0.0), response.yz / max(m, 1e-20), m > 1e-20);
    let hull = hull_at(hulls, hue);
    let j = tone_scaled(response.x, params);
    let from_j = 100.0 * power(response.x, params.exponent);
    let chroma = compressed_chroma(from_j, j, m, hue, hull.reach, params);
    let rgb = displayed(compressed_gamut(vec2f(j, chroma), hull, params), hue, params);
    return vec4f(params.unit * rgb, source.a);
}
