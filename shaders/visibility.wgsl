// Shading by the visibility of each pixel, which is in x, with the inverse of the distance in y: means on a
// surface, a larger image, and the light that is left.
import afterimage::depth::{depth_inverse, depth_likeness};
import afterimage::grade::bounded_scene;
import afterimage::math::power;

struct Visibility {
    amount: f32,
    power: f32,
}

struct VisibilityMean {
    axis: vec2f,
}

struct VisibilityScale {
    stride: f32,       // pixels of the depth image from one texel to the next
}

// The distance off a plane, as a share of the depth, beyond which visibilities are not mixed.
const VISIBILITY_SOFT: f32 = 0.02;

// The slope of the inverse distances, which the y of visibilities holds: as in `depth_slope`.
fn visibility_slope(noisy: texture_2d<f32>, p: vec2i, step: vec2i) -> f32 {
    let middle = texel(noisy, p).y;
    let after = texel(noisy, p + step).y - middle;
    let before = middle - texel(noisy, p - step).y;
    let has_after = all(p + step < vec2i(textureDimensions(noisy)));
    let has_before = all(p >= step);
    return select(before, after, has_after && (!has_before || abs(after) < abs(before)));
}

// A mean over four texels of an axis on the pixel's own surface. All sixteen directions have the same weight in two of
// these passes.
fn visibility_denoise(noisy: texture_2d<f32>, at: Point, params: VisibilityMean) -> vec4f {
    let step = vec2i(params.axis);
    let slope = visibility_slope(noisy, at.pixel, step);
    let own = texel(noisy, at.pixel);
    var sum = vec2f(own.x, 1.0);
    for (var i = -2; i <= 2; i++) {
        let place = at.pixel + i * step;
        let is_inside = all(place >= vec2i(0)) && all(place < vec2i(textureDimensions(noisy)));
        if i == 0 || !is_inside { continue; }
        let other = texel(noisy, place);
        let like = depth_likeness(own.y + slope * f32(i), other.y, max(own.y, 1e-6), VISIBILITY_SOFT);
        let weight = like * select(1.0, 0.5, abs(i) == 2);
        sum += weight * vec2f(other.x, 1.0);
    }
    return vec4f(sum.x / sum.y, own.y, 0.0, 1.0);
}

// From half of the size to the whole: the nearest four, weighted by how well their depths fit. Where none fits, the one
// that fits best counts most.
fn visibility_enlarge(small: texture_2d<f32>, depth: texture_2d<f32>, at: Point, params: VisibilityScale) -> vec4f {
    let inverse = depth_inverse(depth, at.pixel);
    // The texel with index i shows the pixel 2 i + 1.
    let place = (vec2f(at.pixel) - floor(0.5 * params.stride)) / params.stride;
    let base = floor(place);
    let part = place - base;
    var sum = vec2f();
    for (var i = 0; i < 4; i++) {
        let corner = vec2i(i & 1, i >> 1);
        let share = select(1.0 - part, part, corner == vec2i(1));
        let other = texel(small, vec2i(base) + corner);
        let off = abs(other.y - inverse) / (VISIBILITY_SOFT * inverse);
        let weight = (share.x * share.y + 1e-3) / (1e-3 + off * off);
        sum += weight * vec2f(other.x, 1.0);
    }
    return vec4f(sum.x / sum.y, inverse, 0.0, 1.0);
}

// The visibility that is shown.
fn visibility_shown(visibility: vec4f, params: Visibility) -> f32 {
    return 1.0 - params.amount * (1.0 - power(visibility.x, params.power));
}

fn visibility_lit(source: vec4f, visibility: vec4f, params: Visibility) -> vec4f {
    return vec4f(bounded_scene(source.rgb * visibility_shown(visibility, params)), source.a);
}

// Light that bounces between surfaces of this albedo: a fit of Jimenez and others, 2016.
fn visibility_lit_albedo(source: vec4f, visibility: vec4f, albedo: vec4f, params: Visibility) -> vec4f {
    let color = clamp(albedo.rgb, vec3f(0.0), vec3f(1.0));
    let v = visibility_shown(visibility, params);
    let a = 2.0404 * color - 0.3324;
    let b = -4.7951 * color + 0.6417;
    let c = 2.7552 * color + 0.6903;
    let bounced = max(vec3f(v), ((v * a + b) * v + c) * v);
    return vec4f(bounded_scene(source.rgb * min(bounced, vec3f(1.0))), source.a);
}

fn visibility_occlusion(visibility: vec4f, params: Visibility) -> vec4f {
    return vec4f(1.0 - visibility_shown(visibility, params), 0.0, 0.0, 0.0);
}
