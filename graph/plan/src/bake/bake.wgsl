// A baked LUT: the levels of the largest channel from left to right, and within each the ratio of the next
// channel to it, in every other one backward, so that a filter at the end of a level meets the same ratio of the next
// level; from top to bottom the largest channel, and within each the ratio of the one after that. Three parts
// for colors without a negative channel are above three for the others, which have more ratios and fewer levels: colors
// change faster beside the border of a gamut than along the light.
import afterimage::color::extended_light;
import afterimage::noise::{hash3, hash_cell};
import afterimage::sampling::tap;
import afterimage::trial::{light_is_tried, note_light};

struct Bake {
    levels: vec2f,  // steps between levels, of the upper and the lower three parts
    ratios: vec2f,  // steps between ratios
    rows: vec2f,    // the center of the first row of the parts
    negative: f32,  // steps of the lower three parts that are below 0
    lowest: f32,    // of a result
    texel: vec2f,   // the size of a texel as a share of the table
}

// The shaper of levels is m^p / (m^p + c^p). Levels are dense around the middle gray of exposed light and of a display,
// and become sparse where curves end, in the dark and toward the largest half float.
const BAKE_POWER: f32 = 0.6;
const BAKE_CENTER: f32 = 0.8;
// The shaper at 65504.
const BAKE_TOP: f32 = 0.998874;
// The lowest ratios of red, green and blue. Colors outside of the primaries have negative channels, and a luminance of
// 0 or more: that allows red and green no more, and blue twice as much, which only noise about yellow has.
const BAKE_LOWEST: vec3f = vec3f(-3.71, -0.4, -7.0);
// The share of the root in the place of a ratio; the rest is linear. The second is that of colors with a negative
// channel.
const BAKE_ROOT: f32 = 0.7;
const BAKE_ROOT_OUTSIDE: f32 = 0.9;

// The place of a level among those of the table. Light that is not positive is at 0.
fn bake_level(light: f32, levels: f32) -> f32 {
    let t = exp2(-BAKE_POWER * log2(max(light, 1e-20) / BAKE_CENTER));
    return select(0.0, min(levels / (BAKE_TOP * (1.0 + t)), levels), light > 0.0);
}

fn bake_light(level: f32, levels: f32) -> f32 {
    let x = level / levels * BAKE_TOP;
    if x <= 0.0 { return 0.0; }
    return BAKE_CENTER * exp2(log2(x / (1.0 - x)) / BAKE_POWER);
}

// How the ratios of a part of the table are divided: those of the next channel and of the last one.
struct BakeRatios {
    lowest: vec2f,
    below: f32,  // steps below 0
    above: f32,  // steps above 0
    root: f32,
}

fn bake_ratios(largest: i32, is_outside: bool, params: Bake) -> BakeRatios {
    let lowest = select(select(BAKE_LOWEST.yz, BAKE_LOWEST.zx, largest == 1), BAKE_LOWEST.xy, largest == 2);
    if is_outside { return BakeRatios(lowest, params.negative, params.ratios.y - params.negative, BAKE_ROOT_OUTSIDE); }
    return BakeRatios(lowest, 0.0, params.ratios.x, BAKE_ROOT);
}

// The places of ratios of 0 to 1 as shares of the steps.
fn bake_roots(ratios: vec2f, root: f32) -> vec2f {
    return root * sqrt(max(ratios, vec2f(0.0))) + (1.0 - root) * ratios;
}

fn bake_places(ratios: vec2f, axis: BakeRatios) -> vec2f {
    let are_below = ratios < vec2f(0.0);
    let sizes = min(ratios / select(vec2f(1.0), axis.lowest, are_below), vec2f(1.0));
    let steps = select(vec2f(axis.above), vec2f(-axis.below), are_below);
    return axis.below + steps * bake_roots(sizes, axis.root);
}

fn bake_at_places(places: vec2f, axis: BakeRatios) -> vec2f {
    let are_below = places < vec2f(axis.below);
    let shares = (places - axis.below) / select(vec2f(axis.above), vec2f(-axis.below), are_below);
    let half = 0.5 * axis.root / (1.0 - axis.root);
    let roots = sqrt(half * half + shares / (1.0 - axis.root)) - half;
    return select(vec2f(1.0), axis.lowest, are_below) * roots * roots;
}

// True if the ratios of a level go from right to left.
fn bake_is_backward(level: f32) -> bool {
    return fract(0.5 * level) > 0.25;
}

// The color of a texel of the table. A color with a luminance below 0 is none that a pixel can have: see
// `extended_light`.
fn bake_color(at: Point, params: Bake) -> vec4f {
    let is_outside = at.pixel.y >= i32(params.rows.y);
    let levels = select(params.levels.x, params.levels.y, is_outside);
    let ratios = select(params.ratios.x, params.ratios.y, is_outside);
    let count = i32(ratios) + 1;
    let pixel = at.pixel - vec2i(0, select(0, i32(params.rows.y), is_outside));
    let largest = pixel.y / count;
    let axis = bake_ratios(largest, is_outside, params);
    // Behind the last level lies a part of it again, which no filter may find to be other than finite.
    let level = min(f32(pixel.x / count), levels);
    let places = vec2f(pixel % vec2i(count));
    let light = bake_light(level, levels);
    let across = select(places.x, ratios - places.x, bake_is_backward(level));
    let others = light * bake_at_places(vec2f(across, places.y), axis);
    var rgb = vec3f(light, others);
    if largest == 1 { rgb = rgb.zxy; }
    if largest == 2 { rgb = rgb.yzx; }
    return vec4f(extended_light(rgb), 1.0);
}

fn bake_is_outside(lowest: f32) -> bool {
    if light_is_tried {
        note_light(lowest);
        return false;
    }
    return lowest < 0.0;
}

// The color that the table has for a color: between two levels, each filtered between four ratios. A ratio of 1 is the
// last one of its part, so that the filter takes nothing from the next part, and a gray lies between two grays.
fn bake(source: vec4f, table: texture_2d<f32>, linear: sampler, params: Bake) -> vec4f {
    let c = source.rgb;
    let is_green = c.g > c.r && c.g >= c.b;
    let is_blue = c.b > c.r && c.b > c.g;
    let light = max(c.r, max(c.g, c.b));
    let others = select(select(c.gb, c.br, is_green), c.rg, is_blue);
    let largest = select(select(0, 1, is_green), 2, is_blue);
    let ratios = min(others / max(light, 1e-20), vec2f(1.0));
    let is_outside = bake_is_outside(min(ratios.x, ratios.y));
    let levels = select(params.levels.x, params.levels.y, is_outside);
    let steps = select(params.ratios.x, params.ratios.y, is_outside);
    let level = bake_level(light, levels);

    let count = steps + 1.0;
    let lower = min(floor(level), levels - 1.0);
    let share = level - lower;
    // Few pixels have a negative channel.
    var place = steps * bake_roots(ratios, BAKE_ROOT);
    if is_outside { place = bake_places(ratios, bake_ratios(largest, true, params)); }
    let back = steps - place.x;
    let across = select(vec2f(place.x, back), vec2f(back, place.x), bake_is_backward(lower));
    let x = (across + count * vec2f(lower, lower + 1.0) + 0.5) * params.texel.x;
    let y = (place.y + count * f32(largest) + select(params.rows.x, params.rows.y, is_outside)) * params.texel.y;
    let low = tap(table, linear, vec2f(x.x, y)).rgb;
    let high = tap(table, linear, vec2f(x.y, y)).rgb;
    let shown = (1.0 - share) * low + share * high;
    return vec4f(max(shown, vec3f(params.lowest)), source.a);
}

// The rows of random colors, and the grays below them.
const BAKE_RANDOM_ROWS: i32 = 1024;
const BAKE_GRAYS: f32 = 65536.0;

// Display P3, Rec.2020 and AP1 in the basis of Rec.709.
const BAKE_P3: mat3x3f = mat3x3f(1.224940, -0.042057, -0.019638, -0.224940, 1.042057, -0.078636, 0.0, 0.0, 1.098274);
const BAKE_REC2020: mat3x3f =
    mat3x3f(1.660491, -0.124550, -0.018151, -0.587641, 1.132900, -0.100579, -0.072850, -0.008349, 1.118730);
const BAKE_AP1: mat3x3f =
    mat3x3f(1.705051, -0.130256, -0.024003, -0.621792, 1.140805, -0.128969, -0.083259, -0.010548, 1.152972);

// A random color for each pixel, of all levels of light from 2^-10 to 2^`top` and of all saturations; below them grays
// from 2^-14.
fn bake_random(at: Point, top: f32) -> vec4f {
    if at.pixel.y >= BAKE_RANDOM_ROWS {
        let gray = f32((at.pixel.y - BAKE_RANDOM_ROWS) * 1024 + at.pixel.x);
        return vec4f(vec3f(exp2(mix(-14.0, top, gray / BAKE_GRAYS))), 1.0);
    }
    let numbers = vec3f(hash3(vec3u(vec2u(at.pixel), 1u)) >> vec3u(8u)) / 16777216.0;
    return vec4f(exp2(mix(-10.0, top, hash_cell(at.pixel))) * numbers, 1.0);
}

// The light of an exposed scene, a quarter of the rows each in Rec.709, Display P3, Rec.2020 and AP1; and that of a
// display.
fn bake_random_exposed(at: Point) -> vec4f {
    let color = bake_random(at, 8.0);
    var rgb = color.rgb;
    switch 4 * at.pixel.y / BAKE_RANDOM_ROWS {
        case 1: { rgb = BAKE_P3 * rgb; }
        case 2: { rgb = BAKE_REC2020 * rgb; }
        case 3: { rgb = BAKE_AP1 * rgb; }
        default: {}
    }
    return vec4f(rgb, 1.0);
}

fn bake_random_display(at: Point) -> vec4f {
    return bake_random(at, 0.0);
}

// The largest difference of the channels, and both greens.
fn bake_error(exact: vec4f, shown: vec4f) -> vec4f {
    let error = abs(exact.rgb - shown.rgb);
    return vec4f(max(error.r, max(error.g, error.b)), exact.g, shown.g, 1.0);
}
