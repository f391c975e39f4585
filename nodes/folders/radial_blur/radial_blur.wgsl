struct RadialBlur {
    center: vec2f,
    zoom: f32,
    spin: f32,
}

// Reads of a pass, and of all passes.
const RADIAL_BLUR_READS: i32 = 10;
const RADIAL_BLUR_SAMPLES: f32 = 1000.0;

// The mean of reads around a pixel that are so many samples apart. Samples in a row multiply growths and add turns, so
// the mean of such means is that of all samples.
fn radial_blur_along(t: texture_2d<f32>, s: sampler, at: Point, step: f32, params: RadialBlur) -> vec4f {
    if params.zoom == 0.0 && params.spin == 0.0 { return texel(t, at.pixel); }
    let center = params.center * at.size;
    let from_center = vec2f(at.pixel) + 0.5 - center;
    let growth = log2(1.0 + params.zoom) * step / RADIAL_BLUR_SAMPLES;
    let turn = radians(params.spin) * step / RADIAL_BLUR_SAMPLES;
    var sum = vec4f();
    for (var read = 0; read < RADIAL_BLUR_READS; read++) {
        let away = f32(read) - 0.5 * f32(RADIAL_BLUR_READS - 1);
        let scale = exp2(away * growth);
        let axis = scale * vec2f(cos(away * turn), sin(away * turn));
        let place = vec2f(
            axis.x * from_center.x - axis.y * from_center.y,
            axis.y * from_center.x + axis.x * from_center.y,
        );
        sum += tap(t, s, (center + place) / at.size);
    }
    return sum / f32(RADIAL_BLUR_READS);
}

fn radial_blur_near(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: RadialBlur) -> vec4f {
    return radial_blur_along(source, source_sampler, at, 1.0, params);
}

fn radial_blur_middle(near: texture_2d<f32>, near_sampler: sampler, at: Point, params: RadialBlur) -> vec4f {
    return radial_blur_along(near, near_sampler, at, 10.0, params);
}

fn radial_blur(middle: texture_2d<f32>, middle_sampler: sampler, at: Point, params: RadialBlur) -> vec4f {
    return radial_blur_along(middle, middle_sampler, at, 100.0, params);
}
