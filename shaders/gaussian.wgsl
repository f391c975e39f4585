// Blurs along one axis; two passes, one per axis, blur along both. Reads beyond the border return the border.
import afterimage::tent::tap_tent;

struct Gaussian {
    axis: vec2i,
    radius: i32,   // taps to each side
    falloff: f32,  // -log2(e) / (2 sigma^2)
}

// The kernel in the Caracal document: row 12 of Pascal's triangle without its ends. The document calls it a Gaussian of
// sigma 2. The printed digits sum to 1.000001.
const GAUSSIAN_CARACAL_CENTER: f32 = 0.227027 / 1.000001;
const GAUSSIAN_CARACAL_SIDE = vec4f(0.194596, 0.121621, 0.054054, 0.016216) / 1.000001;

fn gaussian_weight(distance: i32, params: Gaussian) -> f32 {
    return exp2(f32(distance * distance) * params.falloff);
}

// Both taps at a distance, at texel centers.
fn gaussian_pair(source: texture_2d<f32>, at: Point, distance: i32, params: Gaussian) -> vec4f {
    let offset = distance * params.axis;
    return texel(source, at.pixel - offset) + texel(source, at.pixel + offset);
}

// Both taps at a distance between texel centers, where the sampler weights two texels in one read.
fn gaussian_tap_pair(
    source: texture_2d<f32>,
    source_sampler: sampler,
    at: Point,
    distance: f32,
    params: Gaussian,
) -> vec4f {
    let offset = distance * vec2f(params.axis) / vec2f(textureDimensions(source));
    return tap(source, source_sampler, at.uv - offset) + tap(source, source_sampler, at.uv + offset);
}

fn gaussian_exact(source: texture_2d<f32>, at: Point, params: Gaussian) -> vec4f {
    var sum = texel(source, at.pixel);
    // The weights are normalized by their sum, so a constant image stays constant however `exp2` rounds.
    var total = 1.0;
    for (var i = 1; i <= params.radius; i++) {
        let weight = gaussian_weight(i, params);
        sum += weight * gaussian_pair(source, at, i, params);
        total += 2.0 * weight;
    }
    return sum / total;
}

fn gaussian_linear(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Gaussian) -> vec4f {
    var sum = texel(source, at.pixel);
    var total = 1.0;
    for (var i = 1; i <= params.radius; i += 2) {
        let near = gaussian_weight(i, params);
        let far = select(0.0, gaussian_weight(i + 1, params), i < params.radius);
        let weight = near + far;
        sum += weight * gaussian_tap_pair(source, source_sampler, at, f32(i) + far / weight, params);
        total += 2.0 * weight;
    }
    return sum / total;
}

fn gaussian_caracal_exact(source: texture_2d<f32>, at: Point, params: Gaussian) -> vec4f {
    return GAUSSIAN_CARACAL_CENTER * texel(source, at.pixel)
        + GAUSSIAN_CARACAL_SIDE.x * gaussian_pair(source, at, 1, params)
        + GAUSSIAN_CARACAL_SIDE.y * gaussian_pair(source, at, 2, params)
        + GAUSSIAN_CARACAL_SIDE.z * gaussian_pair(source, at, 3, params)
        + GAUSSIAN_CARACAL_SIDE.w * gaussian_pair(source, at, 4, params);
}

fn gaussian_caracal_linear(source: texture_2d<f32>, source_sampler: sampler, at: Point, params: Gaussian) -> vec4f {
    let near = GAUSSIAN_CARACAL_SIDE.x + GAUSSIAN_CARACAL_SIDE.y;
    let far = GAUSSIAN_CARACAL_SIDE.z + GAUSSIAN_CARACAL_SIDE.w;
    let near_at = 1.0 + GAUSSIAN_CARACAL_SIDE.y / near;
    let far_at = 3.0 + GAUSSIAN_CARACAL_SIDE.w / far;
    return GAUSSIAN_CARACAL_CENTER * texel(source, at.pixel)
        + near * gaussian_tap_pair(source, source_sampler, at, near_at, params)
        + far * gaussian_tap_pair(source, source_sampler, at, far_at, params);
}

// The enlargement of a blur that was made at a lower resolution.
fn gaussian_enlarged(small: texture_2d<f32>, small_sampler: sampler, at: Point) -> vec4f {
    return tap_tent(small, small_sampler, at.uv, 1.0, false);
}
