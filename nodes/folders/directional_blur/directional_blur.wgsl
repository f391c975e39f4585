struct DirectionalBlur { length: f32, angle: f32 }

// Reads of a pass, and of all passes.
const DIRECTIONAL_BLUR_READS: i32 = 10;
const DIRECTIONAL_BLUR_SAMPLES: f32 = 1000.0;

// The mean of reads around a pixel that are so many samples apart. The mean of such means is that of all samples.
fn directional_blur_along(
    t: texture_2d<f32>,
    s: sampler,
    at: Point,
    step: f32,
    params: DirectionalBlur,
) -> vec4f {
    if params.length == 0.0 { return texel(t, at.pixel); }
    let angle = radians(params.angle);
    let line = params.length * at.size.y * vec2f(cos(angle), sin(angle)) / at.size;
    var sum = vec4f();
    for (var read = 0; read < DIRECTIONAL_BLUR_READS; read++) {
        let away = f32(read) - 0.5 * f32(DIRECTIONAL_BLUR_READS - 1);
        sum += tap(t, s, at.uv + away * step / DIRECTIONAL_BLUR_SAMPLES * line);
    }
    return sum / f32(DIRECTIONAL_BLUR_READS);
}

fn directional_blur_near(
    source: texture_2d<f32>,
    source_sampler: sampler,
    at: Point,
    params: DirectionalBlur,
) -> vec4f {
    return directional_blur_along(source, source_sampler, at, 1.0, params);
}

fn directional_blur_middle(
    near: texture_2d<f32>,
    near_sampler: sampler,
    at: Point,
    params: DirectionalBlur,
) -> vec4f {
    return directional_blur_along(near, near_sampler, at, 10.0, params);
}

fn directional_blur(
    middle: texture_2d<f32>,
    middle_sampler: sampler,
    at: Point,
    params: DirectionalBlur,
) -> vec4f {
    return directional_blur_along(middle, middle_sampler, at, 100.0, params);
}
