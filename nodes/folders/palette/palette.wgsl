import package::lib::bayer::bayer_threshold;
import afterimage::math::between3;

struct Palette {
    colors: i32,
    dot: i32,
    mixing: f32,
    amount: f32,
    color_1: vec3f,
    color_2: vec3f,
    color_3: vec3f,
    color_4: vec3f,
    color_5: vec3f,
    color_6: vec3f,
    color_7: vec3f,
    color_8: vec3f,
    color_9: vec3f,
    color_10: vec3f,
    color_11: vec3f,
    color_12: vec3f,
    color_13: vec3f,
    color_14: vec3f,
    color_15: vec3f,
    color_16: vec3f,
}

// Weights of the channels in squared distances.
const PALETTE_WEIGHTS: vec3f = vec3f(0.299, 0.587, 0.114);

fn palette(source: vec4f, at: Point, params: Palette) -> vec4f {
    // A variable: of a value, each index would copy all of it.
    var colors = array<vec3f, 16>(
        params.color_1,
        params.color_2,
        params.color_3,
        params.color_4,
        params.color_5,
        params.color_6,
        params.color_7,
        params.color_8,
        params.color_9,
        params.color_10,
        params.color_11,
        params.color_12,
        params.color_13,
        params.color_14,
        params.color_15,
        params.color_16,
    );
    let color = clamp(source.rgb, vec3f(0.0), vec3f(1.0));
    var best = 1e9;
    var first = vec3f();
    var second = vec3f();
    var share = 0.0;
    for (var i = 0; i < params.colors; i++) {
        let one = colors[i];
        for (var j = i; j < params.colors; j++) {
            let way = colors[j] - one;
            let length = dot(way * way, PALETTE_WEIGHTS);
            let part = clamp(dot(way * (color - one), PALETTE_WEIGHTS) / max(length, 1e-9), 0.0, 1.0);
            let rest = color - one - part * way;
            // Dots in equal numbers stand out most.
            let error = dot(rest * rest, PALETTE_WEIGHTS) + params.mixing * length * part * (1.0 - part);
            if error < best {
                best = error;
                first = one;
                second = colors[j];
                share = part;
            }
        }
    }
    let dots = select(first, second, share > bayer_threshold(at.pixel / params.dot));
    return vec4f(between3(source.rgb, dots, params.amount), source.a);
}
