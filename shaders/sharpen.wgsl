// An unsharp mask whose result stays near the values around each pixel, so that edges get no halos.
import afterimage::grade::bounded_scene;

struct Sharpen {
    amount: f32,
    threshold: f32,
    halo: f32,
    ceiling: f32,  // the largest number that the result may have where its surroundings are below
}

// The limits of the square around a pixel.
struct SharpenRange {
    low: vec3f,
    high: vec3f,
}

fn sharpen_range(source: texture_2d<f32>, p: vec2i, center: vec3f) -> SharpenRange {
    var range = SharpenRange(center, center);
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let color = texel(source, p + vec2i(x, y)).rgb;
            range.low = min(range.low, color);
            range.high = max(range.high, color);
        }
    }
    return range;
}

fn sharpen(source: texture_2d<f32>, blurred: vec4f, at: Point, params: Sharpen) -> vec4f {
    let center = texel(source, at.pixel);
    let detail = center.rgb - blurred.rgb;
    let strong = sign(detail) * max(abs(detail) - params.threshold, vec3f(0.0));
    let range = sharpen_range(source, at.pixel, center.rgb);
    let slack = params.halo * (range.high - range.low);
    let low = max(range.low - slack, min(range.low, vec3f(0.0)));
    let high = min(range.high + slack, max(range.high, vec3f(params.ceiling)));
    return vec4f(bounded_scene(clamp(center.rgb + params.amount * strong, low, high)), center.a);
}
