// A table of colors: the levels of the largest channel from left to right, and within each the ratio of the next
// channel to it; from top to bottom the largest channel, and within each the ratio of the one after that.

struct Bake {
    levels: f32,    // steps between levels
    positive: f32,  // steps between ratios from 0 to 1
    negative: f32,  // steps between ratios from BAKE_LOWEST to 0
    grays: f32,     // steps of the curve of grays in one step of levels
    lowest: f32,    // of a result
}

// The shaper of levels is m^p / (m^p + c^p). Levels are dense around the middle gray of exposed light and of a display,
// and become sparse where curves end, in the dark and toward the largest half float.
const BAKE_POWER: f32 = 0.4;
const BAKE_CENTER: f32 = 0.3;
// The shaper at 65504.
const BAKE_TOP: f32 = 0.992736;
// The lowest ratio. Colors outside of the primaries have negative channels.
const BAKE_LOWEST: f32 = -4.0;

// The place of a level among those of the table. Light that is not positive is at 0.
fn bake_level(light: f32, params: Bake) -> f32 {
    let t = exp2(-BAKE_POWER * log2(max(light, 1e-20) / BAKE_CENTER));
    return clamp(params.levels / (BAKE_TOP * (1.0 + t)), 0.0, params.levels);
}

fn bake_light(level: f32, params: Bake) -> f32 {
    let x = level / params.levels * BAKE_TOP;
    if x <= 0.0 { return 0.0; }
    return BAKE_CENTER * exp2(log2(x / (1.0 - x)) / BAKE_POWER);
}

// Ratios are at the places of their roots.
fn bake_ratio(index: f32, params: Bake) -> f32 {
    let is_negative = index < params.negative;
    let root = (index - params.negative) / select(params.positive, params.negative, is_negative);
    return select(1.0, BAKE_LOWEST, is_negative) * root * root;
}

// The color of a texel of the table.
fn bake_color(at: Point, params: Bake) -> vec4f {
    let ratios = i32(params.positive + params.negative) + 1;
    let light = bake_light(f32(at.pixel.x / ratios), params);
    let next = light * bake_ratio(f32(at.pixel.x % ratios), params);
    let last = light * bake_ratio(f32(at.pixel.y % ratios), params);
    let part = at.pixel.y / ratios;
    if part == 0 { return vec4f(light, next, last, 1.0); }
    if part == 1 { return vec4f(last, light, next, 1.0); }
    return vec4f(next, last, light, 1.0);
}

// The gray of a texel of the curve of grays.
fn bake_gray(at: Point, params: Bake) -> vec4f {
    return vec4f(vec3f(bake_light(f32(at.pixel.x) / params.grays, params)), 1.0);
}

// What the table lacks of a gray.
fn bake_rest(made: vec4f, table: texture_2d<f32>, at: Point, params: Bake) -> vec4f {
    let ratios = i32(params.positive + params.negative) + 1;
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
    let ratios = clamp(others / max(light, 1e-20), vec2f(BAKE_LOWEST), vec2f(1.0));
    let are_negative = ratios < vec2f(0.0);
    let roots = sqrt(ratios * select(vec2f(1.0), vec2f(1.0 / BAKE_LOWEST), are_negative))
        * select(vec2f(params.positive), vec2f(-params.negative), are_negative);
    let level = bake_level(light, params);

    // Steps along the level, the next channel and the last one.
    let count = i32(params.positive + params.negative) + 1;
    let place = vec3f(level, roots + params.negative);
    let base = clamp(vec3i(place), vec3i(0), vec3i(i32(params.levels), count - 1, count - 1) - 1);
    let f = clamp(place - vec3f(base), vec3f(0.0), vec3f(1.0));
    let part = select(select(0, 1, is_green), 2, is_blue);
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
    let grayness = clamp(min(roots.x, roots.y) / params.positive, 0.0, 1.0);
    return vec4f(max(shown + grayness * rest, vec3f(params.lowest)), source.a);
}
