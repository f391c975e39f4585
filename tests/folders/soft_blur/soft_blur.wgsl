import package::lib::gauss::gauss_along;

struct SoftBlur { sigma: f32 }

fn soft_blur_across(source: texture_2d<f32>, at: Point, params: SoftBlur) -> vec4f {
    return gauss_along(source, at.pixel, vec2i(1, 0), params.sigma);
}

fn soft_blur(across: texture_2d<f32>, at: Point, params: SoftBlur) -> vec4f {
    return gauss_along(across, at.pixel, vec2i(0, 1), params.sigma);
}
