struct Pixelate { side: f32 }

// The mean of 8x8 reads at equal distances in a large pixel. Those at the right and lower border may be narrower.
const READS: i32 = 8;

fn pixelate(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Pixelate) -> vec4f {
    if params.side == 1.0 { return texel(source, at.pixel); }
    let first = floor((vec2f(at.pixel) + 0.5) / params.side) * params.side;
    let last = min(first + params.side, at.size);
    var sum = vec4f();
    for (var y = 0; y < READS; y++) {
        for (var x = 0; x < READS; x++) {
            let place = mix(first, last, (vec2f(f32(x), f32(y)) + 0.5) / f32(READS));
            sum += tap(source, source_sampler, place / at.size);
        }
    }
    return sum / f32(READS * READS);
}
