// Lines along the edges of surfaces. The inverse of the depth is linear on a plane in perspective, so its second
// difference is 0 on planes of any slope, and large at steps and folds.
import afterimage::depth::depth_inverse;
import afterimage::grade::bounded_scene;
import afterimage::math::{between3, smooth_step};

struct Outline {
    amount: f32,
    color: vec3f,
    width: i32,
    depth_threshold: f32,
    normal_threshold: f32,
}

// The second difference of the inverse depth along an axis, as a share of it.
fn outline_fold(depth: texture_2d<f32>, p: vec2i, step: vec2i) -> f32 {
    let center = depth_inverse(depth, p);
    return abs(depth_inverse(depth, p - step) + depth_inverse(depth, p + step) - 2.0 * center) / center;
}

fn outline_depth_edge(depth: texture_2d<f32>, p: vec2i, params: Outline) -> f32 {
    let across = outline_fold(depth, p, vec2i(params.width, 0));
    let down = outline_fold(depth, p, vec2i(0, params.width));
    return smooth_step(params.depth_threshold, 2.0 * params.depth_threshold, max(across, down));
}

// A unit vector, or the zero vector.
fn outline_unit(v: vec3f) -> vec3f {
    return v / max(length(v), 1e-3);
}

// 1 minus the cosine between the normals at both sides of a pixel.
fn outline_turn(normal: texture_2d<f32>, p: vec2i, step: vec2i) -> f32 {
    return 1.0 - dot(outline_unit(texel(normal, p - step).xyz), outline_unit(texel(normal, p + step).xyz));
}

fn outline_drawn(source: vec4f, edge: f32, params: Outline) -> vec4f {
    let covered = params.amount * edge;
    let alpha = source.a + covered * (1.0 - source.a);
    return vec4f(bounded_scene(between3(source.rgb, params.color, covered)), alpha);
}

fn outline(source: vec4f, depth: texture_2d<f32>, at: Point, params: Outline) -> vec4f {
    return outline_drawn(source, outline_depth_edge(depth, at.pixel, params), params);
}

fn outline_normals(
    source: vec4f,
    depth: texture_2d<f32>,
    normal: texture_2d<f32>,
    at: Point,
    params: Outline,
) -> vec4f {
    let across = outline_turn(normal, at.pixel, vec2i(params.width, 0));
    let down = outline_turn(normal, at.pixel, vec2i(0, params.width));
    let turn = smooth_step(params.normal_threshold, 2.0 * params.normal_threshold, max(across, down));
    let edge = max(outline_depth_edge(depth, at.pixel, params), turn);
    return outline_drawn(source, edge, params);
}
