// A table of colors: the levels of the largest channel from left to right, and within each the ratio of the next
// channel to it; from top to bottom the largest channel, and within each the ratio of the one after that. Three parts
// for colors without a negative channel are above three for the others.
#import color

struct Bake {
    levels: f32,    // steps between levels
    ratios: f32,    // steps between ratios
    negative: f32,  // those of the lower three parts that are below 0
    grays: f32,     // steps of the curve of grays in one step of levels
    lowest: f32,    // of a result
}

// The shaper of levels is m^p / (m^p + c^p). Levels are dense around the middle gray of exposed light and of a display,
// and become sparse where curves end, in the dark and toward the largest half float.
const BAKE_POWER: f32 = 0.6;
const BAKE_CENTER: f32 = 0.8;
// The shaper at 65504.
const BAKE_TOP: f32 = 0.998874;
// The lowest ratios of red, green and blue. Colors outside of the primaries have negative channels, and a luminance of
// 0 or more: little green can be missing.
const BAKE_LOWEST: vec3f = vec3f(-2.0, -0.4, -3.0);
// The share of the root in the place of a ratio; the rest is linear. The second is that of colors with a negative
// channel.
const BAKE_ROOT: f32 = 0.7;
const BAKE_ROOT_OUTSIDE: f32 = 0.9;

// The place of a level among those of the table. Light that is not positive is at 0.
fn bake_level(light: f32, params: Bake) -> f32 {
    let t = exp2(-BAKE_POWER * log2(max(light, 1e-20) / BAKE_CENTER));
    return select(0.0, min(params.levels / (BAKE_TOP * (1.0 + t)), params.levels), light > 0.0);
}

fn bake_light(level: f32, params: Bake) -> f32 {
    let x = level / params.levels * BAKE_TOP;
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
    if is_outside { return BakeRatios(lowest, params.negative, params.ratios - params.negative, BAKE_ROOT_OUTSIDE); }
    return BakeRatios(lowest, 0.0, params.ratios, BAKE_ROOT);
}

fn bake_places(ratios: vec2f, axis: BakeRatios) -> vec2f {
    let are_below = ratios < vec2f(0.0);
    let sizes = ratios / select(vec2f(1.0), axis.lowest, are_below);
    let steps = select(vec2f(axis.above), vec2f(-axis.below), are_below);
    return axis.below + steps * (axis.root * sqrt(sizes) + (1.0 - axis.root) * sizes);
}

fn bake_at_places(places: vec2f, axis: BakeRatios) -> vec2f {
    let are_below = places < vec2f(axis.below);
    let shares = (places - axis.below) / select(vec2f(axis.above), vec2f(-axis.below), are_below);
    let half = 0.5 * axis.root / (1.0 - axis.root);
    let roots = sqrt(half * half + shares / (1.0 - axis.root)) - half;
    return select(vec2f(1.0), axis.lowest, are_below) * roots * roots;
}

// The color of a texel of the table. A color with a luminance below 0 is none that a pixel can have: see
// `extended_light`.
fn bake_color(at: Point, params: Bake) -> vec4f {
    let count = i32(params.ratios) + 1;
    let largest = (at.pixel.y / count) % 3;
    let axis = bake_ratios(largest, at.pixel.y >= 3 * count, params);
    let places = vec2f(at.pixel % vec2i(count));
    let light = bake_light(f32(at.pixel.x / count), params);
    let others = light * bake_at_places(places, axis);
    var rgb = vec3f(light, others);
    if largest == 1 { rgb = rgb.zxy; }
    if largest == 2 { rgb = rgb.yzx; }
    return vec4f(extended_light(rgb), 1.0);
}

// The gray of a texel of the curve of grays.
fn bake_gray(at: Point, params: Bake) -> vec4f {
    return vec4f(vec3f(bake_light(f32(at.pixel.x) / params.grays, params)), 1.0);
}

// What the table lacks of a gray.
fn bake_rest(made: vec4f, table: texture_2d<f32>, at: Point, params: Bake) -> vec4f {
    let ratios = i32(params.ratios) + 1;
    let level = f32(at.pixel.x) / params.grays;
    let first = clamp(i32(level), 0, i32(params.levels) - 1);
    let gray = vec2i(first * ratios + ratios - 1, ratios - 1);
    let share = level - f32(first);
    let shown = (1.0 - share) * textureLoad(table, gray, 0) + share * textureLoad(table, gray + vec2i(ratios, 0), 0);
    return vec4f(made.rgb - shown.rgb, 1.0);
}

// The color that the table has for a color: in the tetrahedron around it, and closer to gray with more of the curve of
// grays, which for a gray makes it exact.
fn bake(source: vec4f, table: texture_2d<f32>, grays: texture_2d<f32>, params: Bake) -> vec4f {
    let c = source.rgb;
    let is_green = c.g > c.r && c.g >= c.b;
    let is_blue = c.b > c.r && c.b > c.g;
    let light = max(c.r, max(c.g, c.b));
    let others = select(select(c.gb, c.br, is_green), c.rg, is_blue);
    let largest = select(select(0, 1, is_green), 2, is_blue);
    let of_light = others / max(light, 1e-20);
    let is_outside = min(of_light.x, of_light.y) < 0.0;
    let axis = bake_ratios(largest, is_outside, params);
    let ratios = clamp(of_light, axis.lowest, vec2f(1.0));
    let level = bake_level(light, params);

    // Steps along the level, the next channel and the last one.
    let count = i32(params.ratios) + 1;
    let place = vec3f(level, bake_places(ratios, axis));
    let base = clamp(vec3i(place), vec3i(0), vec3i(i32(params.levels), count - 1, count - 1) - 1);
    let f = clamp(place - vec3f(base), vec3f(0.0), vec3f(1.0));
    let part = largest + select(0, 3, is_outside);
    let corner = vec2i(base.x * count + base.y, part * count + base.z);
    let x_leads = f.x >= f.y && f.x >= f.z;
    let y_leads = !x_leads && f.y >= f.z;
    let x_trails = !x_leads && f.x < f.y && f.x < f.z;
    let y_trails = !x_trails && !y_leads && f.y < f.z;
    let first = select(select(vec2i(0, 1), vec2i(1, 0), y_leads), vec2i(count, 0), x_leads);
    let trailing = select(select(vec2i(0, 1), vec2i(1, 0), y_trails), vec2i(count, 0), x_trails);
    let most = max(f.x, max(f.y, f.z));
    let least = min(f.x, min(f.y, f.z));
    let middle = max(min(f.x, f.y), min(max(f.x, f.y), f.z));
    let all = vec2i(count + 1, 1);
    let shown = (1.0 - most) * textureLoad(table, corner, 0).rgb
        + (most - middle) * textureLoad(table, corner + first, 0).rgb
        + (middle - least) * textureLoad(table, corner + all - trailing, 0).rgb
        + least * textureLoad(table, corner + all, 0).rgb;

    let fine = level * params.grays;
    let gray = clamp(i32(fine), 0, i32(params.levels * params.grays) - 1);
    let share = clamp(fine - f32(gray), 0.0, 1.0);
    let rest = (1.0 - share) * textureLoad(grays, vec2i(gray, 0), 0).rgb
        + share * textureLoad(grays, vec2i(gray + 1, 0), 0).rgb;
    let grayness = sqrt(max(min(ratios.x, ratios.y), 0.0));
    return vec4f(max(shown + grayness * rest, vec3f(params.lowest)), source.a);
}
