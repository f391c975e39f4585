// A blur that stops at the edges of surfaces: a Gaussian along one axis and then along the other, whose weights are
// less for what lies off the plane of the pixel's own surface, or faces another way.
import afterimage::depth::{depth_inverse, depth_likeness, depth_slope};

struct BilateralBlur {
    depth_threshold: f32,
    normal_threshold: f32,
    radius: i32,
    axis: vec2f,
    sharpness: f32,  // of the Gaussian: 1 / (2 sigma^2)
}

fn bilateral_blur_weight(depth: texture_2d<f32>, p: vec2i, i: i32, slope: f32, params: BilateralBlur) -> f32 {
    let step = vec2i(params.axis);
    let middle = depth_inverse(depth, p);
    let expected = middle + slope * f32(i);
    let like = depth_likeness(expected, depth_inverse(depth, p + i * step), middle, params.depth_threshold);
    return like * exp(-params.sharpness * f32(i * i));
}

// True if the image has a texel there: the texels at the border count once.
fn bilateral_blur_inside(source: texture_2d<f32>, p: vec2i) -> bool {
    return all(p >= vec2i(0)) && all(p < vec2i(textureDimensions(source)));
}

fn bilateral_blur(source: texture_2d<f32>, depth: texture_2d<f32>, at: Point, params: BilateralBlur) -> vec4f {
    let step = vec2i(params.axis);
    let slope = depth_slope(depth, at.pixel, step);
    var sum = texel(source, at.pixel);
    var total = 1.0;
    let radius = min(params.radius, 32);
    for (var i = -radius; i <= radius; i++) {
        let place = at.pixel + i * step;
        if i == 0 || !bilateral_blur_inside(source, place) { continue; }
        let weight = bilateral_blur_weight(depth, at.pixel, i, slope, params);
        sum += weight * texel(source, place);
        total += weight;
    }
    return clamp(sum / total, vec4f(-HALF_MAX), vec4f(HALF_MAX));
}

// A unit vector, or the zero vector.
fn bilateral_blur_unit(v: vec3f) -> vec3f {
    return v / max(length(v), 1e-3);
}

// 1 for equal normals, falling to 0 where the cosine between them is 1 minus the threshold.
fn bilateral_blur_facing(normal: texture_2d<f32>, own: vec3f, p: vec2i, params: BilateralBlur) -> f32 {
    let cosine = dot(own, bilateral_blur_unit(texel(normal, p).xyz));
    return clamp(1.0 - (1.0 - cosine) / params.normal_threshold, 0.0, 1.0);
}

fn bilateral_blur_normals(
    source: texture_2d<f32>,
    depth: texture_2d<f32>,
    normal: texture_2d<f32>,
    at: Point,
    params: BilateralBlur,
) -> vec4f {
    let step = vec2i(params.axis);
    let slope = depth_slope(depth, at.pixel, step);
    let own = bilateral_blur_unit(texel(normal, at.pixel).xyz);
    var sum = texel(source, at.pixel);
    var total = 1.0;
    let radius = min(params.radius, 32);
    for (var i = -radius; i <= radius; i++) {
        let place = at.pixel + i * step;
        if i == 0 || !bilateral_blur_inside(source, place) { continue; }
        let facing = bilateral_blur_facing(normal, own, place, params);
        let weight = facing * bilateral_blur_weight(depth, at.pixel, i, slope, params);
        sum += weight * texel(source, place);
        total += weight;
    }
    return clamp(sum / total, vec4f(-HALF_MAX), vec4f(HALF_MAX));
}
