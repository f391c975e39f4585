struct VariableBlur { sigma: f32 }

// The weights of the spline, from its middle. Its variance is 1.
const VARIABLE_BLUR_SPLINE: array<f32, 3> = array(0.375, 0.25, 0.0625);

// The share of a pass at a pixel: splines 1, 2, ... `step / 2` apart have made (step^2 - 1) / 3 of the variance, and
// this one makes up to step^2.
fn variable_blur_share(mask: texture_2d<f32>, pixel: vec2i, step: i32, height: f32, params: VariableBlur) -> f32 {
    let sigma = params.sigma * height * clamp(texel(mask, pixel).r, 0.0, 1.0);
    let square = f32(step * step);
    return clamp((sigma * sigma - (square - 1.0) / 3.0) / square, 0.0, 1.0);
}

// A place that the border mirrors into the image, however far outside it is.
fn variable_blur_mirrored(pixel: vec2i, size: vec2i) -> vec2i {
    let twice = 2 * size;
    let within = (pixel % twice + twice) % twice;
    return min(within, twice - 1 - within);
}

// A pass: each pair of pixels exchanges light, so what one gets the other gives, also with mirror images.
fn variable_blur_pass(
    source: texture_2d<f32>,
    mask: texture_2d<f32>,
    at: Point,
    step: i32,
    params: VariableBlur,
) -> vec4f {
    let own = texel(source, at.pixel);
    let own_share = variable_blur_share(mask, at.pixel, step, at.size.y, params);
    if own_share <= 0.0 { return own; }
    var change = vec4f();
    for (var y = -2; y <= 2; y++) {
        for (var x = -2; x <= 2; x++) {
            let pixel = variable_blur_mirrored(at.pixel + step * vec2i(x, y), vec2i(at.size));
            let share = min(own_share, variable_blur_share(mask, pixel, step, at.size.y, params));
            let spline = VARIABLE_BLUR_SPLINE[abs(x)] * VARIABLE_BLUR_SPLINE[abs(y)];
            change += spline * share * (texel(source, pixel) - own);
        }
    }
    return own + change;
}

fn variable_blur_by_1(source: texture_2d<f32>, mask: texture_2d<f32>, at: Point, params: VariableBlur) -> vec4f {
    return variable_blur_pass(source, mask, at, 1, params);
}

fn variable_blur_by_2(by_1: texture_2d<f32>, mask: texture_2d<f32>, at: Point, params: VariableBlur) -> vec4f {
    return variable_blur_pass(by_1, mask, at, 2, params);
}

fn variable_blur_by_4(by_2: texture_2d<f32>, mask: texture_2d<f32>, at: Point, params: VariableBlur) -> vec4f {
    return variable_blur_pass(by_2, mask, at, 4, params);
}

fn variable_blur_by_8(by_4: texture_2d<f32>, mask: texture_2d<f32>, at: Point, params: VariableBlur) -> vec4f {
    return variable_blur_pass(by_4, mask, at, 8, params);
}

fn variable_blur_by_16(by_8: texture_2d<f32>, mask: texture_2d<f32>, at: Point, params: VariableBlur) -> vec4f {
    return variable_blur_pass(by_8, mask, at, 16, params);
}

fn variable_blur_by_32(by_16: texture_2d<f32>, mask: texture_2d<f32>, at: Point, params: VariableBlur) -> vec4f {
    return variable_blur_pass(by_16, mask, at, 32, params);
}

fn variable_blur_by_64(by_32: texture_2d<f32>, mask: texture_2d<f32>, at: Point, params: VariableBlur) -> vec4f {
    return variable_blur_pass(by_32, mask, at, 64, params);
}

fn variable_blur_by_128(by_64: texture_2d<f32>, mask: texture_2d<f32>, at: Point, params: VariableBlur) -> vec4f {
    return variable_blur_pass(by_64, mask, at, 128, params);
}

fn variable_blur(by_128: texture_2d<f32>, mask: texture_2d<f32>, at: Point, params: VariableBlur) -> vec4f {
    return variable_blur_pass(by_128, mask, at, 256, params);
}
