#import color
#import math

struct OrderedDither {
    levels: i32,
    dot: i32,
    pattern: f32,
    gray: u32,
    amount: f32,
}

// The place of a dot of the matrix among its 64, from 0: the bits of y and of x xor y, interleaved, the lowest first.
fn ordered_dither_rank(cell: vec2u) -> u32 {
    let mixed = cell.x ^ cell.y;
    var rank = 0u;
    for (var bit = 0u; bit < 3u; bit++) {
        let pair = 2u * ((mixed >> bit) & 1u) + ((cell.y >> bit) & 1u);
        rank = (rank << 2u) | pair;
    }
    return rank;
}

fn ordered_dither(source: vec4f, at: Point, params: OrderedDither) -> vec4f {
    let cell = vec2u(at.pixel / params.dot) % 8u;
    let threshold = (f32(ordered_dither_rank(cell)) + 0.5) / 64.0 - 0.5;
    let color = select(source.rgb, vec3f(luminance(source.rgb)), params.gray != 0u);
    let steps = f32(params.levels - 1);
    let level = floor(clamp(color, vec3f(0.0), vec3f(1.0)) * steps + 0.5 + params.pattern * threshold);
    return vec4f(between3(source.rgb, level / steps, params.amount), source.a);
}
