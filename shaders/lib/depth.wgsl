// Surfaces in images of distances along the view axis. The inverse of the distance is linear on a plane that is seen in
// perspective, so planes of any slope are found again.
import package::sanitize::HALF_MAX;

// A number of a depth image as a distance, from 1 mm to 65504 m. No surface has 0 or less: nothing was drawn there, so
// it is the far end. A NaN that no neighbor repairs is read as 0.
fn depth_distance(number: f32) -> f32 {
    return select(HALF_MAX, clamp(number, 1e-3, HALF_MAX), number > 0.0);
}

// The distance at a texel.
fn depth_at(depth: texture_2d<f32>, p: vec2i) -> f32 {
    return depth_distance(texel(depth, p).x);
}

// The inverse of the distance at a texel: from 1/65504 to 1000.
fn depth_inverse(depth: texture_2d<f32>, p: vec2i) -> f32 {
    return 1.0 / depth_at(depth, p);
}

// The change of the inverse from a texel to the next on the surface that the texel shows: the smaller one of the
// differences to both sides, because the other one may lead over an edge.
fn depth_slope(depth: texture_2d<f32>, p: vec2i, step: vec2i) -> f32 {
    let middle = depth_inverse(depth, p);
    let after = depth_inverse(depth, p + step) - middle;
    let before = middle - depth_inverse(depth, p - step);
    let has_after = all(p + step < vec2i(textureDimensions(depth)));
    let has_before = all(p >= step);
    let is_after = has_after && (!has_before || abs(after) < abs(before));
    return select(before, after, is_after);
}

// 1 for a surface where it is expected, falling to 0 at a distance of `threshold` as a share of `middle`. All but the
// share are inverses of distances.
fn depth_likeness(expected: f32, found: f32, middle: f32, threshold: f32) -> f32 {
    let off = min(abs(found - expected) / (middle * threshold), 1.0);
    return 1.0 - off * off;
}
